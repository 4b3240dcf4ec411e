//! The settings of the gizmo: mode, axes, pivot and steps.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::snapping::Snapping;

/// The effect of a drag of the gizmo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Moves along axes and in planes.
    #[default]
    Move,
    /// Turns about axes.
    Rotate,
    /// Scales along axes, or evenly.
    Scale,
}

/// The axes along which things are moved and turned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// The axes of the world.
    #[default]
    World,
    /// The axes of the active object.
    Local,
}

/// The fixed point of rotations and scalings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pivot {
    /// The middle of the selection's bounds.
    #[default]
    Middle,
    /// The origin of the active object's own space.
    Active,
    /// Each object turns about the origin of its own space.
    Each,
    /// The mean of the objects' origins, which does not depend on their sizes.
    Median,
    /// The origin of the world. Moves have their handles in the middle of the selection.
    World,
}

impl Pivot {
    /// The pivots with their names, in the order of the menu.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Middle, "Middle"),
        (Self::Median, "Median"),
        (Self::Active, "Active origin"),
        (Self::Each, "Own origins"),
        (Self::World, "World origin"),
    ];
}

/// The steps to which Control rounds a drag, and by which the arrow keys move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Steps {
    /// The step in world units; None for one that suits the scene.
    pub length: Option<f32>,
    /// The step of rotations.
    pub degrees: f32,
    /// The step of a scaling factor.
    pub factor: f32,
}

/// The ranges of steps, each in its unit.
pub const LENGTHS: RangeInclusive<f32> = 1e-6..=1e6;
/// The range of [`Steps::degrees`].
pub const DEGREES: RangeInclusive<f32> = 0.1..=180.0;
/// The range of [`Steps::factor`].
pub const FACTORS: RangeInclusive<f32> = 0.001..=10.0;

impl Default for Steps {
    fn default() -> Self {
        Self {
            length: None,
            degrees: 15.0,
            factor: 0.1,
        }
    }
}

impl Steps {
    /// The steps with values limited to what the controls can set.
    pub(crate) fn within_range(self) -> Self {
        let default = Self::default();
        let sound = |value: f32, range: RangeInclusive<f32>, otherwise: f32| match value.is_nan() {
            true => otherwise,
            false => value.clamp(*range.start(), *range.end()),
        };
        Self {
            length: self.length.filter(|length| LENGTHS.contains(length)),
            degrees: sound(self.degrees, DEGREES, default.degrees),
            factor: sound(self.factor, FACTORS, default.factor),
        }
    }

    /// The step of lengths in a scene of this size: the chosen one, or a round number near a fiftieth of the scene.
    pub(crate) fn length_in(&self, scene_size: f32) -> f32 {
        self.length.unwrap_or_else(|| round_number(scene_size / 50.0))
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is not above `x`; 1 if `x` is not a positive number.
fn round_number(x: f32) -> f32 {
    if !(x.is_finite() && x > f32::MIN_POSITIVE) {
        return 1.0;
    }
    let power = 10f64.powi(x.log10().floor() as i32);
    let digit = [5.0, 2.0]
        .into_iter()
        .find(|digit| digit * power <= f64::from(x) * 1.0001);
    (digit.unwrap_or(1.0) * power) as f32
}

/// The settings of a drag of the gizmo.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GizmoSettings {
    /// The effect of a drag.
    pub mode: Mode,
    /// The axes. Scaling ignores them, because it is along the object's own axes.
    pub axes: Axes,
    /// The fixed point of rotations and scalings.
    pub pivot: Pivot,
    /// The steps of drags with Control and of arrow keys.
    pub steps: Steps,
    /// The target of snapping.
    pub snap: Snapping,
    /// Whether the handles are hidden, so that clicks only select. The key of a mode shows them again.
    pub is_hidden: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_suit_the_scene() {
        for (x, round) in [(0.03, 0.02), (7.0, 5.0), (1.0, 1.0), (0.0, 1.0), (f32::NAN, 1.0)] {
            assert!((round_number(x) - round).abs() < 1e-6, "{x}: {}", round_number(x));
        }
        let chosen = Steps {
            length: Some(0.3),
            ..Steps::default()
        };
        assert_eq!(chosen.length_in(100.0), 0.3);
        assert_eq!(Steps::default().length_in(100.0), 2.0);
    }
}
