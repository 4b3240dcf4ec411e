//! The gizmo: handles over the picture by which the selected objects are moved, turned and scaled. What it is and where it stands; how
//! it looks is in `handles` and `paint`, what dragging does in `drag`.
//!
//! Scaling is always along an object's own axes: along others it would shear what is turned.

pub mod drag;
pub mod handles;
pub mod interaction;
pub mod paint;
pub mod typed;

use std::ops::RangeInclusive;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;
use serde::{Deserialize, Serialize};

use super::panels::transform::Freedom;
use crate::math::Aabb;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    #[default]
    Move,
    Rotate,
    Scale,
}

/// Along whose axes things are moved and turned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    #[default]
    World,
    /// Those of the active object.
    Local,
}

/// The point that stays where it is when things are turned and scaled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pivot {
    /// The middle of the selection's bounds.
    #[default]
    Middle,
    /// The origin of the active object's own space.
    Active,
    /// For each object the origin of its own space.
    Each,
}

impl Pivot {
    pub const ALL: [(Self, &'static str); 3] = [
        (Self::Middle, "Middle"),
        (Self::Active, "Active origin"),
        (Self::Each, "Own origins"),
    ];
}

/// What Control rounds a drag to, and the arrow keys move by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Steps {
    /// World units; None for what suits the scene.
    pub length: Option<f32>,
    pub degrees: f32,
    /// Of the factor of a scaling.
    pub factor: f32,
}

/// What steps can be set to, each in its unit.
pub const LENGTHS: RangeInclusive<f32> = 1e-6..=1e6;
pub const DEGREES: RangeInclusive<f32> = 0.1..=180.0;
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
    /// Without values that no control could set.
    pub fn within_range(self) -> Self {
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

    /// The step of lengths in a scene of this size: what was chosen, or a round number near a fiftieth of the scene.
    pub fn length_in(&self, scene_size: f32) -> f32 {
        self.length.unwrap_or_else(|| round_number(scene_size / 50.0))
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is not above `x`; 1 for what is no positive number.
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

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GizmoSettings {
    pub mode: Mode,
    pub axes: Axes,
    pub pivot: Pivot,
    pub steps: Steps,
}

/// An object to be moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    pub entity: Entity,
    pub to_world: Affine3A,
    pub freedom: Freedom,
    /// World bounds; None for what has no surface.
    pub bounds: Option<Aabb>,
}

impl Target {
    pub fn origin(&self) -> Vec3 {
        self.to_world.translation.into()
    }

    /// The middle of what is seen of it.
    pub fn middle(&self) -> Vec3 {
        self.bounds.map_or(self.origin(), |bounds| bounds.center())
    }

    fn has_place(&self) -> bool {
        self.freedom != Freedom::Turning
    }
}

/// Where the gizmo stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub origin: Vec3,
    /// Of unit length, at right angles.
    pub axes: [Vec3; 3],
}

/// World bounds of all that have a place; empty without one.
pub fn bounds(targets: &[Target]) -> Aabb {
    let placed = targets.iter().filter(|target| target.has_place());
    placed.fold(Aabb::EMPTY, |all, target| match target.bounds {
        Some(bounds) => all.union(bounds),
        None => all.grown(target.origin()),
    })
}

/// None when there is nothing that this mode could change. The active object is the last one. What is infinitely far away is turned at
/// `ahead`, a place that is seen.
pub fn frame(targets: &[Target], settings: &GizmoSettings, ahead: Vec3) -> Option<Frame> {
    let active = targets.last()?;
    let all = bounds(targets);
    if all.is_empty() && settings.mode != Mode::Rotate {
        return None;
    }
    let can_scale = |target: &Target| target.freedom == Freedom::Affine;
    if settings.mode == Mode::Scale && targets.len() == 1 && !can_scale(active) {
        return None;
    }
    let origin = if all.is_empty() {
        ahead
    } else if settings.pivot == Pivot::Middle || !active.has_place() {
        all.center()
    } else {
        active.origin()
    };
    let axes = if settings.axes == Axes::Local || settings.mode == Mode::Scale {
        own_axes(&active.to_world)
    } else {
        [Vec3::X, Vec3::Y, Vec3::Z]
    };
    origin.is_finite().then_some(Frame { origin, axes })
}

/// The directions of a transform's axes, set at right angles from the first on; the world's for a degenerate one.
fn own_axes(to_world: &Affine3A) -> [Vec3; 3] {
    let [x, y, z] = [
        to_world.matrix3.x_axis,
        to_world.matrix3.y_axis,
        to_world.matrix3.z_axis,
    ]
    .map(Vec3::from);
    let axes = || {
        let x = x.try_normalize()?;
        let y = y.try_normalize()?.reject_from_normalized(x).try_normalize()?;
        let normal = x.cross(y);
        Some([x, y, if normal.dot(z) < 0.0 { -normal } else { normal }])
    };
    axes().unwrap_or([Vec3::X, Vec3::Y, Vec3::Z])
}

#[cfg(test)]
mod tests {
    use bevy::math::Quat;

    use super::*;

    fn target(to_world: Affine3A, freedom: Freedom) -> Target {
        Target {
            entity: Entity::PLACEHOLDER,
            to_world,
            freedom,
            bounds: (freedom == Freedom::Affine).then(|| {
                Aabb {
                    min: Vec3::NEG_ONE,
                    max: Vec3::ONE,
                }
                .transformed(&to_world)
            }),
        }
    }

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

    #[test]
    fn the_pivot_is_a_choice() {
        let left = target(Affine3A::from_translation(Vec3::new(-4.0, 0.0, 0.0)), Freedom::Affine);
        let right = target(Affine3A::from_translation(Vec3::new(8.0, 0.0, 0.0)), Freedom::Affine);
        let at = |pivot| {
            let settings = GizmoSettings {
                pivot,
                ..GizmoSettings::default()
            };
            frame(&[left, right], &settings, Vec3::ZERO).map(|frame| frame.origin)
        };
        assert_eq!(at(Pivot::Middle), Some(Vec3::new(2.0, 0.0, 0.0)));
        assert_eq!(at(Pivot::Active), Some(Vec3::new(8.0, 0.0, 0.0)));
    }

    #[test]
    fn what_cannot_be_done_has_no_gizmo() {
        let sky = target(Affine3A::IDENTITY, Freedom::Turning);
        let camera = target(Affine3A::IDENTITY, Freedom::Rigid);
        let in_mode = |targets: &[Target], mode| {
            let settings = GizmoSettings {
                mode,
                ..GizmoSettings::default()
            };
            frame(targets, &settings, Vec3::Y)
        };
        assert_eq!(in_mode(&[sky], Mode::Move), None);
        assert_eq!(in_mode(&[sky], Mode::Rotate).map(|frame| frame.origin), Some(Vec3::Y));
        assert_eq!(in_mode(&[camera], Mode::Scale), None);
        assert!(in_mode(&[camera], Mode::Move).is_some());
        assert_eq!(in_mode(&[], Mode::Move), None);
    }

    #[test]
    fn local_axes_are_at_right_angles_whatever_the_transform() {
        let turned =
            Affine3A::from_scale_rotation_translation(Vec3::new(2.0, -3.0, 0.5), Quat::from_rotation_y(0.4), Vec3::ONE);
        let mut sheared = turned;
        sheared.matrix3.y_axis += sheared.matrix3.x_axis;
        for (to_world, degenerate) in [(turned, false), (sheared, false), (Affine3A::ZERO, true)] {
            let axes = own_axes(&to_world);
            for (k, axis) in axes.iter().enumerate() {
                assert!((axis.length() - 1.0).abs() < 1e-5);
                assert!(axis.dot(axes[(k + 1) % 3]).abs() < 1e-5);
                let own = Vec3::from(to_world.matrix3.col(k));
                assert!(degenerate || axis.dot(own) > 0.0, "{k}: {axis}");
            }
        }
    }
}
