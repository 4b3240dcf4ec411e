//! The file of a part of a picture: an EXR picture, followed by the state.

use std::collections::HashSet;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use super::PartHeader;
use super::state::{open_state, read, write_state};
use crate::files::{Access, FileError, LARGEST_DATA, write_atomically_with};
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::film::Film;
use crate::render::tile::Tile;
use crate::texture::is_exr;

/// The reason why a part cannot be read. The messages do not name the file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum PartError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error("is no EXR file: a part of a picture is one")]
    NoPicture,
    #[error("has a picture, but not the exact sums of a part or a checkpoint")]
    NoState,
    #[error("was written by another version of Sunroom, in a format that this version does not read")]
    Format,
    #[error(transparent)]
    Damaged(#[from] Damaged),
}

/// Writes a part in one step: after a failure the old file is intact. `picture` is the content of an EXR file, `tiles`
/// are the tiles of the part that have samples, and `job` is the state of the engine's job.
pub fn write_part(
    path: &Path,
    picture: &[u8],
    header: &PartHeader,
    film: &Film,
    tiles: &[Tile],
    job: &[u8],
) -> io::Result<()> {
    write_atomically_with(path, |file| {
        file.write_all(picture)?;
        write_state(file, header, |state| {
            state.put(tiles.len() as u32)?;
            for &tile in tiles {
                let mut content = Writer::default();
                film.write_tile(tile, &mut content);
                state.put([tile.x, tile.y, tile.width, tile.height, content.0.len() as u32])?;
                state.write(&content.0)?;
            }
            let mut splats = Writer::default();
            film.write_splats(&mut splats);
            state.put(splats.0.len() as u64)?;
            state.write(&splats.0)?;
            state.put(job.len() as u32)?;
            state.write(job)
        })
    })
}

/// The open file of a part, with its header read.
pub struct PartFile {
    path: PathBuf,
    access: Access,
    header: PartHeader,
}

impl PartFile {
    /// Opens a part and reads its header.
    pub fn open(path: &Path) -> Result<Self, PartError> {
        Self::open_within(path, &Access::everywhere())
    }

    /// [`Self::open`] for a file from a third party, if `access` permits it.
    pub fn open_within(path: &Path, access: &Access) -> Result<Self, PartError> {
        let mut file = access.open_apart(path, LARGEST_DATA)?;
        let mut start = Vec::new();
        (&mut file).take(4).read_to_end(&mut start)?;
        if !is_exr(&start) {
            return Err(PartError::NoPicture);
        }
        let (header, _) = open_state::<PartHeader, _>(&mut file)?;
        Damaged::unless(header.is_possible())?;
        Ok(Self {
            path: path.to_owned(),
            access: access.clone(),
            header,
        })
    }

    /// The header of the part.
    pub fn header(&self) -> &PartHeader {
        &self.header
    }

    /// Adds the samples to a film of the picture's size and layers, and returns the state of the engine's job. After an
    /// error the film is invalid.
    pub fn read_into(&self, film: &mut Film) -> Result<Vec<u8>, PartError> {
        let mut file = self.access.open_apart(&self.path, LARGEST_DATA)?;
        let (header, state) = open_state::<PartHeader, _>(&mut file)?;
        // Another file may have replaced it meanwhile.
        Damaged::unless(header == self.header)?;
        let mut file = BufReader::new(state);
        let tiles = self.header.crop.tiles(self.header.width, self.header.height);
        let (mut missing, mut content): (HashSet<Tile>, _) = (tiles.collect(), Vec::new());
        for _ in 0..read::<u32>(&mut file)? {
            let [x, y, width, height, length]: [u32; 5] = read(&mut file)?;
            let tile = Tile { x, y, width, height };
            Damaged::unless(missing.remove(&tile))?;
            content.clear();
            (&mut file).take(length.into()).read_to_end(&mut content)?;
            let end = film.read_tile(tile, &mut Reader(&content))?;
            Damaged::unless(!header.is_finished || end == Some(header.samples[1]))?;
        }
        Damaged::unless(!header.is_finished || missing.is_empty())?;
        let length = read(&mut file)?;
        content.clear();
        (&mut file).take(length).read_to_end(&mut content)?;
        film.read_splats(&mut Reader(&content))?;
        let length: u32 = read(&mut file)?;
        let mut job = Vec::new();
        file.take(length.into()).read_to_end(&mut job)?;
        Ok(job)
    }
}

impl PartHeader {
    /// Whether the header can be that of a picture.
    fn is_possible(&self) -> bool {
        const MOST: u32 = 1 << 16;
        let sides = [self.width, self.height];
        sides.iter().all(|side| (1..=MOST).contains(side))
            && self.crop.check(self.width, self.height).is_ok()
            && self.samples[0] < self.samples[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::render::part::state::FORMAT;
    use crate::render::part::{About, Crop, Origin};
    use crate::render::tile::{PixelSum, TileSamples, tiles};

    /// The beginning of an EXR file.
    const EXR: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

    fn header() -> PartHeader {
        PartHeader {
            origin: Origin::default(),
            width: 64,
            height: 32,
            crop: Crop::whole(64, 32),
            samples: [0, 1],
            samples_of_whole: None,
            is_finished: false,
            layers: Vec::new(),
            splats: false,
            about: About::default(),
        }
    }

    /// The result of reading a part with these tiles of an empty film.
    fn read(tiles: &[Tile], is_finished: bool) -> Result<Vec<u8>, PartError> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("part.exr");
        let mut film = Film::new(64, 32);
        let header = PartHeader {
            is_finished,
            ..header()
        };
        write_part(&path, EXR, &header, &film, tiles, &[7]).expect("a writable folder");
        PartFile::open(&path)?.read_into(&mut film)
    }

    #[test]
    fn each_tile_comes_once_and_a_finished_part_has_all() {
        let tiles = tiles(64, 32);
        assert_eq!(read(&tiles[..1], false).expect("a checkpoint"), [7]);
        for (tiles, is_finished) in [(&tiles[..0], true), (&[tiles[0], tiles[0]], false)] {
            let result = read(tiles, is_finished);
            assert!(matches!(result, Err(PartError::Damaged(_))), "{tiles:?}");
        }
    }

    #[test]
    fn sums_that_are_no_numbers_are_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("part.exr");
        let tile = tiles(64, 32)[0];
        for (light, is_good) in [(1.0, true), (f32::NAN, false), (f32::INFINITY, false)] {
            let sum = PixelSum {
                radiance: Rgb::splat(light),
                ..PixelSum::default()
            };
            let mut film = Film::new(64, 32);
            film.add(&TileSamples::of_pixels(tile, 0..1, vec![sum; 32 * 32]));
            write_part(&path, EXR, &header(), &film, &[tile], &[]).expect("a writable folder");
            let file = PartFile::open(&path).expect("a whole file");
            assert_eq!(file.read_into(&mut Film::new(64, 32)).is_ok(), is_good, "{light}");
        }
    }

    #[test]
    fn a_header_has_its_stated_length() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("part.exr");
        let text = serde_json::to_vec(&header()).expect("JSON");
        for (more, is_whole) in [(0, true), (1, false), (1 << 20, false)] {
            let mut state = Writer::default();
            state.put([FORMAT, text.len() as u32 + more]);
            state.0.extend(&text);
            let mut crc = flate2::Crc::new();
            crc.update(&state.0);
            let length = state.0.len() as u64;
            state.put(crc.sum());
            state.put(length);
            state.put(*b"SUNROOM+");
            std::fs::write(&path, [EXR, &state.0].concat()).expect("a writable folder");
            assert_eq!(PartFile::open(&path).is_ok(), is_whole, "{more}");
            std::fs::write(&path, &state.0).expect("a writable folder");
            assert!(matches!(PartFile::open(&path), Err(PartError::NoPicture)));
        }
    }
}
