//! Blocking out: drawing boxes, floors and walls, pushing and pulling faces, cutting doors and windows.

pub mod block;
pub mod faces;
pub mod grips;
pub mod joints;
pub mod openings;

declare_names! {
    /// The things that can be drawn.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum BlockKind {
        /// A box on a rectangle.
        #[default]
        Box = "box",
        /// A slab below a rectangle, so that its upper side is where it was drawn.
        Floor = "floor",
        /// A wall along a line.
        Wall = "wall",
    }
}

/// The openings that can be cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OpeningKind {
    /// From the wall's foot upwards.
    #[default]
    Door,
    /// Above the wall's foot.
    Window,
}

/// The kind of a change of a shape and its pose, for the label of the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reshaping {
    /// A face was pushed or pulled; the steps of one drag are one step of the history.
    Push,
    /// An opening was cut.
    Cut,
    /// An opening was moved or resized; the steps of one drag are one step of the history.
    Move,
    /// An opening was filled.
    Fill,
}

/// The multiple of a step nearest to a length, without the rounding of a product of singles; the length itself without
/// a step.
pub(crate) fn snapped(length: f32, step: f32) -> f32 {
    if !(step > 0.0 && length.is_finite()) {
        return length;
    }
    let steps = (f64::from(length) / f64::from(step)).round();
    // The step as it is written: 0.1 is a little more than a tenth in either precision.
    let exact = step.to_string().parse().unwrap_or(f64::from(step));
    (steps * exact) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_of_a_step_are_the_numbers_one_writes() {
        for (length, step, multiple) in [(0.29, 0.1, 0.3), (-1.24, 0.1, -1.2), (7.0, 5.0, 5.0), (0.3, 0.0, 0.3)] {
            assert_eq!(snapped(length, step), multiple);
        }
    }
}
