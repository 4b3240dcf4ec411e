//! The extent of a shape in the world: its corners, and its support in a direction.

use std::collections::HashMap;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;

use crate::accel::{Instance, Primitive};
use crate::engine::PackedScene;
use crate::math::Aabb;

/// A convex body in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    form: Form,
    world_from_local: Affine3A,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// The bounds of a mesh or of curves.
    Box(Aabb),
    Sphere,
    Square,
    Disk,
    /// A cylinder of radius 1 around z, from z = 0 to 1.
    Cylinder,
}

impl Solid {
    fn of(instance: &Instance) -> Self {
        Self {
            form: match &instance.primitive {
                Primitive::Mesh(blas) => Form::Box(blas.bounds()),
                Primitive::Curves(curves) => Form::Box(curves.bounds()),
                Primitive::Sphere => Form::Sphere,
                Primitive::Rectangle => Form::Square,
                Primitive::Disk => Form::Disk,
                Primitive::Cylinder => Form::Cylinder,
            },
            world_from_local: instance.world_from_local,
        }
    }

    /// The solid of a box in the world.
    pub fn of_bounds(bounds: Aabb) -> Self {
        Self {
            form: Form::Box(bounds),
            world_from_local: Affine3A::IDENTITY,
        }
    }

    /// The points used to snap it to others: corners, or the extreme points of round shapes along their axes, and the
    /// middle.
    pub fn corners(&self) -> Vec<Vec3> {
        let local: Vec<Vec3> = match self.form {
            Form::Box(Aabb { min, max }) => (0..8)
                .map(|corner| {
                    Vec3::select(
                        bevy::math::BVec3::new(corner & 1 > 0, corner & 2 > 0, corner & 4 > 0),
                        max,
                        min,
                    )
                })
                .chain([0.5 * (min + max)])
                .collect(),
            Form::Square => [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (0.0, 0.0)]
                .map(|(x, y)| Vec3::new(x, y, 0.0))
                .to_vec(),
            Form::Sphere => Vec3::AXES
                .iter()
                .flat_map(|axis| [*axis, -*axis])
                .chain([Vec3::ZERO])
                .collect(),
            Form::Disk => vec![Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y, Vec3::ZERO],
            Form::Cylinder => vec![Vec3::ZERO, Vec3::Z],
        };
        let world = |point: &Vec3| self.world_from_local.transform_point3(*point);
        local.iter().map(world).collect()
    }

    /// The support: the largest dot product of `direction` and a point of it.
    pub fn reach(&self, direction: Vec3) -> f32 {
        let matrix = self.world_from_local.matrix3;
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| Vec3::from(axis).dot(direction));
        let from_origin = match self.form {
            Form::Box(Aabb { min, max }) => {
                (x * min.x).max(x * max.x) + (y * min.y).max(y * max.y) + (z * min.z).max(z * max.z)
            }
            Form::Sphere => Vec3::new(x, y, z).length(),
            Form::Square => x.abs() + y.abs(),
            Form::Disk => x.hypot(y),
            Form::Cylinder => x.hypot(y) + z.max(0.0),
        };
        Vec3::from(self.world_from_local.translation).dot(direction) + from_origin
    }
}

/// The solids of those of these things that are in the picture. An instance counts as the box around its group.
pub fn solids_of(packed: &PackedScene, entities: &[Entity]) -> Vec<Solid> {
    solids_of_each(packed, entities).concat()
}

/// The [`solids_of`] each of these things, found in one pass over the scene.
pub fn solids_of_each(packed: &PackedScene, entities: &[Entity]) -> Vec<Vec<Solid>> {
    let mut found = vec![Vec::new(); entities.len()];
    let Some(scene) = &packed.scene else {
        return found;
    };
    let geometry = &scene.geometry;
    let places: HashMap<Entity, usize> = entities.iter().copied().zip(0..).collect();
    for (item, entity) in (0..).zip(packed.entity_of_instance.iter()) {
        let item: u32 = item;
        if let Some(&place) = places.get(entity) {
            found[place].extend(match geometry.instances().get(item as usize) {
                Some(instance) => Some(Solid::of(instance)),
                None => geometry.exact_bounds_of(item).map(Solid::of_bounds),
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_reach_as_far_as_their_surface() {
        let turned = Affine3A::from_rotation_z(std::f32::consts::FRAC_PI_4) * Affine3A::from_scale(Vec3::splat(2.0));
        let placed = Affine3A::from_translation(Vec3::Y) * turned;
        let reach = |form, direction| {
            Solid {
                form,
                world_from_local: placed,
            }
            .reach(direction)
        };
        let diagonal = 8f32.sqrt();
        let unit = Aabb {
            min: Vec3::NEG_ONE,
            max: Vec3::ONE,
        };
        for (form, up) in [
            (Form::Sphere, 3.0),
            (Form::Box(unit), 1.0 + diagonal),
            (Form::Square, 1.0 + diagonal),
            (Form::Disk, 3.0),
        ] {
            assert!((reach(form, Vec3::Y) - up).abs() < 1e-5, "{form:?}");
            assert!((reach(form, Vec3::NEG_Y) - (up - 2.0)).abs() < 1e-5, "{form:?}");
        }
        assert!((reach(Form::Cylinder, Vec3::Z) - 2.0).abs() < 1e-5);
        assert!(reach(Form::Cylinder, Vec3::NEG_Z).abs() < 1e-5);
    }
}
