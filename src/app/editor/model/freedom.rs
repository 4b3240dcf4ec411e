//! The ways in which a thing may be moved.

/// The parts of a transform that can be edited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Place, rotation and scale along any axes.
    Affine,
    /// No scale, as of a camera.
    Rigid,
    /// The rotation alone, as of what is infinitely far away.
    Turning,
}
