//! Moves the selection without the mouse: by steps, and down onto what is below.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::things;
use crate::app::editor::camera::{picking, pose, rounding};
use crate::app::editor::command::Direction;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::PackedScene;
use crate::math::Ray;
use crate::scene::ToWorld;

pub fn nudge(edit: &mut Edit, direction: Direction) -> Result<(), CommandError> {
    let selected = things::selected(edit)?;
    let by = step(edit.world, direction);
    let exact = 0.0;
    move_each(edit, selected.into_iter().map(|entity| (entity, by)).collect(), exact)
}

/// A step of the gizmo, in world space.
pub fn step(world: &World, direction: Direction) -> Vec3 {
    let ViewSettings { gizmo, navigation, .. } = world.resource::<ViewSettings>();
    let length = gizmo.steps.length_in(navigation.scene_size);
    let pose = pose::view_pose(world).unwrap_or(Affine3A::IDENTITY);
    along(direction, navigation.upright(&pose), navigation.up, &pose) * length
}

/// The axis of the world that is nearest to a direction as the camera sees it, of unit length.
fn along(direction: Direction, upright: Vec3, up: Vec3, pose: &Affine3A) -> Vec3 {
    let left = upright.cross(pose.matrix3.z_axis.into());
    // Movement on the ground: if the camera looks straight down, its upper edge is ahead.
    let ahead = left.cross(up);
    let wanted = match direction {
        Direction::Left => left,
        Direction::Right => -left,
        Direction::Ahead => ahead,
        Direction::Back => -ahead,
        Direction::Up => up,
        Direction::Down => -up,
    };
    let axis = wanted.abs().max_position();
    Vec3::AXES[axis] * wanted[axis].signum()
}

pub fn drop(edit: &mut Edit) -> Result<(), CommandError> {
    let selected = things::selected(edit)?;
    let navigation = edit.world.resource::<ViewSettings>().navigation;
    let up = navigation.up;
    let packed = edit.world.resource::<PackedScene>();
    let bounds = picking::bounds_of_each(packed, &selected);
    let falls = selected.iter().zip(bounds).filter_map(|(&entity, bounds)| {
        let place = Vec3::from(edit.world.get::<ToWorld>(entity)?.0.translation);
        let (middle, half) = bounds.map_or((place, 0.0), |bounds| {
            (bounds.center(), 0.5 * bounds.extent().dot(up.abs()))
        });
        // The ray starts at the middle, so that a thing that has sunk in a little comes up again.
        let below = picking::surface(packed, &Ray::new(middle, -up), |other| selected.contains(&other))?;
        Some((entity, up * (below.position + up * half - middle).dot(up)))
    });
    let falls: Vec<(Entity, Vec3)> = falls.collect();
    if falls.is_empty() {
        return Err("There is nothing below.".into());
    }
    move_each(edit, falls, rounding::unit_of_scene(navigation.scene_size))
}

/// Puts the origins of things onto multiples of the step.
pub fn onto_grid(edit: &mut Edit) -> Result<(), CommandError> {
    let ViewSettings {
        gizmo,
        navigation,
        grid,
        ..
    } = edit.world.resource::<ViewSettings>();
    // A grid without a step of its own depends on the view.
    let step = grid
        .step
        .unwrap_or_else(|| gizmo.steps.length_in(navigation.scene_size));
    let step = f64::from(step);
    let poses = things::selected(edit)?.into_iter().filter_map(|entity| {
        let pose = edit.world.get::<ToWorld>(entity)?.0;
        let place = rounding::rounded_place(pose.translation.into(), step);
        // A step such as 0.1 is no number of single precision.
        let translation = rounding::rounded_place(place, rounding::unit_below(1e-3 * step as f32)).into();
        Some((entity, Affine3A { translation, ..pose }))
    });
    let poses = poses.collect();
    things::transform(edit, poses)
}

/// Moves things, and rounds the coordinates that change to `unit`.
fn move_each(edit: &mut Edit, moves: Vec<(Entity, Vec3)>, unit: f64) -> Result<(), CommandError> {
    let moved = moves.into_iter().filter_map(|(entity, by)| {
        let mut pose = edit.world.get::<ToWorld>(entity)?.0;
        pose.translation = rounding::moved(pose.translation.into(), by, unit).into();
        Some((entity, pose))
    });
    let moved: Vec<(Entity, Affine3A)> = moved.collect();
    things::transform(edit, moved)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_go_where_the_picture_shows_them() {
        let looks_along = |forward: Vec3| {
            let left = Vec3::Y.cross(forward).normalize();
            let matrix = bevy::math::Mat3::from_cols(left, forward.cross(left), forward);
            Affine3A::from_mat3(matrix)
        };
        let pose = looks_along(Vec3::new(0.3, -0.8, -1.0).normalize());
        let go = |direction| along(direction, Vec3::Y, Vec3::Y, &pose);
        assert_eq!((go(Direction::Ahead), go(Direction::Back)), (Vec3::NEG_Z, Vec3::Z));
        // For a view along -z, +x is to the right.
        assert_eq!((go(Direction::Right), go(Direction::Left)), (Vec3::X, Vec3::NEG_X));
        assert_eq!((go(Direction::Up), go(Direction::Down)), (Vec3::Y, Vec3::NEG_Y));
    }

    #[test]
    fn from_above_ahead_is_the_upper_edge() {
        // Looks straight down with -z at the upper edge.
        let matrix = bevy::math::Mat3::from_cols(Vec3::NEG_X, Vec3::NEG_Z, Vec3::NEG_Y);
        let pose = Affine3A::from_mat3(matrix);
        assert_eq!(along(Direction::Ahead, Vec3::NEG_Z, Vec3::Y, &pose), Vec3::NEG_Z);
        assert_eq!(along(Direction::Right, Vec3::NEG_Z, Vec3::Y, &pose), Vec3::X);
    }
}
