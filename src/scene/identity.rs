//! What every entity of a scene carries: its place in the file, its id there, its place in the world.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

/// Position in the scene file. Everything that becomes a table is ordered by it, never by how the ECS happens to store entities.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[reflect(Component, PartialEq)]
pub struct DocumentOrder(pub u32);

/// The `id` attribute of the file; entities without one were declared in place.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Component, PartialEq)]
pub struct SceneId(pub String);

/// World from local, an invertible affine map (`to_world` of the file). For a sensor: +z is where it looks, +x to its left, +y up; for a
/// point light the origin is its position, for a directional light +z is where the light goes.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, PartialEq)]
pub struct ToWorld(pub Affine3A);

impl ToWorld {
    /// Whether the three axes still span a space, whatever their lengths. They do if the volume of the box along their directions is well
    /// above the rounding of single precision.
    pub fn is_invertible(&self) -> bool {
        const LEAST_VOLUME: f32 = 1e-6;
        let map = &self.0;
        let axes =
            [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(|axis| Vec3::from(axis).try_normalize());
        let [Some(x), Some(y), Some(z)] = axes else {
            return false;
        };
        map.is_finite() && map.inverse().is_finite() && x.cross(y).dot(z).abs() > LEAST_VOLUME
    }
}

/// Left out of the picture while one works on the rest. The file knows nothing of it: it is there again when the scene is opened.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
pub struct Hidden;

/// Not to be picked in the picture or moved. The file knows nothing of it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
pub struct Locked;
