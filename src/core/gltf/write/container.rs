//! Writes the files: one binary container (section 4.4), or JSON with files for the buffer and the pictures.

use super::model::{Buffer, FileExtras, Image, Profile};
use super::{GltfWriteError, GltfWriter};
use crate::gltf::plain_character;

/// A file named by the `.gltf` file, in the same folder.
#[derive(Clone, Debug, PartialEq)]
pub struct BesideFile {
    /// The name, of letters, digits and `-_. ` only.
    pub name: String,
    /// The content.
    pub bytes: Vec<u8>,
}

/// The media type of light profiles in buffers.
const PROFILE_TYPE: &str = "application/x-ies-lm-63";

impl GltfWriter {
    /// The `.glb` file, which names no other files.
    pub fn binary(mut self) -> Result<Vec<u8>, GltfWriteError> {
        for picture in std::mem::take(&mut self.pictures) {
            let mime_type = Some(picture.kind().1);
            let buffer_view = Some(self.add_view(picture.bytes, None));
            self.root.images.push(Image {
                name: picture.name,
                uri: None,
                mime_type,
                buffer_view,
                extras: None,
            });
        }
        for profile in std::mem::take(&mut self.profiles) {
            let buffer_view = Some(self.add_view(profile, None));
            self.root.extensions.profiles.lights.push(Profile {
                mime_type: Some(PROFILE_TYPE),
                buffer_view,
                ..Profile::default()
            });
        }
        let mut data = std::mem::take(&mut self.bytes);
        data.resize(data.len().next_multiple_of(4), 0);
        if !data.is_empty() {
            self.root.buffers.push(Buffer {
                byte_length: data.len(),
                uri: None,
                extras: None,
            });
        }
        let mut json = self.json(false)?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let chunks: &[(&[u8; 4], &[u8])] = match data.is_empty() {
            true => &[(b"JSON", &json)],
            false => &[(b"JSON", &json), (b"BIN\0", &data)],
        };
        let length: u64 = 12 + chunks.iter().map(|(_, chunk)| 8 + chunk.len() as u64).sum::<u64>();
        let word = |number: u64| u32::try_from(number).map(u32::to_le_bytes);
        let long = |_| GltfWriteError::Long(length);
        let mut bytes = Vec::with_capacity(length as usize);
        bytes.extend(b"glTF");
        bytes.extend(2u32.to_le_bytes());
        bytes.extend(word(length).map_err(long)?);
        for (kind, chunk) in chunks {
            bytes.extend(word(chunk.len() as u64).map_err(long)?);
            bytes.extend(*kind);
            bytes.extend(*chunk);
        }
        Ok(bytes)
    }

    /// The text of the `.gltf` file, and the files that it names. Their names begin with `stem`, in which characters
    /// other than letters, digits and `-_. ` are replaced.
    pub fn text(mut self, stem: &str) -> Result<(Vec<u8>, Vec<BesideFile>), GltfWriteError> {
        let stem: String = stem.chars().map(plain_character).collect();
        let mut files: Vec<BesideFile> = Vec::new();
        for (index, picture) in std::mem::take(&mut self.pictures).into_iter().enumerate() {
            let name = format!("{stem}-picture-{index}.{}", picture.kind().0);
            self.root.images.push(Image {
                name: picture.name,
                uri: Some(escaped(&name)),
                mime_type: None,
                buffer_view: None,
                extras: FileExtras::of(&picture.bytes),
            });
            let bytes = picture.bytes;
            files.push(BesideFile { name, bytes });
        }
        for (index, bytes) in std::mem::take(&mut self.profiles).into_iter().enumerate() {
            let name = format!("{stem}-lamp-{index}.ies");
            self.root.extensions.profiles.lights.push(Profile {
                uri: Some(escaped(&name)),
                ..Profile::default()
            });
            files.push(BesideFile { name, bytes });
        }
        let bytes = std::mem::take(&mut self.bytes);
        if !bytes.is_empty() {
            let name = format!("{stem}.bin");
            self.root.buffers.push(Buffer {
                byte_length: bytes.len(),
                uri: Some(escaped(&name)),
                extras: FileExtras::of(&bytes),
            });
            files.push(BesideFile { name, bytes });
        }
        Ok((self.json(true)?, files))
    }

    fn json(mut self, for_people: bool) -> Result<Vec<u8>, GltfWriteError> {
        if self.root.scenes.is_empty() {
            self.root.scenes.push(Default::default());
        }
        self.root.extensions_used = self.root.used_extensions();
        let json = match for_people {
            true => serde_json::to_vec_pretty(&self.root),
            false => serde_json::to_vec(&self.root),
        };
        json.map_err(|error| GltfWriteError::Json(error.to_string()))
    }
}

/// A file's name as a URI (RFC 3986).
fn escaped(name: &str) -> String {
    let escape = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    };
    name.bytes().map(escape).collect()
}
