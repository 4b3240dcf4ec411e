//! The list of a hierarchy's shapes, and edits of single shapes in it.

use std::iter::Peekable;
use std::ops::{Index, Range};

use super::instance::Instance;
use super::shared_list::SharedList;

/// Shapes by their numbers. Copies that differ in few shapes share the memory of all others, removed ones included.
#[derive(Clone, Debug, Default)]
pub struct Instances(SharedList<Instance>);

/// The difference between two lists of shapes.
#[derive(Clone, Debug, Default)]
pub struct ShapeEdits {
    /// The old numbers of the shapes that are gone, ascending.
    pub removed: Vec<u32>,
    /// Replacements for shapes, by their numbers in the old list, ascending; none of them is in `removed`.
    pub replaced: Vec<(u32, Instance)>,
    /// New shapes by their numbers in the new list, ascending.
    pub inserted: Vec<(u32, Instance)>,
}

impl ShapeEdits {
    /// Whether shapes that stay get other numbers. `count` is the length of the old list.
    pub(super) fn renumbers(&self, count: usize) -> bool {
        let left = (count - self.removed.len()) as u32;
        self.removed.first().is_some_and(|&first| first < left)
            || self.inserted.first().is_some_and(|&(first, _)| first < left)
    }

    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        self.removed.is_empty() && self.replaced.is_empty() && self.inserted.is_empty()
    }

    /// The new number of a shape that stays.
    pub fn renumbered(&self, old: u32) -> u32 {
        let left = old - self.removed.partition_point(|&removed| removed < old) as u32;
        left + self.inserted_before(left)
    }

    /// The number of new shapes before the `left`-th of the shapes that stay.
    fn inserted_before(&self, left: u32) -> u32 {
        // The n-th new shape comes before it if at most `left` shapes that stay come before the new one.
        let (mut low, mut high) = (0, self.inserted.len());
        while low < high {
            let middle = low.midpoint(high);
            if self.inserted[middle].0 - middle as u32 <= left {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low as u32
    }
}

impl Instances {
    /// The number of shapes.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The shape with this number; None beyond the last.
    #[inline(always)]
    pub fn get(&self, number: usize) -> Option<&Instance> {
        self.0.get(number)
    }

    pub(super) fn made_anew(self) -> Self {
        Self(self.0.made_anew())
    }

    /// The shapes that the list was made of; they are all shapes until the list is edited.
    pub(super) fn made(&self) -> &[Instance] {
        self.0.made()
    }

    /// All shapes in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Instance> + Clone {
        self.0.iter()
    }

    /// The list after the edits. Removed shapes take memory until the hierarchy is rebuilt.
    pub(super) fn edited(&self, edits: &ShapeEdits) -> Self {
        let mut edited = self.0.clone();
        for (number, shape) in &edits.replaced {
            edited.replace(*number as usize, shape.clone());
        }
        edited.splice(&edits.removed, edits.inserted.iter().cloned());
        Self(edited)
    }

    /// The edits that lead from `old` to this list, which must come from `old` by [`Self::edited`].
    pub(super) fn edits_since(&self, old: &Self) -> ShapeEdits {
        let mut edits = ShapeEdits::default();
        let (made, first_new) = (old.0.made().len(), old.0.stored());
        let mut now = (0..self.len()).peekable();
        let mut insert_new = |now: &mut Peekable<Range<usize>>| {
            while let Some(number) = now.next_if(|&number| self.0.place(number) >= first_new) {
                edits.inserted.push((number as u32, self[number].clone()));
            }
        };
        for number in 0..old.len() {
            insert_new(&mut now);
            let place = old.0.place(number);
            match now.next_if(|&now| self.0.place(now) == place) {
                None => edits.removed.push(number as u32),
                // An entry that was replaced before keeps its place, so its value has to be compared.
                Some(now) if place >= made && !self[now].is_same(&old[number]) => {
                    edits.replaced.push((number as u32, self[now].clone()));
                }
                Some(_) => {}
            }
        }
        insert_new(&mut now);
        edits
    }

    /// The share of removed shapes in the memory of all.
    pub(super) fn waste(&self) -> f32 {
        1.0 - self.len() as f32 / self.0.stored().max(1) as f32
    }
}

impl FromIterator<Instance> for Instances {
    fn from_iter<I: IntoIterator<Item = Instance>>(shapes: I) -> Self {
        Vec::from_iter(shapes).into()
    }
}

impl From<Vec<Instance>> for Instances {
    fn from(shapes: Vec<Instance>) -> Self {
        Self(shapes.into())
    }
}

impl Index<usize> for Instances {
    type Output = Instance;

    #[inline(always)]
    fn index(&self, number: usize) -> &Instance {
        &self.0[number]
    }
}
