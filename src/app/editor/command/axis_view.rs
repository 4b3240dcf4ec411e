//! The views along the axes of the world.

/// The side from which the view looks along an axis of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisView {
    /// The view from +z.
    Front,
    /// The view from -z.
    Back,
    /// The view from +x.
    Right,
    /// The view from -x.
    Left,
    /// The view from +y.
    Top,
    /// The view from -y.
    Bottom,
}

impl AxisView {
    /// All sides.
    pub const ALL: [Self; 6] = [
        Self::Front,
        Self::Back,
        Self::Right,
        Self::Left,
        Self::Top,
        Self::Bottom,
    ];
}
