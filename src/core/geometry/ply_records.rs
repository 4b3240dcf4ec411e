//! Binary PLY elements with records of fixed length, read on all threads: vertices without lists, and faces that are
//! all triangles.
//!
//! It only reports that a record is irregular (a fourth corner, an index out of range); the sequential reader then
//! reads the element again and gives the error.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::ply_header::{Element, Kind, Scalar};
use super::ply_source::BinaryNumbers;

/// The number of records that a thread reads at once: their work is much more than the cost of claiming them.
const STRETCH: usize = 1 << 12;

/// The consecutive records of an element.
pub(super) struct Records<'a> {
    numbers: BinaryNumbers<'a>,
    length: usize,
    /// The offset of each of the element's properties in a record.
    offsets: Vec<usize>,
}

impl<'a> Records<'a> {
    /// The records at the beginning of `body`, with `items` items in each list. `None` if there is a list although
    /// `items` is `None`, or if the body is too short.
    pub fn new(element: &Element, items: Option<usize>, body: BinaryNumbers<'a>) -> Option<Self> {
        let mut length = 0;
        let mut offsets = Vec::with_capacity(element.properties.len());
        for property in &element.properties {
            offsets.push(length);
            length += match property.kind {
                Kind::Scalar(scalar) => scalar.size(),
                Kind::List { count, item } => count.size() + items? * item.size(),
            };
        }
        let whole = usize::try_from(element.count).ok()?.checked_mul(length)?;
        (length > 0).then_some(Self {
            numbers: BinaryNumbers {
                bytes: body.bytes.get(..whole)?,
                ..body
            },
            length,
            offsets,
        })
    }

    pub fn bytes(&self) -> &'a [u8] {
        self.numbers.bytes
    }

    /// Calls `each` for every record in turn, with a function that returns the number of a property.
    pub fn each(&self, mut each: impl FnMut(&dyn Fn(usize, Scalar) -> f64)) {
        for record in self.numbers.bytes.chunks_exact(self.length) {
            each(&|property, scalar| scalar.number(&record[self.offsets[property]..], self.numbers.big_endian));
        }
    }

    /// For each record, the vector of the numbers of `N` properties.
    pub fn vectors<const N: usize, V: From<[f32; N]> + Clone + Default + Send>(
        &self,
        properties: [(usize, Scalar); N],
    ) -> Vec<V> {
        let fields = properties.map(|(property, scalar)| (self.offsets[property], scalar));
        let first = fields[0].0;
        let in_a_row = (0..N).all(|i| fields[i] == (first + 4 * i, Scalar::F32));
        if in_a_row {
            return self.read(|record| self.words::<N>(&record[first..]).map(f32::from_bits).into());
        }
        let number = |record: &[u8], (offset, scalar): (usize, Scalar)| {
            scalar.number(&record[offset..], self.numbers.big_endian) as f32
        };
        self.read(|record| fields.map(|field| number(record, field)).into())
    }

    /// The index triples of the list property `list`; `None` unless all have three items below `vertex_count`.
    pub fn triangles(&self, list: usize, count: Scalar, item: Scalar, vertex_count: u64) -> Option<Vec<[u32; 3]>> {
        // Negative indices are too large as unsigned ones.
        let count_of_indices = u32::try_from(vertex_count).ok().filter(|&count| count <= 1 << 31)?;
        if !matches!(item, Scalar::I32 | Scalar::U32) {
            return None;
        }
        let offset = self.offsets[list];
        let first = self.numbers.bytes.get(offset..)?;
        if count.number(first, self.numbers.big_endian) != 3.0 {
            return None;
        }
        let is_odd = AtomicBool::new(false);
        let triangle = |record: &[u8]| {
            let list = &record[offset..];
            let corners = self.words::<3>(&list[count.size()..]);
            if count.number(list, self.numbers.big_endian) != 3.0
                || corners.iter().any(|&corner| corner >= count_of_indices)
            {
                is_odd.store(true, Ordering::Relaxed);
            }
            corners
        };
        let triangles = self.read(triangle);
        (!is_odd.into_inner()).then_some(triangles)
    }

    /// The results of `read` for all records.
    fn read<T: Clone + Default + Send>(&self, read: impl Fn(&[u8]) -> T + Sync) -> Vec<T> {
        let mut all = vec![T::default(); self.numbers.bytes.len() / self.length];
        all.par_chunks_mut(STRETCH)
            .zip(self.numbers.bytes.par_chunks(STRETCH * self.length))
            .for_each(|(some, bytes)| {
                for (one, record) in some.iter_mut().zip(bytes.chunks_exact(self.length)) {
                    *one = read(record);
                }
            });
        all
    }

    /// The four-byte numbers at the beginning of `bytes`; 0 beyond their end.
    #[inline(always)]
    fn words<const N: usize>(&self, bytes: &[u8]) -> [u32; N] {
        let mut words = [0; N];
        for (word, bytes) in words.iter_mut().zip(bytes.as_chunks::<4>().0) {
            *word = self.numbers.word(*bytes);
        }
        words
    }
}
