//! A list in pieces that its copies share: after one entry of a copy is replaced, all pieces but one are still shared.

use std::ops::Index;
use std::sync::Arc;

/// The number of entries in each piece but the last.
const PIECE: usize = 64;

/// A list whose copies are cheap as long as they differ in few entries.
#[derive(Clone, Debug)]
pub(super) struct Chunks<T> {
    pieces: Vec<Arc<[T]>>,
    len: usize,
}

impl<T> Default for Chunks<T> {
    fn default() -> Self {
        Self {
            pieces: Vec::new(),
            len: 0,
        }
    }
}

impl<T> Chunks<T> {
    pub fn len(&self) -> usize {
        self.len
    }

    pub fn iter(&self) -> impl Iterator<Item = &T> + Clone {
        self.pieces.iter().flat_map(|piece| piece.iter())
    }
}

impl<T: Clone> Chunks<T> {
    /// Replaces an entry. Nothing happens beyond the end.
    pub fn replace(&mut self, index: usize, value: T) {
        if let Some(piece) = self.pieces.get_mut(index / PIECE)
            && let Some(place) = Arc::make_mut(piece).get_mut(index % PIECE)
        {
            *place = value;
        }
    }

    pub fn truncate(&mut self, len: usize) {
        if len >= self.len {
            return;
        }
        self.pieces.truncate(len.div_ceil(PIECE));
        if let Some(last) = self.pieces.last_mut().filter(|_| !len.is_multiple_of(PIECE)) {
            *last = last[..len % PIECE].into();
        }
        self.len = len;
    }
}

impl<T: Clone> Extend<T> for Chunks<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, values: I) {
        let mut open: Vec<T> = Vec::with_capacity(PIECE);
        if !self.len.is_multiple_of(PIECE)
            && let Some(last) = self.pieces.pop()
        {
            open.extend_from_slice(&last);
        }
        self.len -= open.len();
        for value in values {
            open.push(value);
            if open.len() == PIECE {
                self.len += PIECE;
                self.pieces.push(open.drain(..).collect());
            }
        }
        if !open.is_empty() {
            self.len += open.len();
            self.pieces.push(open.into());
        }
    }
}

impl<T: Clone> FromIterator<T> for Chunks<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        let mut chunks = Self::default();
        chunks.extend(values);
        chunks
    }
}

impl<T> Index<usize> for Chunks<T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, index: usize) -> &T {
        &self.pieces[index / PIECE][index % PIECE]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_those_of_a_plain_list() {
        let mut plain: Vec<usize> = (0..200).collect();
        let mut chunks: Chunks<usize> = plain.iter().copied().collect();
        for (length, more) in [(200, 0..3), (130, 0..1), (128, 7..300), (64, 0..64), (0, 0..70)] {
            plain.truncate(length);
            chunks.truncate(length);
            plain.extend(more.clone());
            chunks.extend(more);
            assert!(chunks.iter().eq(&plain));
            assert_eq!(chunks.len(), plain.len());
            assert!((0..plain.len()).all(|index| chunks[index] == plain[index]));
        }
    }

    #[test]
    fn copies_share_what_is_alike() {
        let old: Chunks<usize> = (0..1000).collect();
        let mut new = old.clone();
        new.replace(700, 5);
        new.replace(5000, 5);
        assert_eq!((old[700], new[700], new.len()), (700, 5, 1000));
        let shared = old.pieces.iter().zip(&new.pieces).filter(|(a, b)| Arc::ptr_eq(a, b));
        assert_eq!(shared.count(), old.pieces.len() - 1);
    }
}
