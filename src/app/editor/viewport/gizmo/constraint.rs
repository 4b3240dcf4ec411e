//! Along what a drag of the gizmo goes.

/// What a drag is held to; also what each handle stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// Along, or around, this axis of the frame.
    Axis(usize),
    /// Along the two other axes.
    Plane(usize),
    /// Moves in the plane of the view, turns around the view axis, scales evenly.
    Free,
}
