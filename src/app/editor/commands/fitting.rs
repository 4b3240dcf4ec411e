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

/// Remembers the selected mesh or group of an import, whose size is reported once it is loaded.
pub fn note_import(world: &mut World) {
    let made = world.resource::<Selection>();
    let Some(lead) = made.active() else { return };
    let is_alone = made.entities().len() == 1;
    let has_mesh = made.entities().iter().any(|entity| is_mesh(world, *entity));
    if has_mesh && (is_alone || grouping::is_frame(world, lead)) {
        world.resource_mut::<Requests>().imported.push(lead);
    }
}

fn is_mesh(world: &World, entity: Entity) -> bool {
    let shape = world.get::<Shape>(entity);
    shape.is_some_and(|shape| matches!(shape.kind, ShapeKind::Mesh(_)))
}

/// The bounds of a thing, or of a group without its lights; None unless all its meshes are in the picture.
fn whole_bounds(world: &mut World, entity: Entity) -> Option<Aabb> {
    let mut meshes = grouping::whole_groups(world, vec![entity]);
    meshes.retain(|entity| is_mesh(world, *entity));
    let bounds = picking::bounds_of_each(world.resource::<PackedScene>(), &meshes);
    let bounds: Vec<Aabb> = bounds.into_iter().collect::<Option<_>>()?;
    bounds.into_iter().reduce(Aabb::union)
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
        match whole_bounds(world, entity) {
            None => world.resource_mut::<Requests>().imported.push(entity),
            Some(bounds) => {
                let name = world.get::<Name>(entity).map_or("", |name| name.as_str());
                let name = name.trim_end_matches('/').to_owned();
                let [x, y, z] = bounds.extent().to_array().map(|side| rounding::with_digits(side, 3));
                let text = format!("{name} measures {x} × {y} × {z} units.");
                let fit = Command::from(ArrangeEdit::FitToView(vec![entity]));
                world.resource_mut::<Toasts>().offer(text, "Fit to view", fit);
            }
        }
    }
}
