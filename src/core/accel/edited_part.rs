//! The part of a hierarchy that was edited since it was built.

/// The part of a hierarchy that lies beside what was built.
#[derive(Clone, Debug)]
pub(super) struct EditedPart {
    /// The numbers of its shapes, ascending.
    pub shapes: Vec<u32>,
    /// The number of nodes before it, and likewise of entries of the order, of blocks, and of levels.
    pub nodes: usize,
    pub leaves: usize,
    pub blocks: usize,
    pub depth: usize,
}

/// A hierarchy over fewer items than this is quickly built anew, so that edits of it are not worth the effort.
pub(super) const FEWEST_EDITED: usize = 2048;
