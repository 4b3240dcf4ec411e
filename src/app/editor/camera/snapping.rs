//! Finds the corners, edges and surfaces near the pointer for snapping.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{Pos2, Vec2};

use super::picking::{self, SeenSurface};
use super::screen::Screen;
use crate::accel::{Hit, Primitive, Tlas};
use crate::app::editor::command::snapping::SnapTo;
use crate::engine::PackedScene;
use crate::geometry::mesh::MeshData;
use crate::math::Ray;

/// A point to snap to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnapPoint {
    /// The position in world space.
    pub place: Vec3,
    /// Its kind, for its mark.
    pub of: SnapTo,
    /// The normal of a surface, towards the viewer; zero for other kinds.
    pub normal: Vec3,
}

/// The distance from the pointer within which corners and edges are found, in points.
const REACH: f32 = 14.0;
/// The number of triangles up to which edges inside of flat faces are found and skipped; in larger meshes they count as
/// edges, too.
const LARGEST_SEARCHED: usize = 20_000;

/// The nearest snapping point of this kind around the pointer, on entities that `is_passed` does not accept.
pub fn find(
    packed: &PackedScene,
    screen: &Screen,
    pointer: Pos2,
    to: SnapTo,
    is_passed: impl Fn(Entity) -> bool,
) -> Option<SnapPoint> {
    if to == SnapTo::Faces {
        let SeenSurface { position, normal, .. } = picking::seen_surface(packed, &screen.ray(pointer), is_passed)?;
        return Some(SnapPoint {
            place: position,
            of: to,
            normal,
        });
    }
    let geometry = &packed.scene.as_ref()?.geometry;
    let ray = screen.ray(pointer);
    // Corners and edges of a silhouette lie beside the surface under the pointer.
    let around = (0..8).map(|eighth| Vec2::angled(std::f32::consts::FRAC_PI_4 * eighth as f32) * (0.7 * REACH));
    let seen = std::iter::once(Vec2::ZERO)
        .chain(around)
        .filter_map(|off| picking::first_hit(packed, &screen.ray(pointer + off), &is_passed));
    let places = seen.flat_map(|(_, hit, _)| {
        let face = Face::of(geometry, &hit);
        match to {
            SnapTo::Vertices => face.corners,
            _ => face.edges().map(|ends| nearest_on(ends, &ray)).collect(),
        }
    });
    let distance = |place: Vec3| screen.project(place).map(|at| (at.distance(pointer), place));
    let near = places.filter_map(distance).filter(|(distance, _)| *distance <= REACH);
    let (_, place) = near.min_by(|(one, _), (other, _)| one.total_cmp(other))?;
    Some(SnapPoint {
        place,
        of: to,
        normal: Vec3::ZERO,
    })
}

/// A flat face in the world.
#[derive(Default)]
struct Face {
    corners: Vec<Vec3>,
    /// Whether the edge from each corner to the next is a visible one.
    is_edge: Vec<bool>,
}

impl Face {
    /// The face of a hit; without corners for a round shape.
    fn of(geometry: &Tlas, hit: &Hit) -> Self {
        let shape = geometry.shape_at(hit);
        let placement = (hit.instance as usize).checked_sub(geometry.instances().len());
        let group = placement.and_then(|place| geometry.placements().get(place));
        let world = group.map_or(Affine3A::IDENTITY, |group| group.world_from_group()) * shape.world_from_local;
        let local = match &shape.primitive {
            Primitive::Mesh(blas) => Self::of_mesh(blas.mesh(), hit.primitive as usize),
            Primitive::Rectangle => Self {
                corners: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                    .map(|(x, y)| Vec3::new(x, y, 0.0))
                    .to_vec(),
                is_edge: vec![true; 4],
            },
            Primitive::Sphere | Primitive::Disk | Primitive::Cylinder | Primitive::Curves(_) => Self::default(),
        };
        Self {
            corners: local
                .corners
                .iter()
                .map(|corner| world.transform_point3(*corner))
                .collect(),
            ..local
        }
    }

    fn of_mesh(mesh: &MeshData, triangle: usize) -> Self {
        if triangle >= mesh.triangles.len() {
            return Self::default();
        }
        let corners = mesh.corners(triangle);
        let is_edge = |k: usize| mesh.triangles.len() > LARGEST_SEARCHED || !is_within_plane(mesh, triangle, k);
        Self {
            corners: corners.to_vec(),
            is_edge: (0..3).map(is_edge).collect(),
        }
    }

    fn edges(&self) -> impl Iterator<Item = [Vec3; 2]> {
        let next = self.corners.iter().cycle().skip(1);
        let edges = self.corners.iter().zip(next).zip(&self.is_edge);
        edges.filter(|(_, is_edge)| **is_edge).map(|((a, b), _)| [*a, *b])
    }
}

/// Whether the edge from corner `k` of a triangle to the next is shared with a coplanar triangle.
fn is_within_plane(mesh: &MeshData, triangle: usize, k: usize) -> bool {
    let own = mesh.corners(triangle);
    let (a, b) = (own[k], own[(k + 1) % 3]);
    let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).normalize_or_zero();
    let plane = normal(own);
    (0..mesh.triangles.len())
        .filter(|other| *other != triangle)
        .any(|other| {
            let corners = mesh.corners(other);
            corners.contains(&a) && corners.contains(&b) && normal(corners).dot(plane) > 1.0 - 1e-5
        })
}

/// The point of a segment nearest to a ray.
pub(crate) fn nearest_on([a, b]: [Vec3; 2], ray: &Ray) -> Vec3 {
    let (along, dir, from) = (b - a, ray.dir, a - ray.origin);
    let (aa, ad, dd) = (along.dot(along), along.dot(dir), dir.dot(dir));
    let denominator = aa * dd - ad * ad;
    let t = (ad * dir.dot(from) - dd * along.dot(from)) / denominator;
    a + along * if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy::prelude::World;

    use super::*;
    use crate::accel::{Blas, SplitMethod};
    use crate::app::editor::camera::picking::tests::scene_of;
    use crate::app::editor::camera::screen::tests::perspective;
    use crate::geometry::primitives::unit_cube;

    /// A cube of two units at the origin, seen along z.
    fn cube() -> PackedScene {
        let blas = Blas::build(Arc::new(unit_cube()), SplitMethod::Sah);
        let shape = (Primitive::Mesh(Arc::new(blas)), Affine3A::IDENTITY);
        let entity = World::new().spawn_empty().id();
        PackedScene {
            scene: Some(scene_of([shape].into_iter())),
            entity_of_instance: [entity].into(),
            ..PackedScene::default()
        }
    }

    fn found(at: Vec3, off: Vec2, to: SnapTo) -> Option<Vec3> {
        let screen = perspective();
        let pointer = screen.project(at).expect("in sight") + off;
        find(&cube(), &screen, pointer, to, |_| false).map(|point| point.place)
    }

    #[test]
    fn corners_and_edges_are_found_on_both_sides_of_an_outline() {
        let corner = Vec3::new(1.0, 1.0, -1.0);
        for off in [Vec2::new(4.0, -3.0), Vec2::new(-4.0, 3.0)] {
            assert_eq!(found(corner, off, SnapTo::Vertices), Some(corner));
            let edge = found(Vec3::new(1.0, 0.2, -1.0), off, SnapTo::Edges).expect("an edge");
            assert!((edge.x - 1.0).abs() < 1e-5 && edge.y.abs() < 0.5, "{edge}");
        }
        // The diagonal of the front is no edge, and its middle no corner.
        assert_eq!(found(Vec3::NEG_Z, Vec2::ZERO, SnapTo::Edges), None);
        assert_eq!(found(Vec3::NEG_Z, Vec2::ZERO, SnapTo::Vertices), None);
        let face = found(Vec3::new(0.3, 0.3, -1.0), Vec2::ZERO, SnapTo::Faces).expect("the front");
        assert!((face.z + 1.0).abs() < 1e-4);
    }

    #[test]
    fn what_is_dragged_is_left_out() {
        let screen = perspective();
        let pointer = screen.project(Vec3::NEG_Z).expect("in sight");
        assert_eq!(find(&cube(), &screen, pointer, SnapTo::Faces, |_| true), None);
    }
}
