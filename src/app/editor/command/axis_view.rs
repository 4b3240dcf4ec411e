//! The views along the axes of the world.

/// The side from which one looks along an axis of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisView {
    /// From +z.
    Front,
    /// From -z.
    Back,
    /// From +x.
    Right,
    /// From -x.
    Left,
    /// From +y.
    Top,
    /// From -y.
    Bottom,
}
