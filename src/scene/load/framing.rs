//! The extent of the scene, and a camera for scenes without one.

use bevy::math::Affine3A;
use bevy::prelude::*;
use glam::Vec3;

use crate::math::Aabb;
use crate::scene::{MeshHandle, SceneStatus, Sensor, Shape, ShapeKind, ToWorld, TriangleMesh};

/// Requests that this sensor is placed to see the whole scene, once all meshes are loaded.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct FrameWhenLoaded;

/// World bounds of one shape; None while its mesh is missing, and for instances of groups and shapes without a surface.
pub fn world_bounds(shape: &Shape, to_world: &Affine3A, mesh: Option<&TriangleMesh>) -> Option<Aabb> {
    let local = match &shape.kind {
        ShapeKind::Sphere { center, radius } => Aabb::from_points([*center - *radius, *center + *radius]),
        ShapeKind::Rectangle | ShapeKind::Disk => {
            Aabb::from_points([Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 0.0)])
        }
        ShapeKind::Triangle { corners } => Aabb::from_points(*corners),
        ShapeKind::Cube => Aabb::from_points([Vec3::NEG_ONE, Vec3::ONE]),
        ShapeKind::Cylinder { p0, p1, radius } => {
            // The extent of a circle around an axis of this direction along each axis of the space.
            let along = (*p1 - *p0).normalize_or_zero();
            let reach =
                *radius * Vec3::from_array((Vec3::ONE - along * along).to_array().map(|part| part.max(0.0).sqrt()));
            Aabb::from_points([p0.min(*p1) - reach, p0.max(*p1) + reach])
        }
        ShapeKind::Solid(solid) => Aabb::from_points(solid.corners()),
        ShapeKind::Instance | ShapeKind::Frame => return None,
        ShapeKind::Mesh(file) => {
            let shape = mesh?.shapes.get(file.shape_index as usize)?;
            if file.format.is_of_curves() {
                return Some(shape.data.strands.bounds_in(to_world));
            }
            shape.bounds
        }
    };
    Some(local.transformed(to_world))
}

/// Looks along +z from in front of the scene, as Mitsuba does for scenes without a sensor.
pub(in crate::scene) fn frame_scene(
    mut commands: Commands,
    status: Res<SceneStatus>,
    meshes: Res<Assets<TriangleMesh>>,
    shapes: Query<(&Shape, &ToWorld, Option<&MeshHandle>)>,
    mut waiting: Query<(Entity, &mut Sensor, &mut ToWorld), (With<FrameWhenLoaded>, Without<Shape>)>,
) {
    if waiting.is_empty() || !status.is_complete() {
        return;
    }
    let corners = shapes.iter().filter_map(|(shape, to_world, mesh)| {
        world_bounds(shape, &to_world.0, mesh.and_then(|handle| meshes.get(&handle.0)))
    });
    let mut bounds = Aabb::from_points(corners.flat_map(|bounds| [bounds.min, bounds.max]));
    if bounds.is_empty() {
        bounds = Aabb::from_points([Vec3::splat(-0.5), Vec3::splat(0.5)]);
    }
    let (center, extent, radius) = (bounds.center(), bounds.extent(), bounds.framed_radius());
    for (entity, mut sensor, mut to_world) in &mut waiting {
        let half = match bounds.radius() < radius {
            // The scene is empty, so the camera is placed as for a larger one.
            true => radius,
            false => (0.5 * extent.x.max(extent.y)).max(1e-3 * radius),
        };
        let distance = half / (0.5 * sensor.fov.to_radians()).tan() + 0.5 * extent.z;
        to_world.0 = Affine3A::from_translation(center - 1.1 * distance * Vec3::Z);
        sensor.near_clip = 1e-3 * distance;
        sensor.far_clip = 1e3 * (distance + extent.length());
        commands.entity(entity).remove::<FrameWhenLoaded>();
    }
}
