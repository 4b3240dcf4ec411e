//! The constraints of a drag of the gizmo.

/// A constraint of a drag; each handle stands for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// Along, or around, this axis of the frame.
    Axis(usize),
    /// The plane of the two other axes.
    Plane(usize),
    /// Moves in the plane of the view, turns around the view axis, scales evenly.
    Free,
}
