//! The degrees of freedom of a pose.

/// The parts of a transform that can be edited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// It can be moved, turned and scaled along any axes.
    Affine,
    /// It can be moved and turned, but not scaled, such as a camera.
    Rigid,
    /// It can only be turned, such as an infinitely distant light.
    Turning,
}
