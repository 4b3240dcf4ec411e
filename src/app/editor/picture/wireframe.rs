//! The selection drawn as lines: the edges of its triangles, or a net over shapes without triangles.

use std::collections::HashSet;
use std::f32::consts::TAU;
use std::sync::Arc;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;

use crate::accel::{Instance, Primitive, Tlas};
use crate::app::editor::command::selection::Selection;
use crate::engine::PackedScene;
use crate::geometry::mesh::MeshData;

/// The most triangles whose edges are drawn. Of larger meshes only some are drawn, spread evenly.
const MOST_TRIANGLES: usize = 6000;
/// The most lines of all shapes together.
const MOST_LINES: usize = 24_000;
/// The number of segments of a circle.
const PIECES: usize = 32;

/// The last lines.
#[derive(Debug, Default)]
pub struct Wireframe {
    of: Option<(Selection, Arc<Tlas>)>,
    /// The ends of each line in the world.
    pub lines: Vec<[Vec3; 2]>,
    /// The triangles of the selection, and the number of drawn ones.
    pub triangles: [usize; 2],
}

impl Wireframe {
    /// Updates the lines; without `shown` there are none.
    pub fn update(&mut self, packed: &PackedScene, selection: &Selection, shown: bool) {
        let Some(scene) = packed.scene.as_ref().filter(|_| shown && !selection.is_empty()) else {
            if self.of.is_some() {
                *self = Self::default();
            }
            return;
        };
        let is_same =
            |(of, geometry): &(Selection, Arc<Tlas>)| of == selection && Arc::ptr_eq(geometry, &scene.geometry);
        if self.of.as_ref().is_some_and(is_same) {
            return;
        }
        *self = Self {
            of: Some((selection.clone(), scene.geometry.clone())),
            ..Self::default()
        };
        let shapes = shapes(&scene.geometry, &packed.entity_of_instance, selection);
        let triangles = |shape: &Instance| match &shape.primitive {
            Primitive::Mesh(mesh) => mesh.mesh().triangles.len(),
            _ => 0,
        };
        let total: usize = shapes.iter().map(|(shape, _)| triangles(shape)).sum();
        let step = total.div_ceil(MOST_TRIANGLES).max(1);
        for (shape, outer) in shapes {
            let pose = outer * shape.world_from_local;
            let local = match &shape.primitive {
                Primitive::Mesh(mesh) => {
                    self.triangles[1] += mesh.mesh().triangles.len().div_ceil(step);
                    edges(mesh.mesh(), step)
                }
                other => net(other),
            };
            let room = MOST_LINES.saturating_sub(self.lines.len());
            let placed = local.into_iter().map(|ends| ends.map(|end| pose.transform_point3(end)));
            self.lines.extend(placed.take(room));
        }
        self.triangles[0] = total;
    }
}

/// The shapes of the selection, each with the transform from its group's space to the world.
fn shapes<'a>(
    geometry: &'a Tlas,
    entity_of_instance: &[Entity],
    selection: &Selection,
) -> Vec<(&'a Instance, Affine3A)> {
    let own = geometry.instances().len();
    let mut found = Vec::new();
    for (item, _) in (0..)
        .zip(entity_of_instance)
        .filter(|(_, entity)| selection.contains(**entity))
    {
        if let Some(shape) = geometry.instances().get(item) {
            found.push((shape, Affine3A::IDENTITY));
        } else if let Some(placement) = geometry.placements().get(item - own) {
            let pose = placement.world_from_group();
            let members = geometry.groups().get(placement.group as usize);
            found.extend(
                members
                    .iter()
                    .flat_map(|group| group.instances().iter())
                    .map(|shape| (shape, pose)),
            );
        }
        if found.len() >= MOST_LINES {
            break;
        }
    }
    found
}

/// The edges of every `step`th triangle, each once.
fn edges(mesh: &MeshData, step: usize) -> Vec<[Vec3; 2]> {
    let mut known = HashSet::new();
    let mut lines = Vec::new();
    for triangle in mesh.triangles.iter().step_by(step) {
        for side in 0..3 {
            let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
            if known.insert((a.min(b), a.max(b)))
                && let (Some(from), Some(to)) = (mesh.positions.get(a as usize), mesh.positions.get(b as usize))
            {
                lines.push([*from, *to]);
            }
        }
    }
    lines
}

/// A net of lines over a shape in its own space.
fn net(primitive: &Primitive) -> Vec<[Vec3; 2]> {
    let circle = |radius: f32, z: f32| {
        let at = move |piece: usize| {
            let (sin, cos) = (TAU * piece as f32 / PIECES as f32).sin_cos();
            Vec3::new(radius * cos, radius * sin, z)
        };
        (0..PIECES).map(move |piece| [at(piece), at(piece + 1)])
    };
    let around = |pieces: usize| (0..pieces).map(move |piece| TAU * piece as f32 / pieces as f32);
    match primitive {
        // The triangles of a mesh have edges of their own.
        Primitive::Mesh(_) => Vec::new(),
        Primitive::Curves(curves) => curves.center_lines(MOST_LINES),
        Primitive::Sphere => {
            let parallels = [-60.0_f32, -30.0, 0.0, 30.0, 60.0].map(f32::to_radians);
            let parallels = parallels.into_iter().flat_map(|up| circle(up.cos(), up.sin()));
            let meridians = around(6).flat_map(|turn| {
                let turned = Affine3A::from_rotation_z(0.5 * turn) * Affine3A::from_rotation_x(TAU / 4.0);
                circle(1.0, 0.0).map(move |ends| ends.map(|end| turned.transform_point3(end)))
            });
            parallels.chain(meridians).collect()
        }
        Primitive::Rectangle => {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
            (0..4).map(|side| [corners[side], corners[(side + 1) % 4]]).collect()
        }
        Primitive::Disk => {
            let spokes = around(8).map(|turn| [Vec3::ZERO, Vec3::new(turn.cos(), turn.sin(), 0.0)]);
            circle(1.0, 0.0).chain(circle(0.5, 0.0)).chain(spokes).collect()
        }
        Primitive::Cylinder => {
            let sides = around(8).map(|turn| [0.0, 1.0].map(|z| Vec3::new(turn.cos(), turn.sin(), z)));
            circle(1.0, 0.0).chain(circle(1.0, 1.0)).chain(sides).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::camera::picking::tests::spheres;

    #[test]
    fn a_sphere_has_a_net_on_its_surface() {
        let (packed, entities) = spheres(&[Vec3::ZERO, 5.0 * Vec3::X]);
        let mut wireframe = Wireframe::default();
        let selection = Selection::of([entities[1]]);
        wireframe.update(&packed, &selection, true);
        assert!(wireframe.lines.len() > 100);
        let off = |end: &Vec3| ((*end - 5.0 * Vec3::X).length() - 1.0).abs();
        assert!(wireframe.lines.iter().flatten().all(|end| off(end) < 1e-4));
        wireframe.update(&packed, &Selection::default(), true);
        assert!(wireframe.lines.is_empty());
        wireframe.update(&packed, &selection, false);
        assert!(wireframe.lines.is_empty());
    }

    #[test]
    fn edges_are_drawn_once_and_large_meshes_in_part() {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE];
        let mesh = MeshData {
            positions,
            triangles: vec![[0, 1, 2], [2, 1, 3], [0, 3, 9]],
            ..MeshData::default()
        };
        // Two triangles share an edge; the third one refers to a vertex that does not exist.
        assert_eq!(edges(&mesh, 1).len(), 6);
        assert_eq!(edges(&mesh, 3).len(), 3);
        for primitive in [Primitive::Rectangle, Primitive::Disk, Primitive::Cylinder] {
            assert!(net(&primitive).len() >= 4);
        }
    }
}
