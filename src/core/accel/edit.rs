//! Edits single shapes of a hierarchy at a cost that grows with the edit, not with the scene.
//!
//! The shapes that an edit changes are removed from the built hierarchy and put into a small one beside it, which is
//! built anew for every edit. Rays hit the same shapes as in a hierarchy rebuilt over the whole scene. Only distances
//! may be rounded differently, because other shapes share a block.
//!
//! The more shapes the small hierarchy has, the slower rays are. A hierarchy that [is worn](Tlas::is_worn) is [built
//! anew](Tlas::rebuilt) on another thread, and the edits made meanwhile are repeated on the result
//! ([`Tlas::after_edits`]).

use super::build::SplitMethod;
use super::bvh::Bvh;
use super::edited_part::{EditedPart, FEWEST_EDITED};
use super::instances::ShapeEdits;
use super::shape_block::ShapeBlock;
use super::tlas::{LEAF_SIZE, Tlas};
use super::tree_edit::LeafEdit;
use crate::math::Aabb;

/// With more edited shapes than this, rebuilding the hierarchy pays off.
const WORN: usize = 1024;
/// The most edited shapes. Each edit builds the small hierarchy over all of them.
const MOST_EDITED: usize = 4096;
/// The share of removed shapes in the memory of all shapes above which rebuilding the hierarchy pays off.
const MUCH_WASTE: f32 = 0.25;
/// The largest share of removed shapes in the memory of all shapes.
const MOST_WASTE: f32 = 0.5;

impl Tlas {
    /// Whether [`Self::edited`] may be quicker than to build anew.
    pub fn is_edited_in_place(&self) -> bool {
        let items = self.instances.len() + self.placements.len();
        !self.bvh.is_linear() && items >= FEWEST_EDITED
    }

    /// Whether so much has been edited that a rebuilt hierarchy would be faster, and smaller.
    pub fn is_worn(&self) -> bool {
        let edited = self.edited.as_ref().map_or(0, |edited| edited.shapes.len());
        edited > WORN || self.instances.waste() > MUCH_WASTE
    }

    /// A hierarchy built anew over the same shapes, without shared memory.
    pub fn rebuilt(&self, method: SplitMethod) -> Self {
        let instances = self.instances.clone();
        Self::over(instances, self.groups.clone(), self.placements.clone(), method)
    }

    /// This hierarchy, which was [rebuilt](Self::rebuilt) from `old`, after the edits that lead from `old` to `now`.
    /// None where [`Self::edited`] gives None.
    pub fn after_edits(&self, old: &Self, now: &Self) -> Option<Self> {
        self.edited(&now.instances.edits_since(&old.instances))
    }

    /// The hierarchy after edits of single shapes. None where a rebuild is better: the hierarchy is small, or many of
    /// its shapes are edited.
    pub fn edited(&self, edits: &ShapeEdits) -> Option<Self> {
        let count = self.instances.len();
        if !self.is_edited_in_place() {
            return None;
        }
        let before = self.edited.as_ref().map_or(&[][..], |edited| &edited.shapes);
        let touched = edits
            .removed
            .iter()
            .chain(edits.replaced.iter().map(|(number, _)| number));
        let mut touched: Vec<u32> = touched.copied().collect();
        touched.sort_unstable();
        let is_removed = |number: &u32| edits.removed.binary_search(number).is_ok();
        let mut beside: Vec<u32> = (before.iter().chain(&touched))
            .filter(|number| !is_removed(number))
            .map(|&number| edits.renumbered(number))
            .chain(edits.inserted.iter().map(|&(number, _)| number))
            .collect();
        beside.sort_unstable();
        beside.dedup();
        // Shapes edited before are not in the built hierarchy.
        touched.retain(|number| before.binary_search(number).is_err());
        let instances = self.instances.edited(edits);
        if beside.len() > MOST_EDITED.min(instances.len() / 2) || instances.waste() > MOST_WASTE {
            return None;
        }
        let mut edited = Self {
            bvh: match &self.edited {
                Some(edited) => Bvh {
                    depth: edited.depth,
                    ..self.bvh.without_beside(edited.nodes, edited.leaves)
                },
                None => self.bvh.under_root(),
            },
            instances,
            groups: self.groups.clone(),
            first_shape: Vec::new(),
            placements: self.placements.clone(),
            blocks: self.blocks.clone(),
            small_scene: None,
            edited: None,
            ..*self
        };
        let fitted = edited.leave_blocks(self, edits, &touched);
        let beyond = edited.instances.len() as u32;
        let leaf = |item: u32| match item.checked_sub(count as u32) {
            None if touched.binary_search(&item).is_ok() => LeafEdit::Remove,
            None => LeafEdit::Keep(edits.renumbered(item)),
            Some(place) => match fitted.binary_search_by_key(&place, |&(block, _)| block) {
                Ok(found) if fitted[found].1.is_empty() => LeafEdit::Remove,
                Ok(found) => LeafEdit::Fit(beyond + place, fitted[found].1),
                Err(_) => LeafEdit::Keep(beyond + place),
            },
        };
        if !touched.is_empty() || edited.instances.len() != count || edits.renumbers(count) {
            edited.bvh.edit_leaves(leaf);
        }
        edited.put_beside(beside).then(|| edited.counted(self, edits))
    }

    /// Removes the shapes `touched`, given by their old numbers, from their blocks, and renumbers the others. Returns
    /// the changed blocks with their bounds; a block's index follows those of the placements.
    fn leave_blocks(&mut self, old: &Self, edits: &ShapeEdits, touched: &[u32]) -> Vec<(u32, Aabb)> {
        if let Some(edited) = &old.edited {
            self.blocks.truncate(edited.blocks);
        }
        let is_touched = |member: &u32| touched.binary_search(member).is_ok();
        let mut fitted = Vec::new();
        for place in 0..self.blocks.len() {
            let members = self.blocks.members()[place];
            if touched.is_empty() || !members.indices().iter().any(is_touched) {
                continue;
            }
            let left = members.indices().iter().copied().filter(|member| !is_touched(member));
            let (block, left) = ShapeBlock::of(&old.instances, &left.collect::<Vec<_>>());
            fitted.push(((place + self.placements.len()) as u32, block.bounds));
            self.blocks.replace(place, (block, left));
        }
        if edits.renumbers(old.instances.len()) {
            self.blocks.renumber(|old| edits.renumbered(old));
        }
        fitted
    }

    /// Puts these shapes into the hierarchy beside the built one. False if the result would be too deep.
    fn put_beside(&mut self, shapes: Vec<u32>) -> bool {
        let edited = EditedPart {
            nodes: self.bvh.nodes.len(),
            leaves: self.bvh.order.len(),
            blocks: self.blocks.len(),
            depth: self.bvh.depth,
            shapes,
        };
        let is_for_block = |number: &&u32| ShapeBlock::takes(&self.instances[**number as usize]);
        let (in_blocks, alone): (Vec<u32>, Vec<u32>) = edited.shapes.iter().partition(is_for_block);
        self.blocks.extend(ShapeBlock::gather_all(&self.instances, &in_blocks));
        let first_block = (self.instances.len() + self.placements.len() + edited.blocks) as u32;
        let blocks = (edited.blocks..self.blocks.len()).map(|place| (place - edited.blocks) as u32 + first_block);
        let items: Vec<u32> = alone.into_iter().chain(blocks).collect();
        let bounds = |place: usize| self.item_bounds(items[place], false);
        let mut beside = Bvh::over(items.len(), bounds, None, SplitMethod::Sah, LEAF_SIZE);
        beside
            .order
            .iter_mut()
            .for_each(|place| *place = items[*place as usize]);
        self.edited = Some(edited);
        self.bvh.put_beside(&beside)
    }

    /// Updates the figures that depend on the number and kind of shapes.
    fn counted(mut self, old: &Self, edits: &ShapeEdits) -> Self {
        let (count, before) = (self.instances.len(), old.instances.len());
        self.first_shape = old.first_shape.iter().map(|first| first - before + count).collect();
        let mut new = edits.replaced.iter().chain(&edits.inserted);
        self.has_vertex_normals |= new.any(|(_, shape)| shape.with_vertex_normals().is_some());
        self
    }
}
