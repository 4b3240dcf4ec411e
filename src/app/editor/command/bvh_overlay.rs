//! The choice of acceleration structure boxes to draw over the picture.

/// The drawn boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BvhOverlay {
    /// Whether boxes are drawn at all.
    pub shown: bool,
    /// The depth in each hierarchy: 0 is the box around everything in it.
    pub depth: u32,
    /// Whether leaves of any depth up to `depth` are drawn instead of all boxes at it.
    pub leaves_only: bool,
}

impl Default for BvhOverlay {
    fn default() -> Self {
        Self {
            shown: false,
            depth: 1,
            leaves_only: false,
        }
    }
}
