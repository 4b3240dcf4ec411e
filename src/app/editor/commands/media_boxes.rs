//! Boxes of media, and the media of entities inside of them.

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::media::{fog, null_material, spawn};
use super::spot;
use crate::app::editor::camera::{picking, pose, rounding};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::toasts::Toasts;
use crate::engine::PackedScene;
use crate::math::Aabb;
use crate::scene::insert::next_order;
use crate::scene::names::free_name_for;
use crate::scene::{
    DocumentOrder, ExteriorMedium, InMedium, InteriorMedium, LengthUnit, Medium, SceneId, Sensor, Shape, ShapeKind,
    ToWorld, UsesMaterial,
};

/// The depth to which a box of a medium is sunk into the surface it stands on, in half heights. If its face were in the
/// same plane, light would meet one or the other at random.
pub const SUNK: f32 = 0.02;
/// Half the edge of the box of fog in a scene without shapes, in world units.
const ALONE: f32 = 10.0;
/// The distance of the box of fog from everything, as a share of the scene's diagonal.
const AROUND: f32 = 0.05;

/// Puts the whole scene, with all cameras, into a box of fog, and returns the box. The medium is called `NAME-medium`.
pub fn surround(edit: &mut Edit, name: &str) -> Entity {
    let packed = edit.world.get_resource::<PackedScene>();
    let bounds = packed.and_then(picking::scene_bounds);
    let ahead = packed.and_then(picking::distance_ahead);
    let mut cameras = edit.world.query_filtered::<&ToWorld, With<Sensor>>();
    let mut eyes: Vec<Vec3> = cameras.iter(edit.world).map(|pose| pose.0.translation.into()).collect();
    eyes.extend(pose::view_pose(edit.world).map(|pose| Vec3::from(pose.translation)));
    let bounds = bounds.unwrap_or(Aabb {
        min: Vec3::splat(-ALONE),
        max: Vec3::splat(ALONE),
    });
    let bounds = eyes.into_iter().fold(bounds, Aabb::grown);
    let size = bounds.extent().length();
    let half = (0.5 * bounds.extent() + Vec3::splat(AROUND * size)).map(|half| rounding::with_digits(half, 3));
    let center = spot::rounded_place(bounds.center(), size);
    let pose = Affine3A::from_translation(center) * Affine3A::from_scale(half);
    // In the middle of the picture four tenths of the light are the fog's.
    let medium = fog(2.0 * ahead.filter(|ahead| *ahead > 0.0).unwrap_or(size));
    bounded(edit, name, pose, medium)
}

/// A box with the material `null` and this pose, filled with a new medium. Cameras and borders inside are set to that
/// medium.
pub fn bounded(edit: &mut Edit, name: &str, pose: Affine3A, medium: Medium) -> Entity {
    let around = around(edit.world, &pose);
    let null = null_material(edit);
    let order = DocumentOrder(next_order(edit.world));
    let name = free_name_for(edit.world, name);
    let shape = Shape {
        kind: ShapeKind::Cube,
        ..Shape::default()
    };
    let called = (SceneId(name.clone()), Name::new(name.clone()));
    let entity = edit.spawn((shape, order, called, ToWorld(pose), UsesMaterial(null)));
    let medium = spawn(edit, &format!("{name}-medium"), medium);
    edit.set(entity, InteriorMedium(medium));
    if let Some(around) = around {
        edit.set(entity, ExteriorMedium(around));
    }
    enclose(edit, entity, &pose, medium);
    tell_density(edit.world, medium);
    entity
}

/// Shows the density of the fog in a message, because the program has chosen it.
fn tell_density(world: &mut World, medium: Entity) {
    let path = world.get::<Medium>(medium).and_then(Medium::mean_free_path);
    let unit = world.get_resource::<LengthUnit>().copied().unwrap_or_default();
    if let (Some(path), Some(mut toasts)) = (path, world.get_resource_mut::<Toasts>()) {
        let half = rounding::with_digits(std::f32::consts::LN_2 * path.max_element(), 2);
        let length = match unit.sign().is_empty() {
            true => format!("{} units", unit.number(half)),
            false => unit.text(half),
        };
        toasts.info(format!(
            "Half of the light gets through {length} of this fog. Extinction in the inspector makes it thinner or thicker."
        ));
    }
}

/// Sets the medium of a cube as exterior of the cameras and borders in it that are in no other medium.
fn enclose(edit: &mut Edit, cube: Entity, pose: &Affine3A, medium: Entity) {
    let local = pose.inverse();
    let is_inside = |point: Vec3| local.transform_point3(point).abs().max_element() < 1.0;
    let mut cameras = edit
        .world
        .query_filtered::<(Entity, &ToWorld), (With<Sensor>, Without<InMedium>)>();
    let cameras = cameras.iter(edit.world);
    let cameras = cameras.filter(|(_, pose)| is_inside(pose.0.translation.into()));
    let cameras: Vec<Entity> = cameras.map(|(camera, _)| camera).collect();
    for camera in cameras {
        edit.set(camera, InMedium(medium));
    }
    let mut borders = edit
        .world
        .query_filtered::<(Entity, &ToWorld, &Shape), (With<InteriorMedium>, Without<ExteriorMedium>)>();
    let borders = borders.iter(edit.world).filter(|(entity, pose, shape)| {
        let middle = pose.0.transform_point3(shape.middle());
        *entity != cube && is_inside(middle)
    });
    let borders: Vec<Entity> = borders.map(|(entity, ..)| entity).collect();
    for border in borders {
        edit.set(border, ExteriorMedium(medium));
    }
}

/// The medium of the smallest cube that contains this one.
fn around(world: &mut World, pose: &Affine3A) -> Option<Entity> {
    let corners: Vec<Vec3> = (0..8)
        .map(|corner| {
            let sign = |axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            pose.transform_point3(Vec3::new(sign(0), sign(1), sign(2)))
        })
        .collect();
    let mut cubes = world.query::<(&Shape, &ToWorld, &InteriorMedium, &DocumentOrder)>();
    let holding = cubes.iter(world).filter(|(shape, pose, ..)| {
        let local = pose.0.inverse();
        let is_inside = |corner: &Vec3| local.transform_point3(*corner).abs().max_element() < 1.0;
        shape.kind == ShapeKind::Cube && corners.iter().all(is_inside)
    });
    let volume = |pose: &ToWorld| pose.0.matrix3.determinant().abs();
    let smallest = holding.min_by(|(_, one, _, first), (_, other, _, second)| {
        volume(one).total_cmp(&volume(other)).then(first.cmp(second))
    });
    smallest.map(|(_, _, medium, _)| medium.0)
}
