//! Reads scene files from disk: limited in size, and checked to be text.

use std::path::{Path, PathBuf};

use crate::files::{Access, FileError};

/// The most bytes of a file. Larger files are no scene descriptions, and spans have 32 bits.
pub const MAX_FILE_BYTES: u64 = 256 << 20;

/// The reason why a file cannot be read as text.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum SourceError {
    #[error("{}: {source}", path.display())]
    Unreadable { path: PathBuf, source: FileError },
    #[error("{}: is {kind}, not a scene file; {advice}", path.display())]
    Foreign {
        path: PathBuf,
        kind: &'static str,
        advice: &'static str,
    },
    #[error("{}: is UTF-16 text; save it as UTF-8", path.display())]
    Utf16 { path: PathBuf },
    #[error("{}:{line}:{column}: is not UTF-8 text from here on; save the file as UTF-8", path.display())]
    NotUtf8 { path: PathBuf, line: usize, column: usize },
}

/// The text of a file, with its byte order mark if it has one.
pub fn read_text(path: &Path) -> Result<String, SourceError> {
    read_text_within(path, &Access::everywhere())
}

/// Reads a file that a scene names, as [`read_text`] does, if `access` permits it.
pub(crate) fn read_text_within(path: &Path, access: &Access) -> Result<String, SourceError> {
    let bytes = access
        .read(path, MAX_FILE_BYTES)
        .map_err(|source| unreadable(path, source))?;
    decode(bytes, path)
}

/// An error that names the file.
pub fn unreadable(path: &Path, source: FileError) -> SourceError {
    SourceError::Unreadable {
        path: path.to_owned(),
        source,
    }
}

/// The text in a file's bytes, with its byte order mark if it has one; `path` is for the message.
pub fn decode(bytes: Vec<u8>, path: &Path) -> Result<String, SourceError> {
    if bytes.len() as u64 > MAX_FILE_BYTES {
        let limit = MAX_FILE_BYTES;
        return Err(unreadable(path, FileError::TooLarge { limit }));
    }
    if matches!(
        bytes[..],
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [b'<', 0, ..] | [0, b'<', ..]
    ) {
        return Err(SourceError::Utf16 { path: path.to_owned() });
    }
    if let Some((kind, advice)) = foreign(&bytes, path) {
        let path = path.to_owned();
        return Err(SourceError::Foreign { path, kind, advice });
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line_start = good
            .iter()
            .rposition(|byte| *byte == b'\n')
            .map_or(0, |newline| newline + 1);
        let in_line = String::from_utf8_lossy(&good[line_start..]);
        SourceError::NotUtf8 {
            path: path.to_owned(),
            line: good.iter().filter(|byte| **byte == b'\n').count() + 1,
            column: in_line.chars().count() + 1,
        }
    })
}

/// Signatures of files that people take for scenes, with their format and advice.
const FOREIGN: [(&[u8], &str, &str); 14] = [
    (b"\x89PNG", "a PNG picture", PICTURE),
    (b"\xff\xd8\xff", "a JPEG picture", PICTURE),
    (b"\x76\x2f\x31\x01", "an OpenEXR picture", PICTURE),
    (b"#?RADIANCE", "a Radiance HDR picture", PICTURE),
    (b"#?RGBE", "a Radiance HDR picture", PICTURE),
    (b"PF\n", "a PFM picture", PICTURE),
    (b"Pf\n", "a PFM picture", PICTURE),
    (b"GIF8", "a GIF picture", "convert it to PNG to use it"),
    (b"ply\n", "a PLY mesh", MESH),
    (b"ply\r", "a PLY mesh", MESH),
    (b"\x1c\x04", "a file of serialized meshes", MESH),
    (b"PK\x03\x04", "a ZIP archive", "unpack it first"),
    (b"\x1f\x8b", "a gzip archive", "unpack it first"),
    (b"BLENDER", "a Blender file", "export it as glTF"),
];
const PICTURE: &str = "import it into a scene as its environment, or choose it as a texture";
const MESH: &str = "import it into a scene, or name it in a <shape>";
const BINARY: (&str, &str) = ("binary data", "scenes are XML text or glTF");

/// The format of a file that is no text of a scene, and advice.
fn foreign(bytes: &[u8], path: &Path) -> Option<(&'static str, &'static str)> {
    let known = FOREIGN.iter().find(|(magic, ..)| bytes.starts_with(magic));
    if let Some((_, kind, advice)) = known {
        return Some((kind, advice));
    }
    let extension = path.extension().unwrap_or_default();
    let is_markup = bytes.trim_ascii_start().starts_with(b"<");
    if extension.eq_ignore_ascii_case("obj") && !is_markup {
        return Some(("an OBJ mesh", MESH));
    }
    bytes[..bytes.len().min(4096)].contains(&0).then_some(BINARY)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_scene_is_said_with_what_can_be_done_with_it() {
        assert!(message(b"\x89PNG\r\n\x1a\n").starts_with("a.xml: is a PNG picture, not a scene file; import it"));
        assert!(message(b"ply\nformat ascii 1.0\n").contains("a PLY mesh"));
        assert!(message(b"\x7fELF\x02\0\0").contains("binary data"));
        let mesh = decode(b"v 0 0 0\n".to_vec(), Path::new("a.OBJ")).unwrap_err();
        assert!(mesh.to_string().contains("an OBJ mesh"));
        assert!(decode(b" <scene/>".to_vec(), Path::new("a.obj")).is_ok());
    }

    fn message(bytes: &[u8]) -> String {
        decode(bytes.to_vec(), Path::new("a.xml")).unwrap_err().to_string()
    }

    #[test]
    fn only_utf8_is_text() {
        assert_eq!(
            decode(b"\xef\xbb\xbf<a/>".to_vec(), Path::new("a.xml")).unwrap(),
            "\u{feff}<a/>"
        );
        assert!(message(b"\xff\xfe<\0").contains("UTF-16"));
        assert!(message(b"<\0s\0").contains("UTF-16"));
        assert!(message(b"<a>\n\xc3\xa9\xe9</a>").starts_with("a.xml:2:2: is not UTF-8"));
    }

    #[test]
    fn missing_files_and_folders_are_named() {
        assert!(
            read_text(Path::new("/no/such/file.xml"))
                .unwrap_err()
                .to_string()
                .starts_with("/no/such/file.xml: ")
        );
        let folder = std::env::temp_dir();
        let reason = |path: &Path| match read_text(path) {
            Err(SourceError::Unreadable { source, .. }) => source,
            other => panic!("{other:?}"),
        };
        assert!(matches!(reason(&folder), FileError::Folder));
        if cfg!(unix) {
            assert!(matches!(reason(Path::new("/dev/zero")), FileError::NotRegular { .. }));
        }
    }
}
