//! The edits of the measurement.

use bevy::math::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use bevy::prelude::*;

use super::super::acts;
use crate::app::editor::camera::picking::{scene_bounds, seen_in};
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::camera::solid::{Solid, solids_of_each};
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::{Command, SceneEdit, SelectionCommand, ViewCommand};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::PackedScene;
use crate::scene::AreaLight;

/// Chooses the commands of an edit, for the first or a further attempt; None if the scene has nothing for it.
type Choose = fn(&mut World, usize) -> Option<Vec<Command>>;

pub(super) const EDITS: [(&str, Choose); 6] = [
    ("camera step", camera_step),
    ("small camera step", |world, attempt| one(acts::fly(world, attempt))),
    ("drag a thing", |world, attempt| one(acts::drag(world, attempt))),
    ("material slider", |world, attempt| {
        one(acts::change_material(world, attempt))
    }),
    ("lamp slider", |world, attempt| one(acts::change_light(world, attempt))),
    ("delete a thing", delete),
];

/// The move of the camera, as a share of the scene's size, and its turn, in radians.
const STEP: (f32, f32) = (0.02, 0.05);

fn one(command: Option<Command>) -> Option<Vec<Command>> {
    Some(vec![command?])
}

fn camera_step(world: &mut World, _: usize) -> Option<Vec<Command>> {
    let pose = view_pose(world)?;
    let (forward, turn) = STEP;
    let ahead = Vec3::from(pose.matrix3.z_axis).normalize_or(Vec3::Z);
    let way = forward * world.resource::<ViewSettings>().navigation.scene_size * ahead;
    one(Some(
        ViewCommand::MoveView(Affine3A {
            matrix3: pose.matrix3 * Mat3A::from_axis_angle(Vec3::Y, turn),
            translation: pose.translation + Vec3A::from(way),
        })
        .into(),
    ))
}

fn delete(world: &mut World, attempt: usize) -> Option<Vec<Command>> {
    let thing = seen_thing(world).or_else(|| acts::middle_shape(world, attempt))?;
    Some(vec![
        Command::from(SelectionCommand::Select(vec![thing], Extend::Replace)),
        Command::from(SceneEdit::Delete),
    ])
}

/// The region of the picture in which a thing is searched, and the number of points along each side.
const MIDDLE: [Vec2; 2] = [Vec2::splat(0.25), Vec2::splat(0.75)];
const PLACES: f32 = 64.0;
/// The share of the scene's size above which a thing counts as a wall or the ground.
const LARGEST: f32 = 0.5;

/// The largest thing in the middle of the picture that is no wall and no light: without its only lamp a picture is
/// black.
fn seen_thing(world: &World) -> Option<Entity> {
    let packed = world.resource::<PackedScene>();
    let mut seen = seen_in(packed, MIDDLE, [PLACES; 2]);
    seen.retain(|thing| world.get::<AreaLight>(*thing).is_none());
    let sizes: Vec<f32> = solids_of_each(packed, &seen)
        .iter()
        .map(|solids| size(solids))
        .collect();
    // The size of the view includes the distance of the camera, and the bounds include ground far beyond the visible
    // part.
    let extent = scene_bounds(packed)?.extent().length();
    let limit = LARGEST * extent.min(world.resource::<ViewSettings>().navigation.scene_size);
    Some(seen[largest_within(&sizes, limit)?])
}

/// The diagonal of the box around these solids.
fn size(solids: &[Solid]) -> f32 {
    let reach = |direction| {
        solids
            .iter()
            .map(|solid| solid.reach(direction))
            .fold(f32::MIN, f32::max)
    };
    let sides = Vec3::AXES.map(|axis| reach(axis) + reach(-axis));
    Vec3::from_array(sides).length()
}

/// The index of the largest size within the limit, or else of the smallest.
fn largest_within(sizes: &[f32], limit: f32) -> Option<usize> {
    let places = || 0..sizes.len();
    let by_size = |a: &usize, b: &usize| sizes[*a].total_cmp(&sizes[*b]);
    let within = places().filter(|place| sizes[*place] <= limit).max_by(by_size);
    within.or_else(|| places().min_by(by_size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;

    #[test]
    fn walls_are_chosen_only_where_there_is_nothing_else() {
        assert_eq!(largest_within(&[9.0, 1.0, 3.0, 2.0], 4.0), Some(2));
        assert_eq!(largest_within(&[9.0, 7.0, 8.0], 4.0), Some(1));
        assert_eq!(largest_within(&[], 4.0), None);
    }

    #[test]
    fn several_parts_are_as_large_as_the_box_around_them() {
        let cube = |min: Vec3| {
            Solid::of_bounds(Aabb {
                min,
                max: min + Vec3::ONE,
            })
        };
        let found = size(&[cube(Vec3::ZERO), cube(Vec3::new(2.0, 1.0, 0.0))]);
        assert!((found - Vec3::new(3.0, 2.0, 1.0).length()).abs() < 1e-5, "{found}");
    }
}
