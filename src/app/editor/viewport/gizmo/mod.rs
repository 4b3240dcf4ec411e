//! The gizmo: handles over the picture by which the selected objects are moved, turned and scaled. This module has its
//! targets and its frame, `handles` and `paint` its look, `drag` the effect of drags.
//!
//! Scaling is always along an object's own axes: along others it would shear a turned object.

pub mod constraint;
pub mod drag;
mod drag_text;
pub mod handles;
pub mod interaction;
pub mod paint;
mod snap;
pub mod typed;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;

use crate::app::editor::camera::rounding;
use crate::app::editor::command::gizmo_settings::{Axes, GizmoSettings, Mode, Pivot};
use crate::app::editor::model::freedom::Freedom;
use crate::math::Aabb;

/// An object to be moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The entity.
    pub entity: Entity,
    /// World from a space whose origin is the object's place, as `Command::Transform` has it.
    pub to_world: Affine3A,
    /// The freedom of the pose.
    pub freedom: Freedom,
    /// The bounds in the world; None for things without a surface.
    pub bounds: Option<Aabb>,
}

impl Target {
    /// Its place in the world.
    pub fn origin(&self) -> Vec3 {
        self.to_world.translation.into()
    }

    /// The middle of its visible part.
    pub fn middle(&self) -> Vec3 {
        self.bounds.map_or(self.origin(), |bounds| bounds.center())
    }

    fn has_place(&self) -> bool {
        self.freedom != Freedom::Turning
    }
}

/// The pose of the gizmo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The origin in the world.
    pub origin: Vec3,
    /// The axes, of unit length and at right angles.
    pub axes: [Vec3; 3],
}

/// World bounds of all targets that have a place; empty if none has.
pub fn bounds(targets: &[Target]) -> Aabb {
    let placed = targets.iter().filter(|target| target.has_place());
    placed.fold(Aabb::EMPTY, |all, target| match target.bounds {
        Some(bounds) => all.union(bounds),
        None => all.grown(target.origin()),
    })
}

/// The move along x, by whole steps, that puts copies beside the targets.
pub(crate) fn step_beside(targets: &[Target], step: f32) -> Vec3 {
    let width = bounds(targets).extent().x.max(0.0);
    let steps = (width / step.max(f32::MIN_POSITIVE) + 1e-3).floor() + 1.0;
    Vec3::X * rounding::rounded(step * steps, rounding::unit_below(1e-3 * step))
}

/// The frame; None if this mode could change nothing. The active object is the last one. Things that are infinitely far
/// away are turned at `ahead`, a visible place.
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
    } else {
        match settings.pivot {
            Pivot::Active | Pivot::Each if active.has_place() => active.origin(),
            Pivot::Median => median(targets),
            Pivot::World if settings.mode != Mode::Move => Vec3::ZERO,
            Pivot::Middle | Pivot::World | Pivot::Active | Pivot::Each => all.center(),
        }
    };
    let axes = if settings.axes == Axes::Local || settings.mode == Mode::Scale {
        own_axes(&active.to_world)
    } else {
        [Vec3::X, Vec3::Y, Vec3::Z]
    };
    origin.is_finite().then_some(Frame { origin, axes })
}

/// The mean of the origins of all targets that have a place.
fn median(targets: &[Target]) -> Vec3 {
    let placed = || targets.iter().filter(|target| target.has_place());
    let sum: Vec3 = placed().map(Target::origin).sum();
    sum / placed().count().max(1) as f32
}

/// The directions of a transform's axes, orthogonalized from the first on; the world's axes for a degenerate transform.
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
        assert_eq!(at(Pivot::Median), Some(Vec3::new(2.0, 0.0, 0.0)));
        // Handles for moves are in the middle of the things themselves.
        assert_eq!(at(Pivot::World), at(Pivot::Middle));
        let turning = GizmoSettings {
            pivot: Pivot::World,
            mode: Mode::Rotate,
            ..GizmoSettings::default()
        };
        let frame = frame(&[left, right], &turning, Vec3::ONE);
        assert_eq!(frame.map(|frame| frame.origin), Some(Vec3::ZERO));
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
