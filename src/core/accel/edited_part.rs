//! The part of a hierarchy that was edited since it was built.

/// The small hierarchy over edited shapes beside the built one.
#[derive(Clone, Debug)]
pub(super) struct EditedPart {
    /// The numbers of its shapes, ascending.
    pub shapes: Vec<u32>,
    /// The number of nodes of the built hierarchy; the next three count its entries of the order, blocks and levels.
    pub nodes: usize,
    pub leaves: usize,
    pub blocks: usize,
    pub depth: usize,
}

/// A hierarchy over fewer items than this is quick to rebuild, so edits in place would gain nothing.
pub(super) const FEWEST_EDITED: usize = 2048;
