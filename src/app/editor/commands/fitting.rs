//! Scales things so that they fill a third of the view, and offers this for meshes from files, whose units may differ
//! from the scene's.

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::{grouping, spot, things};
use crate::app::editor::camera::{picking, rounding};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::{ArrangeEdit, Command};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::Toasts;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::PackedScene;
use crate::math::Aabb;
use crate::scene::{ObjectState, Sensor, Shape, ShapeKind};

/// The longest side of fitted things, as a share of the height that the picture shows at their distance.
const SHARE: f32 = 1.0 / 3.0;
/// The number of significant digits of the factor.
const DIGITS: i32 = 2;

/// Scales things together so that their longest side is a third of the picture's height, and puts them onto the surface
/// in its middle.
pub fn fit_to_view(edit: &mut Edit, entities: &[Entity]) -> Result<(), CommandError> {
    let units = grouping::units_of(edit.world, entities.to_vec());
    let mut all: Vec<Entity> = units.into_iter().flat_map(|unit| unit.all).collect();
    // A camera in a group stays as large as it is.
    all.retain(|entity| edit.world.get::<Sensor>(*entity).is_none());
    let packed = edit.world.resource::<PackedScene>();
    let bounds = picking::bounds_of_each(packed, &all).into_iter().flatten();
    let bounds = bounds.fold(Aabb::EMPTY, Aabb::union);
    if bounds.is_empty() {
        return Err("It is not in the picture yet.".into());
    }
    let (seen, height) = spot::seen(edit.world, &all).ok_or("There is no picture.")?;
    let ViewSettings { navigation, .. } = edit.world.resource::<ViewSettings>();
    let (up, scene_size) = (navigation.up, navigation.scene_size);
    let longest = bounds.extent().max_element();
    let factor = rounding::with_digits(SHARE * height / longest.max(f32::MIN_POSITIVE), DIGITS);
    let foot = bounds.center() - up * (0.5 * bounds.extent().dot(up.abs()));
    let goal = spot::rounded_place(seen, factor * longest);
    let unit = rounding::unit_below(1e-3 * factor * longest).min(rounding::unit_of_scene(scene_size));
    let poses = all.iter().filter_map(|entity| {
        let pose = things::pose_of(edit.world, *entity)?;
        let place = goal + factor * (Vec3::from(pose.translation) - foot);
        Some((
            *entity,
            Affine3A {
                matrix3: pose.matrix3 * factor,
                translation: rounding::rounded_place(place, unit).into(),
            },
        ))
    });
    let poses = poses.collect();
    things::transform(edit, poses)
}

/// Remembers the selected meshes of an import, whose size is reported once they are loaded.
pub fn note_import(world: &mut World) {
    let made = world.resource::<Selection>().entities().to_vec();
    let is_mesh = |entity: &Entity| {
        let shape = world.get::<Shape>(*entity);
        shape.is_some_and(|shape| matches!(shape.kind, ShapeKind::Mesh(_)))
    };
    if let [only] = made[..]
        && is_mesh(&only)
    {
        world.resource_mut::<Requests>().imported.push(only);
    }
}

/// Reports the size of imported meshes as soon as they are in the picture.
pub(crate) fn tell_sizes(world: &mut World) {
    if world.resource::<Requests>().imported.is_empty() {
        return;
    }
    let imported = std::mem::take(&mut world.resource_mut::<Requests>().imported);
    for entity in imported {
        if !ObjectState::is_in_scene(world, entity) {
            continue;
        }
        match picking::bounds_of(world.resource::<PackedScene>(), entity) {
            None => world.resource_mut::<Requests>().imported.push(entity),
            Some(bounds) => {
                let name = world.get::<Name>(entity).map_or_else(String::new, Name::to_string);
                let [x, y, z] = bounds.extent().to_array().map(|side| rounding::with_digits(side, 3));
                let text = format!("{name} measures {x} × {y} × {z} units.");
                let fit = Command::from(ArrangeEdit::FitToView(vec![entity]));
                world.resource_mut::<Toasts>().offer(text, "Fit to view", fit);
            }
        }
    }
}
