//! The file of a part: an EXR picture, behind it the state, and at the very end the length of the state.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use flate2::Crc;

use super::PartHeader;
use crate::files::{self, FileError, LARGEST_DATA, write_atomically_with};
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::film::Film;
use crate::render::tile::Tile;

/// The version of the format of the state.
const FORMAT: u32 = 1;
const MAGIC: &[u8; 8] = b"SUNROOM+";
/// The checksum, the length of the state, and [`MAGIC`].
const TAIL: u64 = 4 + 8 + 8;
/// The longest header in bytes: it has the names of all shapes.
const LONGEST_HEADER: u32 = 1 << 30;

/// The reason why a part cannot be read. The messages do not name the file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum PartError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error("has a picture, but not the exact sums of a part or a checkpoint")]
    NoState,
    #[error("was written by another version of Sunroom, in a format that this version does not read")]
    Format,
    #[error(transparent)]
    Damaged(#[from] Damaged),
}

/// Writes a part in one step: after a failure the old file is there. `picture` is the content of an EXR file, `tiles` are those of the part that have samples,
/// and `job` is what the engine knows.
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
        let mut state = State {
            file,
            crc: Crc::new(),
            length: 0,
        };
        let text = serde_json::to_vec(header)?;
        let mut start = Writer::default();
        start.u32(FORMAT);
        start.u32(text.len() as u32);
        start.0.extend(text);
        start.u32(tiles.len() as u32);
        state.write(&start.0)?;
        for &tile in tiles {
            let mut content = Writer::default();
            film.write_tile(tile, &mut content);
            let mut start = Writer::default();
            [tile.x, tile.y, tile.width, tile.height]
                .into_iter()
                .for_each(|number| start.u32(number));
            start.u32(content.0.len() as u32);
            state.write(&start.0)?;
            state.write(&content.0)?;
        }
        let mut end = Writer::default();
        end.u32(job.len() as u32);
        end.0.extend_from_slice(job);
        state.write(&end.0)?;
        let mut tail = Writer::default();
        tail.u32(state.crc.sum());
        tail.u64(state.length);
        tail.0.extend_from_slice(MAGIC);
        state.file.write_all(&tail.0)
    })
}

struct State<'a> {
    file: &'a mut dyn Write,
    crc: Crc,
    length: u64,
}

impl State<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.crc.update(bytes);
        self.length += bytes.len() as u64;
        self.file.write_all(bytes)
    }
}

/// The file of a part, of which the header was read.
pub struct PartFile {
    path: PathBuf,
    header: PartHeader,
    /// Where the state begins, and its length.
    state: [u64; 2],
    /// Where the tiles begin in the state.
    tiles_at: u64,
}

impl PartFile {
    /// Reads the header.
    pub fn open(path: &Path) -> Result<Self, PartError> {
        let mut file = files::open(path, LARGEST_DATA)?;
        let length = file.metadata()?.len();
        let tail_at = length.checked_sub(TAIL).ok_or(PartError::NoState)?;
        file.seek(SeekFrom::Start(tail_at))?;
        let mut tail = [0; TAIL as usize];
        file.read_exact(&mut tail)?;
        let mut tail = Reader(&tail);
        let (_, state_length) = (tail.u32()?, tail.u64()?);
        if tail.0 != MAGIC {
            return Err(PartError::NoState);
        }
        let start = tail_at.checked_sub(state_length).ok_or(Damaged)?;
        file.seek(SeekFrom::Start(start))?;
        let mut file = file.take(state_length);
        if read_u32(&mut file)? != FORMAT {
            return Err(PartError::Format);
        }
        let length = read_u32(&mut file)?;
        if length > LONGEST_HEADER {
            return Err(Damaged.into());
        }
        let mut text = Vec::new();
        (&mut file).take(length.into()).read_to_end(&mut text)?;
        let header: PartHeader = serde_json::from_slice(&text).map_err(|_| Damaged)?;
        if !header.is_possible() {
            return Err(Damaged.into());
        }
        Ok(Self {
            path: path.to_owned(),
            header,
            state: [start, state_length],
            tiles_at: 8 + u64::from(length),
        })
    }

    /// What the file says of its part.
    pub fn header(&self) -> &PartHeader {
        &self.header
    }

    /// Adds the samples to a film of the picture's size and layers, and returns what the engine has written of its job. The film is spoilt after an error.
    pub fn read_into(&self, film: &mut Film) -> Result<Vec<u8>, PartError> {
        let mut file = files::open(&self.path, LARGEST_DATA)?;
        let [start, length] = self.state;
        self.check_sum(&mut file)?;
        file.seek(SeekFrom::Start(start + self.tiles_at))?;
        let mut file = BufReader::new(file.take(length - self.tiles_at));
        let (all, mut content) = (self.header.crop, Vec::new());
        for _ in 0..read_u32(&mut file)? {
            let [x, y, width, height] = [
                read_u32(&mut file)?,
                read_u32(&mut file)?,
                read_u32(&mut file)?,
                read_u32(&mut file)?,
            ];
            let tile = Tile { x, y, width, height };
            let mut known = all.tiles(self.header.width, self.header.height);
            if !known.any(|known| known == tile) {
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
        let length = read_u32(&mut file)?;
        let mut job = Vec::new();
        file.take(length.into()).read_to_end(&mut job)?;
        Ok(job)
    }

    fn check_sum(&self, file: &mut File) -> Result<(), PartError> {
        let [start, length] = self.state;
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
