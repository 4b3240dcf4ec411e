//! The constraints of a drag of the gizmo.

/// A constraint of a drag; each handle stands for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// The drag is along, or around, this axis of the frame.
    Axis(usize),
    /// The plane of the two other axes.
    Plane(usize),
    /// The drag moves in the plane of the view, turns around the view axis, or scales evenly.
    Free,
}
