//! The state at the end of a part, of a picture or of a bake: the version of the format, a header in JSON, the exact
//! sums, a checksum, the length of the state, and a mark at the very end.

use std::io::{self, Read, Seek, SeekFrom, Take, Write};

use bytemuck::{NoUninit, Pod};
use flate2::Crc;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::PartError;
use crate::render::bytes::{Damaged, Writer};

/// The version of the format of the state. The version of samples is [`Origin::SAMPLES`](super::Origin::SAMPLES).
pub(crate) const FORMAT: u32 = 6;
const MAGIC: &[u8; 8] = b"SUNROOM+";
/// Bytes of the checksum, the length of the state, and [`MAGIC`].
const TAIL: u64 = 4 + 8 + 8;
/// The longest header in bytes: it has the names of all shapes.
const LONGEST_HEADER: usize = 1 << 26;

/// Writes a state, and counts the checksum and the length of the bytes written so far.
pub(crate) struct StateWriter<'a> {
    file: &'a mut dyn Write,
    crc: Crc,
    length: u64,
}

impl StateWriter<'_> {
    /// Writes bytes.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.crc.update(bytes);
        self.length += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    /// Writes a number, or an array or tuple of numbers.
    pub fn put(&mut self, value: impl NoUninit) -> io::Result<()> {
        self.write(bytemuck::bytes_of(&value))
    }
}

/// Appends a state to a file: a header, and the bytes written by `write`.
pub(crate) fn write_state(
    file: &mut dyn Write,
    header: &impl Serialize,
    write: impl FnOnce(&mut StateWriter) -> io::Result<()>,
) -> io::Result<()> {
    let (crc, length) = (Crc::new(), 0);
    let mut state = StateWriter { file, crc, length };
    let text = serde_json::to_vec(header)?;
    if text.len() > LONGEST_HEADER {
        return Err(io::Error::other("the names of the shapes are too long for a part"));
    }
    state.put([FORMAT, text.len() as u32])?;
    state.write(&text)?;
    write(&mut state)?;
    let mut tail = Writer::default();
    tail.put(state.crc.sum());
    tail.put(state.length);
    tail.put(*MAGIC);
    state.file.write_all(&tail.0)
}

/// Reads the header of the state at the end of a file, after checking the checksum. Also returns a reader of the bytes
/// after the header.
pub(crate) fn open_state<H: DeserializeOwned, F: Read + Seek>(file: &mut F) -> Result<(H, Take<&mut F>), PartError> {
    let length = file.seek(SeekFrom::End(0))?;
    let tail_at = length.checked_sub(TAIL).ok_or(PartError::NoState)?;
    file.seek(SeekFrom::Start(tail_at))?;
    let (sum, length, magic): (u32, u64, [u8; 8]) = (read(file)?, read(file)?, read(file)?);
    if magic != *MAGIC {
        return Err(PartError::NoState);
    }
    let start = tail_at.checked_sub(length).ok_or(Damaged)?;
    file.seek(SeekFrom::Start(start))?;
    let (mut crc, mut buffer, mut state) = (Crc::new(), vec![0; 1 << 20], file.take(length));
    loop {
        match state.read(&mut buffer)? {
            0 => break,
            count => crc.update(&buffer[..count]),
        }
    }
    Damaged::unless(crc.sum() == sum)?;
    file.seek(SeekFrom::Start(start))?;
    let mut state = file.take(length);
    if read::<u32>(&mut state)? != FORMAT {
        return Err(PartError::Format);
    }
    let length = read::<u32>(&mut state)? as usize;
    Damaged::unless(length <= LONGEST_HEADER)?;
    let mut text = Vec::new();
    (&mut state).take(length as u64).read_to_end(&mut text)?;
    Damaged::unless(text.len() == length)?;
    Ok((serde_json::from_slice(&text).map_err(|_| Damaged)?, state))
}

/// Reads a number, or an array of numbers.
pub(super) fn read<T: Pod>(file: &mut impl Read) -> Result<T, PartError> {
    let mut value = T::zeroed();
    match file.read_exact(bytemuck::bytes_of_mut(&mut value)) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Err(Damaged.into()),
        read => Ok(read.map(|()| value)?),
    }
}
