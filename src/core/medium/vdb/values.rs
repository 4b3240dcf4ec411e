//! Unpacks the values of nodes.

use flate2::{Decompress, FlushDecompress, Status};
use half::f16;

use super::bytes::Bytes;
use super::header::Compression;
use super::{VdbError, blosc};
use crate::medium::Voxels;

/// One number of a voxel's value.
pub(super) trait Component: Copy + PartialEq {
    fn from_half(number: f16) -> Self;
    fn from_single(number: f32) -> Self;
    fn negated(self) -> Self;
    fn voxels(numbers: Vec<Self>) -> Voxels;
}

impl Component for f32 {
    fn from_half(number: f16) -> Self {
        number.to_f32()
    }

    fn from_single(number: f32) -> Self {
        number
    }

    fn negated(self) -> Self {
        -self
    }

    fn voxels(numbers: Vec<Self>) -> Voxels {
        Voxels::F32(numbers)
    }
}

impl Component for f16 {
    fn from_half(number: f16) -> Self {
        number
    }

    fn from_single(number: f32) -> Self {
        f16::from_f32(number)
    }

    fn negated(self) -> Self {
        -self
    }

    fn voxels(numbers: Vec<Self>) -> Voxels {
        Voxels::F16(numbers)
    }
}

/// The format of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Half,
    Single,
    Double,
}

impl Number {
    fn size(self) -> usize {
        match self {
            Self::Half => 2,
            Self::Single => 4,
            Self::Double => 8,
        }
    }

    fn decode<T: Component>(self, bytes: &[u8]) -> T {
        match *bytes {
            [a, b] => T::from_half(f16::from_le_bytes([a, b])),
            [a, b, c, d] => T::from_single(f32::from_le_bytes([a, b, c, d])),
            [a, b, c, d, e, f, g, h] => T::from_single(f64::from_le_bytes([a, b, c, d, e, f, g, h]) as f32),
            _ => unreachable!("numbers have two, four or eight bytes"),
        }
    }
}

/// The format of a grid's values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form {
    /// The format of single values: the background, tiles of the root, inactive values.
    pub(super) single: Number,
    /// Whether arrays are in half precision, although the grid's type has another one.
    pub(super) is_reduced: bool,
}

impl Form {
    /// The format of values in arrays.
    pub(super) fn in_arrays(self) -> Number {
        match self.is_reduced {
            true => Number::Half,
            false => self.single,
        }
    }
}

/// A mask with a bit for each value of a node.
#[derive(Clone, Copy)]
pub(super) struct Mask<'a>(pub(super) &'a [u8]);

impl<'a> Mask<'a> {
    pub(super) fn read(bytes: &mut Bytes<'a>, count: usize) -> Result<Self, VdbError> {
        bytes.take(count / 8).map(Self)
    }

    fn len(self) -> usize {
        8 * self.0.len()
    }

    #[inline(always)]
    pub(super) fn has(self, index: usize) -> bool {
        self.0[index / 8] >> (index % 8) & 1 != 0
    }

    fn count(self) -> usize {
        self.0.iter().map(|byte| byte.count_ones() as usize).sum()
    }

    /// The indices of all bits that are set.
    pub(super) fn ones(self) -> impl Iterator<Item = usize> + 'a {
        (0..self.len()).filter(move |&index| self.has(index))
    }
}

/// Reads the values of one grid's nodes.
pub(super) struct ValueReader<'a, T, const C: usize> {
    pub(super) bytes: Bytes<'a>,
    form: Form,
    compression: Compression,
    pub(super) background: [T; C],
    /// The unpacked numbers of an array in their stored format.
    unpacked: Vec<u8>,
    scratch: Vec<u8>,
    inflate: Decompress,
}

impl<'a, T: Component, const C: usize> ValueReader<'a, T, C> {
    /// A reader at a position in the file where the background is next.
    pub(super) fn new(mut bytes: Bytes<'a>, form: Form, compression: Compression) -> Result<Self, VdbError> {
        Ok(Self {
            background: read_single(&mut bytes, form)?,
            bytes,
            form,
            compression,
            unpacked: Vec::new(),
            scratch: Vec::new(),
            inflate: Decompress::new(true),
        })
    }

    /// Reads a single value.
    pub(super) fn single(&mut self) -> Result<[T; C], VdbError> {
        read_single(&mut self.bytes, self.form)
    }

    /// Reads the values of a node, of which `active` are active, into `values`.
    ///
    /// The array omits inactive values that are the background, its negative (in level sets), or one of at most two
    /// others.
    pub(super) fn array(&mut self, active: Mask, values: &mut Vec<[T; C]>) -> Result<(), VdbError> {
        let code = self.bytes.u8()?;
        let first = match code {
            0 | 6 => self.background,
            1 | 3 => self.background.map(T::negated),
            2 | 4 | 5 => self.single()?,
            _ => return Err(self.bytes.damaged("a code from 0 to 6 for inactive values")),
        };
        let second = match code {
            5 => self.single()?,
            _ => self.background,
        };
        let selection = match code {
            3..=5 => Some(Mask::read(&mut self.bytes, active.len())?),
            _ => None,
        };
        let is_masked = self.compression.is_masked && code != 6;
        self.unpack(if is_masked { active.count() } else { active.len() })?;
        let number = self.form.in_arrays();
        let size = number.size();
        let mut stored = self.unpacked.chunks_exact(size * C).map(|value| {
            let mut numbers = value.chunks_exact(size);
            std::array::from_fn(|_| numbers.next().map_or(T::from_single(0.0), |bytes| number.decode(bytes)))
        });
        values.clear();
        if !is_masked {
            values.extend(stored);
            return Ok(());
        }
        values.extend((0..active.len()).map(|index| match active.has(index) {
            true => stored.next().unwrap_or(self.background),
            false if selection.is_some_and(|mask| mask.has(index)) => second,
            false => first,
        }));
        Ok(())
    }

    /// Unpacks the next array, of `count` values, into `unpacked`.
    fn unpack(&mut self, count: usize) -> Result<(), VdbError> {
        let size = count * C * self.form.in_arrays().size();
        self.unpacked.resize(size, 0);
        // An empty array in reduced precision is not in the file at all.
        if size == 0 && self.form.is_reduced {
            return Ok(());
        }
        let Compression { is_zip, is_blosc, .. } = self.compression;
        if !is_zip && !is_blosc {
            self.unpacked.copy_from_slice(self.bytes.take(size)?);
            return Ok(());
        }
        let length = self.bytes.i64()?;
        if length <= 0 {
            if length.unsigned_abs() != size as u64 {
                return Err(self.bytes.damaged("as many values as a node has"));
            }
            self.unpacked.copy_from_slice(self.bytes.take(size)?);
            return Ok(());
        }
        let packed = self.bytes.take(usize::try_from(length).unwrap_or(usize::MAX))?;
        if is_blosc {
            blosc::unpack(packed, &mut self.unpacked, &mut self.scratch)
                .ok_or(self.bytes.damaged("the values of a node, packed by Blosc with LZ4"))
        } else {
            self.inflate.reset(true);
            let status = self
                .inflate
                .decompress(packed, &mut self.unpacked, FlushDecompress::Finish);
            match matches!(status, Ok(Status::StreamEnd)) && self.inflate.total_out() == size as u64 {
                true => Ok(()),
                false => Err(self.bytes.damaged("the values of a node, packed by zlib")),
            }
        }
    }
}

fn read_single<T: Component, const C: usize>(bytes: &mut Bytes, form: Form) -> Result<[T; C], VdbError> {
    let size = form.single.size();
    let stored = bytes.take(size * C)?;
    Ok(std::array::from_fn(|channel| {
        form.single.decode(&stored[channel * size..][..size])
    }))
}
