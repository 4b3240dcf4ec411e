//! Edits of long lists of shapes, which are copied in pieces because most of a list is unchanged.

use std::ops::Range;

/// The edits of the list of shapes since it was packed. All numbers ascend.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::engine) struct ListEdits {
    /// The old numbers of the shapes that are gone.
    pub removed: Vec<u32>,
    /// The shapes that are new.
    pub inserted: Vec<u32>,
    /// The other shapes that may have changed, by their current numbers.
    pub changed: Vec<u32>,
}

/// The changes of the shapes.
#[derive(Debug)]
pub(in crate::engine) struct ShapeChanges {
    /// For each shape, whether it has moved or changed.
    pub moved: Vec<bool>,
    /// The edits of the list; None if all shapes were packed.
    pub edits: Option<ListEdits>,
}

/// A piece of the edited list.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::engine) enum Piece {
    /// This range of the old list.
    Kept(Range<usize>),
    /// An inserted entry, as an index into `inserted`.
    New(usize),
}

/// The pieces of a list of this length after the entries at `removed` are removed and new ones are inserted at the
/// indices `inserted` of the edited list. Both ascend.
pub(in crate::engine) fn pieces(len: usize, removed: &[u32], inserted: &[u32]) -> Vec<Piece> {
    let mut removed = removed.iter().map(|place| *place as usize).peekable();
    let mut inserted = (0..).zip(inserted.iter().map(|place| *place as usize)).peekable();
    let mut pieces = Vec::new();
    let (mut next, mut edited_len) = (0, 0);
    loop {
        while let Some((index, _)) = inserted.next_if(|(_, place)| *place == edited_len) {
            pieces.push(Piece::New(index));
            edited_len += 1;
        }
        while removed.next_if_eq(&next).is_some() {
            next += 1;
        }
        if next >= len {
            return pieces;
        }
        let stay = removed.peek().map_or(len, |place| *place) - next;
        let room = inserted.peek().map_or(usize::MAX, |(_, place)| place - edited_len);
        let kept = stay.min(room);
        pieces.push(Piece::Kept(next..next + kept));
        next += kept;
        edited_len += kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_put_together_by_the_places_before_and_after() {
        let edited = |removed: &[u32], inserted: &[u32]| -> String {
            let text = |piece| match piece {
                Piece::Kept(range) => "abcd"[range].to_owned(),
                Piece::New(index) => "xyz"[index..=index].to_owned(),
            };
            pieces(4, removed, inserted).into_iter().map(text).collect()
        };
        assert_eq!(edited(&[], &[]), "abcd");
        assert_eq!(edited(&[0, 2], &[0, 2, 4]), "xbydz");
        assert_eq!(edited(&[2, 3], &[2, 3]), "abxy");
        assert_eq!(edited(&[0, 1, 2, 3], &[0]), "x");
        assert_eq!(edited(&[], &[1, 2, 6]), "axybcdz");
    }
}
