//! The file of a part: an EXR picture, behind it the state, and at the very end the length of the state.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use flate2::Crc;

use super::PartHeader;
use crate::files::{Access, FileError, LARGEST_DATA, write_atomically_with};
use crate::render::bytes::{Damaged, Reader, SummedFile, Writer};
use crate::render::film::Film;
use crate::render::tile::Tile;
use crate::texture::is_exr;

/// The version of the format of the state.
const FORMAT: u32 = 6;
const MAGIC: &[u8; 8] = b"SUNROOM+";
/// The checksum, the length of the state, and [`MAGIC`].
const TAIL: u64 = 4 + 8 + 8;
/// The longest header in bytes: it has the names of all shapes.
const LONGEST_HEADER: usize = 1 << 26;

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

/// Writes a part in one step: after a failure the old file is there. `picture` is the content of an EXR file, `tiles`
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
        let mut state = SummedFile::new(file);
        let text = serde_json::to_vec(header)?;
        if text.len() > LONGEST_HEADER {
            return Err(io::Error::other("the names of the shapes are too long for a part"));
        }
        let mut start = Writer::default();
        start.put([FORMAT, text.len() as u32]);
        start.0.extend(text);
        start.put(tiles.len() as u32);
        state.write(&start.0)?;
        for &tile in tiles {
            let mut content = Writer::default();
            film.write_tile(tile, &mut content);
            let mut start = Writer::default();
            start.put([tile.x, tile.y, tile.width, tile.height, content.0.len() as u32]);
            state.write(&start.0)?;
            state.write(&content.0)?;
        }
        let mut splats = Writer::default();
        film.write_splats(&mut splats);
        let mut length = Writer::default();
        length.put(splats.0.len() as u64);
        state.write(&length.0)?;
        state.write(&splats.0)?;
        let mut end = Writer::default();
        end.put(job.len() as u32);
        end.0.extend_from_slice(job);
        state.write(&end.0)?;
        let mut tail = Writer::default();
        tail.put(state.crc.sum());
        tail.put(state.length);
        tail.0.extend_from_slice(MAGIC);
        state.file.write_all(&tail.0)
    })
}

/// The file of a part, of which the header was read.
pub struct PartFile {
    path: PathBuf,
    access: Access,
    header: PartHeader,
    /// Where the state begins, and its length.
    state: [u64; 2],
    /// Where the tiles begin in the state.
    tiles_at: u64,
}

impl PartFile {
    /// Reads the header.
    pub fn open(path: &Path) -> Result<Self, PartError> {
        Self::open_within(path, &Access::everywhere())
    }

    /// [`Self::open`] for a file that comes from others, and is opened as far as `access` permits.
    pub fn open_within(path: &Path, access: &Access) -> Result<Self, PartError> {
        let mut file = access.open_apart(path, LARGEST_DATA)?;
        let length = file.metadata()?.len();
        let mut start = Vec::new();
        (&mut file).take(4).read_to_end(&mut start)?;
        if !is_exr(&start) {
            return Err(PartError::NoPicture);
        }
        let tail_at = length.checked_sub(TAIL).ok_or(PartError::NoState)?;
        file.seek(SeekFrom::Start(tail_at))?;
        let mut tail = [0; TAIL as usize];
        file.read_exact(&mut tail)?;
        let mut tail = Reader(&tail);
        let (_, state_length) = (tail.take::<u32>()?, tail.take::<u64>()?);
        if tail.0 != MAGIC {
            return Err(PartError::NoState);
        }
        let start = tail_at.checked_sub(state_length).ok_or(Damaged)?;
        check_sum(&mut file, [start, state_length])?;
        file.seek(SeekFrom::Start(start))?;
        let mut file = file.take(state_length);
        if read_u32(&mut file)? != FORMAT {
            return Err(PartError::Format);
        }
        let length = read_u32(&mut file)? as usize;
        if length > LONGEST_HEADER {
            return Err(Damaged.into());
        }
        let mut text = Vec::new();
        (&mut file).take(length as u64).read_to_end(&mut text)?;
        if text.len() != length {
            return Err(Damaged.into());
        }
        let header: PartHeader = serde_json::from_slice(&text).map_err(|_| Damaged)?;
        if !header.is_possible() {
            return Err(Damaged.into());
        }
        Ok(Self {
            path: path.to_owned(),
            access: access.clone(),
            header,
            state: [start, state_length],
            tiles_at: 8 + length as u64,
        })
    }

    /// What the file says of its part.
    pub fn header(&self) -> &PartHeader {
        &self.header
    }

    /// Adds the samples to a film of the picture's size and layers, and returns what the engine has written of its job.
    /// The film is spoilt after an error.
    pub fn read_into(&self, film: &mut Film) -> Result<Vec<u8>, PartError> {
        let mut file = self.access.open_apart(&self.path, LARGEST_DATA)?;
        let [start, length] = self.state;
        // Another file may have its name by now.
        check_sum(&mut file, self.state)?;
        file.seek(SeekFrom::Start(start + self.tiles_at))?;
        let mut file = BufReader::new(file.take(length - self.tiles_at));
        let tiles = self.header.crop.tiles(self.header.width, self.header.height);
        let (mut missing, mut content): (HashSet<Tile>, _) = (tiles.collect(), Vec::new());
        for _ in 0..read_u32(&mut file)? {
            let [x, y, width, height] = [
                read_u32(&mut file)?,
                read_u32(&mut file)?,
                read_u32(&mut file)?,
                read_u32(&mut file)?,
            ];
            let tile = Tile { x, y, width, height };
            if !missing.remove(&tile) {
                return Err(Damaged.into());
            }
            let length = read_u32(&mut file)?;
            content.clear();
            (&mut file).take(length.into()).read_to_end(&mut content)?;
            let end = film.read_tile(tile, &mut Reader(&content))?;
            if self.header.is_finished && end != Some(self.header.samples[1]) {
                return Err(Damaged.into());
            }
        }
        if self.header.is_finished && !missing.is_empty() {
            return Err(Damaged.into());
        }
        let length = u64::from(read_u32(&mut file)?) | u64::from(read_u32(&mut file)?) << 32;
        content.clear();
        (&mut file).take(length).read_to_end(&mut content)?;
        film.read_splats(&mut Reader(&content))?;
        let length = read_u32(&mut file)?;
        let mut job = Vec::new();
        file.take(length.into()).read_to_end(&mut job)?;
        Ok(job)
    }
}

/// An error if the state at this place, of this length, has another checksum than the one behind it.
fn check_sum(file: &mut File, [start, length]: [u64; 2]) -> Result<(), PartError> {
    file.seek(SeekFrom::Start(start))?;
    let (mut crc, mut buffer, mut state) = (Crc::new(), vec![0; 1 << 20], file.take(length));
    loop {
        match state.read(&mut buffer)? {
            0 => break,
            count => crc.update(&buffer[..count]),
        }
    }
    match read_u32(file)? == crc.sum() {
        true => Ok(()),
        false => Err(Damaged.into()),
    }
}

impl PartHeader {
    /// Whether the numbers can be those of a picture.
    fn is_possible(&self) -> bool {
        const MOST: u32 = 1 << 16;
        let sides = [self.width, self.height];
        sides.iter().all(|side| (1..=MOST).contains(side))
            && self.crop.check(self.width, self.height).is_ok()
            && self.samples[0] < self.samples[1]
    }
}

fn read_u32(file: &mut impl Read) -> Result<u32, PartError> {
    let mut bytes = [0; 4];
    match file.read_exact(&mut bytes) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Err(Damaged.into()),
        read => Ok(read.map(|()| u32::from_le_bytes(bytes))?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
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

    /// What reading a part with these tiles of an empty film gives.
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
            let mut crc = Crc::new();
            crc.update(&state.0);
            let length = state.0.len() as u64;
            state.put(crc.sum());
            state.put(length);
            state.0.extend_from_slice(MAGIC);
            std::fs::write(&path, [EXR, &state.0].concat()).expect("a writable folder");
            assert_eq!(PartFile::open(&path).is_ok(), is_whole, "{more}");
            std::fs::write(&path, &state.0).expect("a writable folder");
            assert!(matches!(PartFile::open(&path), Err(PartError::NoPicture)));
        }
    }
}
