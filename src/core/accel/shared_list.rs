//! A list that shares its entries with its copies: an edited copy takes memory for the difference alone.

use std::ops::Index;
use std::sync::Arc;

/// A list whose copies are cheap while they differ in few entries. Until its first edit it is read like a plain list.
#[derive(Clone, Debug)]
pub(super) struct SharedList<T> {
    /// The entries that the list was made of.
    made: Arc<Vec<T>>,
    /// The edits since; None before the first.
    edits: Option<Edits<T>>,
}

#[derive(Clone, Debug)]
struct Edits<T> {
    /// The index of each entry in the list as it was made, and beyond its end in `new`.
    places: Vec<u32>,
    new: Vec<T>,
}

impl<T> SharedList<T> {
    pub fn len(&self) -> usize {
        self.edits.as_ref().map_or(self.made.len(), |edits| edits.places.len())
    }

    /// The number of entries in memory, removed ones included.
    pub fn stored(&self) -> usize {
        self.made.len() + self.edits.as_ref().map_or(0, |edits| edits.new.len())
    }

    /// The entries that the list was made of; they are all entries until the list is edited.
    pub fn made(&self) -> &[T] {
        &self.made
    }

    /// The index of an entry in the list as it was made, and beyond its end among the new entries. Entries keep it in
    /// edited copies, except the first time that they are replaced.
    pub fn place(&self, index: usize) -> usize {
        self.edits.as_ref().map_or(index, |edits| edits.places[index] as usize)
    }

    #[inline(always)]
    pub fn get(&self, index: usize) -> Option<&T> {
        match &self.edits {
            None => self.made.get(index),
            Some(edits) => self.get_edited(edits, index),
        }
    }

    pub fn iter(&self) -> impl ExactSizeIterator<Item = &T> + Clone {
        (0..self.len()).map(|index| &self[index])
    }

    /// Kept out of line, so that reading a list without edits stays fast.
    #[inline(never)]
    fn get_edited<'a>(&'a self, edits: &'a Edits<T>, index: usize) -> Option<&'a T> {
        let place = *edits.places.get(index)? as usize;
        self.made.get(place).or_else(|| edits.new.get(place - self.made.len()))
    }

    fn edits(&mut self) -> &mut Edits<T> {
        let made = self.made.len() as u32;
        self.edits.get_or_insert_with(|| Edits {
            places: (0..made).collect(),
            new: Vec::new(),
        })
    }

    /// Replaces an entry; does nothing beyond the end.
    pub fn replace(&mut self, index: usize, value: T) {
        let made = self.made.len();
        let edits = self.edits();
        let Some(place) = edits.places.get_mut(index) else {
            return;
        };
        match (*place as usize).checked_sub(made) {
            Some(new) => edits.new[new] = value,
            None => {
                *place = (made + edits.new.len()) as u32;
                edits.new.push(value);
            }
        }
    }

    pub fn truncate(&mut self, len: usize) {
        if len >= self.len() {
            return;
        }
        let made = self.made.len();
        let edits = self.edits();
        edits.places.truncate(len);
        let used = edits.places.iter().map(|&place| place as usize + 1).max();
        edits.new.truncate(used.unwrap_or(0).saturating_sub(made));
    }

    /// Removes the entries with the numbers `removed`, ascending, and then inserts `inserted` by their numbers in the
    /// resulting list, ascending.
    pub fn splice(&mut self, removed: &[u32], inserted: impl ExactSizeIterator<Item = (u32, T)>) {
        if removed.is_empty() && inserted.len() == 0 {
            return;
        }
        /// Up to this number of entries, moving all later ones is faster than making a new list.
        const FEW: usize = 8;
        let first_new = self.stored() as u32;
        let edits = self.edits();
        if removed.len() + inserted.len() <= FEW {
            for &number in removed.iter().rev() {
                edits.places.remove(number as usize);
            }
            for (place, (number, value)) in (first_new..).zip(inserted) {
                edits.places.insert(number as usize, place);
                edits.new.push(value);
            }
            return;
        }
        let mut removed = removed.iter().peekable();
        let is_left = |(number, _): &(u32, &u32)| removed.next_if(|&&gone| gone == *number).is_none();
        let left: Vec<u32> = ((0..).zip(&edits.places).filter(is_left))
            .map(|(_, &place)| place)
            .collect();
        edits.places.clear();
        let mut left = left.into_iter();
        for (place, (number, value)) in (first_new..).zip(inserted) {
            let before = (number as usize).saturating_sub(edits.places.len());
            edits.places.extend(left.by_ref().take(before));
            edits.places.push(place);
            edits.new.push(value);
        }
        edits.places.extend(left);
    }
}

impl<T: Clone> SharedList<T> {
    /// A list of the same entries without edits.
    pub fn made_anew(self) -> Self {
        match self.edits {
            None => self,
            Some(_) => self.iter().cloned().collect::<Vec<T>>().into(),
        }
    }
}

impl<T> Extend<T> for SharedList<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, values: I) {
        let first = self.stored() as u32;
        let edits = self.edits();
        let before = edits.new.len();
        edits.new.extend(values);
        let more = (edits.new.len() - before) as u32;
        edits.places.extend(first..first + more);
    }
}

impl<T> From<Vec<T>> for SharedList<T> {
    fn from(made: Vec<T>) -> Self {
        Self {
            made: Arc::new(made),
            edits: None,
        }
    }
}

impl<T> Default for SharedList<T> {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl<T> Index<usize> for SharedList<T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, index: usize) -> &T {
        self.get(index).expect("the index is below the length")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_those_of_a_plain_list() {
        let mut plain: Vec<usize> = (0..200).collect();
        let mut shared = SharedList::from(plain.clone());
        for (length, more) in [(200, 0..3), (130, 0..1), (128, 7..300), (64, 0..64), (0, 0..70)] {
            plain.truncate(length);
            shared.truncate(length);
            plain.extend(more.clone());
            shared.extend(more);
            for index in [0, length / 2, length] {
                plain[index] = 1000 + index;
                shared.replace(index, 1000 + index);
            }
            assert!(shared.iter().eq(&plain));
            assert!((0..plain.len()).all(|index| shared.get(index) == Some(&plain[index])));
            assert_eq!((shared.len(), shared.get(plain.len())), (plain.len(), None));
        }
    }

    #[test]
    fn entries_are_taken_out_and_put_in_by_number() {
        let mut shared = SharedList::from(vec!['a', 'b', 'c', 'd']);
        shared.splice(&[0, 2], [(0, 'x'), (2, 'y'), (4, 'z')].into_iter());
        assert!(shared.iter().eq(&['x', 'b', 'y', 'd', 'z']));
        shared.splice(&[2, 4], [].into_iter());
        assert!(shared.iter().eq(&['x', 'b', 'd']));
        assert_eq!(shared.stored(), 7);
        let anew = shared.made_anew();
        assert_eq!((anew.made(), anew.stored()), (&['x', 'b', 'd'][..], 3));
    }

    #[test]
    fn many_entries_are_put_in_as_few_are() {
        let mut shared = SharedList::from((0..100).collect::<Vec<u32>>());
        let mut plain: Vec<u32> = (0..100).collect();
        let removed: Vec<u32> = (0..100).step_by(9).collect();
        for number in removed.iter().rev() {
            plain.remove(*number as usize);
        }
        let inserted: Vec<(u32, u32)> = (0..30).map(|number| (3 * number, 1000 + number)).collect();
        inserted
            .iter()
            .for_each(|(number, value)| plain.insert(*number as usize, *value));
        shared.splice(&removed, inserted.into_iter());
        assert!(shared.iter().eq(&plain));
    }

    #[test]
    fn copies_share_what_is_alike() {
        let old = SharedList::from((0..1000).collect::<Vec<usize>>());
        let mut new = old.clone();
        new.replace(700, 5);
        new.replace(700, 6);
        new.replace(5000, 5);
        assert_eq!((old[700], new[700], new.len()), (700, 6, 1000));
        assert!(Arc::ptr_eq(&old.made, &new.made));
        assert_eq!((old.stored(), new.stored()), (1000, 1001));
    }

    #[test]
    fn what_is_cut_off_takes_no_memory() {
        let mut shared = SharedList::from(vec![0; 10]);
        for _ in 0..3 {
            shared.truncate(10);
            shared.replace(3, 1);
            shared.extend([7, 8]);
        }
        assert_eq!((shared.len(), shared.stored()), (12, 13));
    }
}
