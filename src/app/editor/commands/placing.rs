//! Moves the selection without the mouse: by steps, and down onto the surface below.

use std::collections::HashSet;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::{arranging, fitting, grouping, things};
use crate::app::editor::camera::{picking, pose, rounding};
use crate::app::editor::command::ArrangeEdit;
use crate::app::editor::command::arrange::Direction;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::{Edit, StepKind};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::PackedScene;
use crate::math::{Aabb, Ray};

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: ArrangeEdit) -> Result<(), CommandError> {
    match command {
        ArrangeEdit::Align(axis, side, to) => arranging::align(edit, axis, side, to)?,
        ArrangeEdit::Distribute(axis, by) => arranging::distribute(edit, axis, by)?,
        ArrangeEdit::Resize(axis, size) => arranging::resize(edit, axis, size)?,
        ArrangeEdit::FitToView(entities) => fitting::fit_to_view(edit, &entities)?,
        ArrangeEdit::Nudge(direction) => {
            let by = step(edit.world, direction);
            nudge(edit, by)?;
        }
        ArrangeEdit::NudgeAlong(direction) => {
            let length = edit.world.resource::<ViewSettings>().length_step();
            nudge(edit, nearest_axis(direction) * length)?;
        }
        ArrangeEdit::Drop => drop(edit)?,
        ArrangeEdit::SnapToGrid => onto_grid(edit)?,
    }
    Ok(())
}

/// Moves the selection by a vector in world space.
fn nudge(edit: &mut Edit, by: Vec3) -> Result<(), CommandError> {
    edit.kind = StepKind::Move;
    let units = grouping::units(edit)?;
    let exact = 0.0;
    let all = units.into_iter().flat_map(|unit| unit.all);
    move_each(edit, all.map(|entity| (entity, by)).collect(), exact)
}

/// A step of the gizmo, in world space.
pub fn step(world: &World, direction: Direction) -> Vec3 {
    let settings = world.resource::<ViewSettings>();
    let (length, navigation) = (settings.length_step(), &settings.navigation);
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
    nearest_axis(wanted)
}

/// The axis of the world that is nearest to a direction, of unit length.
fn nearest_axis(direction: Vec3) -> Vec3 {
    let axis = direction.abs().max_position();
    Vec3::AXES[axis] * direction[axis].signum()
}

pub fn drop(edit: &mut Edit) -> Result<(), CommandError> {
    let units = grouping::units(edit)?;
    let navigation = edit.world.resource::<ViewSettings>().navigation;
    let up = navigation.up;
    let packed = edit.world.resource::<PackedScene>();
    let listed: Vec<Entity> = units.iter().flat_map(|unit| unit.all.iter().copied()).collect();
    let all: HashSet<Entity> = listed.iter().copied().collect();
    let mut bounds = picking::bounds_of_each(packed, &listed).into_iter();
    let falls = units.iter().filter_map(|unit| {
        let own = bounds.by_ref().take(unit.all.len()).flatten().reduce(Aabb::union);
        let place = Vec3::from(things::pose_of(edit.world, unit.lead)?.translation);
        let (middle, half) = own.map_or((place, 0.0), |bounds| {
            (bounds.center(), 0.5 * bounds.extent().dot(up.abs()))
        });
        // The ray starts at the middle, so that a thing that has sunk in a little comes up again.
        let below = picking::surface(packed, &Ray::new(middle, -up), |other| all.contains(&other))?;
        Some((unit, up * (below.position + up * half - middle).dot(up)))
    });
    let falls: Vec<(Entity, Vec3)> = falls
        .flat_map(|(unit, by)| unit.all.iter().map(move |entity| (*entity, by)))
        .collect();
    if falls.is_empty() {
        return Err("There is nothing below.".into());
    }
    move_each(edit, falls, rounding::unit_of_scene(navigation.scene_size))
}

/// Puts the origins of things onto multiples of the step.
pub fn onto_grid(edit: &mut Edit) -> Result<(), CommandError> {
    let settings = edit.world.resource::<ViewSettings>();
    // A grid without a step of its own depends on the view.
    let step = settings.grid.step.unwrap_or_else(|| settings.length_step());
    let step = f64::from(step);
    let units = grouping::units(edit)?;
    let moves = units.iter().filter_map(|unit| {
        let place = Vec3::from(things::pose_of(edit.world, unit.lead)?.translation);
        Some((unit, rounding::rounded_place(place, step) - place))
    });
    let moves = moves.flat_map(|(unit, by)| unit.all.iter().map(move |entity| (*entity, by)));
    let moves = moves.collect();
    move_each(edit, moves, rounding::unit_below(1e-5 * step as f32))
}

/// Moves things, and rounds the coordinates that change to `unit`.
fn move_each(edit: &mut Edit, moves: Vec<(Entity, Vec3)>, unit: f64) -> Result<(), CommandError> {
    let moved = moves.into_iter().filter_map(|(entity, by)| {
        let mut pose = things::pose_of(edit.world, entity)?;
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
