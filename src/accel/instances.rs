//! The list of the shapes of a hierarchy, and how it follows edits of single shapes.

use std::ops::Index;

use super::chunks::Chunks;
use super::instance::{Instance, Primitive};

/// Shapes by their numbers. Copies that differ in few shapes share the memory of the others.
#[derive(Clone, Debug, Default)]
pub struct Instances {
    /// The shapes in the order in which they were added, including removed ones.
    stored: Chunks<Instance>,
    /// The place in `stored` of each shape.
    places: Vec<u32>,
}

/// The difference between two lists of shapes.
#[derive(Clone, Debug, Default)]
pub struct ShapeEdits {
    /// The old numbers of the removed shapes, ascending.
    pub removed: Vec<u32>,
    /// New versions of shapes that stay, by their numbers in the old list, ascending.
    pub replaced: Vec<(u32, Instance)>,
    /// New shapes by their numbers in the new list, ascending.
    pub inserted: Vec<(u32, Instance)>,
}

impl ShapeEdits {
    /// Whether shapes that stay get other numbers. `count`: of the old list.
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

    /// The number of new shapes before the shape that comes after `left` others that stay.
    fn inserted_before(&self, left: u32) -> u32 {
        // A new shape is before that one if at most `left` of the shapes that stay come before the new shape.
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
        self.places.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The shape of a number; None beyond the last.
    #[inline(always)]
    pub fn get(&self, number: usize) -> Option<&Instance> {
        self.places.get(number).map(|&place| &self.stored[place as usize])
    }

    /// All shapes in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Instance> + Clone {
        self.places.iter().map(|&place| &self.stored[place as usize])
    }

    /// The list after the edits. Removed shapes take memory until a list is made anew.
    pub(super) fn edited(&self, edits: &ShapeEdits) -> Self {
        let mut edited = self.clone();
        for (number, shape) in &edits.replaced {
            edited
                .stored
                .replace(self.places[*number as usize] as usize, shape.clone());
        }
        for &number in &edits.removed {
            // A removed shape does not keep its mesh alive.
            let place = self.places[number as usize] as usize;
            let primitive = Primitive::Sphere;
            let gone = Instance {
                primitive,
                ..self.stored[place].clone()
            };
            edited.stored.replace(place, gone);
        }
        if edits.removed.is_empty() && edits.inserted.is_empty() {
            return edited;
        }
        let first_new = edited.stored.len() as u32;
        edited
            .stored
            .extend(edits.inserted.iter().map(|(_, shape)| shape.clone()));
        let mut removed = edits.removed.iter().peekable();
        let is_left = |(number, _): &(u32, &u32)| removed.next_if(|&&gone| gone == *number).is_none();
        let mut left = (0..).zip(&self.places).filter(is_left).map(|(_, &place)| place);
        let mut new = (first_new..).zip(&edits.inserted).peekable();
        let count = self.places.len() - edits.removed.len() + edits.inserted.len();
        edited.places = (0..count as u32)
            .filter_map(|number| match new.next_if(|(_, (at, _))| *at == number) {
                Some((place, _)) => Some(place),
                None => left.next(),
            })
            .collect();
        edited
    }

    /// The memory of removed shapes, as a share of all.
    pub(super) fn waste(&self) -> f32 {
        1.0 - self.places.len() as f32 / self.stored.len().max(1) as f32
    }
}

impl FromIterator<Instance> for Instances {
    fn from_iter<I: IntoIterator<Item = Instance>>(shapes: I) -> Self {
        let stored: Chunks<Instance> = shapes.into_iter().collect();
        Self {
            places: (0..stored.len() as u32).collect(),
            stored,
        }
    }
}

impl From<Vec<Instance>> for Instances {
    fn from(shapes: Vec<Instance>) -> Self {
        shapes.into_iter().collect()
    }
}

impl Index<usize> for Instances {
    type Output = Instance;

    #[inline(always)]
    fn index(&self, number: usize) -> &Instance {
        &self.stored[self.places[number] as usize]
    }
}
