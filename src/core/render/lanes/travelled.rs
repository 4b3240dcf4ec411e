//! The results of path segments through media.

/// The paths that have been taken through the commonest media, a bit each.
#[derive(Clone, Copy)]
pub(super) struct Travelled {
    pub lanes: u32,
    /// The paths among them that are scattered before the ends of their rays; the scatterings are their vertices.
    pub scattered: u32,
}

impl Travelled {
    /// No path.
    pub const NOTHING: Self = Self { lanes: 0, scattered: 0 };
}
