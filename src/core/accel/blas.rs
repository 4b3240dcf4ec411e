//! A mesh prepared for rays: its hierarchy, and a copy of its triangles in the order of the leaves.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, Vec3};
use rayon::prelude::*;

use super::affine_mesh::AffineMesh;
use super::build::SplitMethod;
use super::bvh::{Bvh, BvhStats};
use super::hit::{Hit, MeshHit};
use super::memory::{CACHE, Table};
use super::spatial::cut_triangle;
use super::traverse::TraversalStats;
use super::triangle_block::{LANES, TriangleBlock};
use crate::geometry::mesh::MeshData;
use crate::geometry::triangle::{TriangleRay, is_regular};
use crate::math::{Aabb, Ray};

/// The factor by which refitting may at most raise the expected work above that of the built hierarchy.
const MOST_COST_REFITTED: f32 = 1.2;

/// One mesh's acceleration structure, in the mesh's local space.
#[derive(Clone, Debug)]
pub struct Blas {
    mesh: Arc<MeshData>,
    pub(super) bvh: Bvh,
    blocks: Table<TriangleBlock>,
    /// The expected work of a ray when the hierarchy was built, before any refitting.
    cost_when_built: f32,
    /// Rays that begin in this box prefetch triangles and visit other nodes meanwhile. It is the box around all
    /// triangles, or empty if the mesh fits into a cache. Rays from outside are coherent and hit the first triangles
    /// that they meet, so they gain nothing.
    prefetch_within: Aabb,
    /// Whether the vertex normals equal those of the triangles, so that they need not be looked up.
    pub(super) has_flat_normals: bool,
    /// The transform and the faces, if the mesh is the image of a square or a cube.
    pub(super) affine: Option<AffineMesh>,
}

impl Blas {
    /// Leaves out triangles without area, and those with corners that are not finite or do not exist: no ray can hit
    /// them.
    pub fn build(mesh: Arc<MeshData>, method: SplitMethod) -> Self {
        let cut = |index, part: &Aabb, plane| cut_triangle(mesh.corners(index as usize), part, plane);
        let bvh = Bvh::over(
            mesh.triangles.len(),
            |index| triangle_bounds(&mesh, index),
            Some(&cut),
            method,
            LANES,
        );
        let cost_when_built = bvh.stats().sah_cost;
        Self::with_hierarchy(mesh, bvh, cost_when_built)
    }

    /// The same hierarchy around `mesh`, which has the same triangles with moved vertices. None if the triangles
    /// differ, or if a new hierarchy would be much better, as it is where many leaves hold parts of triangles.
    pub fn refit(&self, mesh: Arc<MeshData>) -> Option<Self> {
        let is_regular = |mesh: &MeshData, index| mesh.regular_corners(index).is_some();
        let is_held_as_before = |index| is_regular(&mesh, index) == is_regular(&self.mesh, index);
        let same_triangles = mesh.triangles == self.mesh.triangles;
        if !same_triangles || !(0..mesh.triangles.len()).into_par_iter().all(is_held_as_before) {
            return None;
        }
        let bvh = self.bvh.refit(|index| triangle_bounds(&mesh, index));
        let is_good = bvh.stats().sah_cost <= MOST_COST_REFITTED * self.cost_when_built;
        is_good.then(|| Self::with_hierarchy(mesh, bvh, self.cost_when_built))
    }

    fn with_hierarchy(mesh: Arc<MeshData>, bvh: Bvh, cost_when_built: f32) -> Self {
        let mut blocks = Table::zeroed(bvh.order().len().div_ceil(LANES));
        blocks
            .par_iter_mut()
            .zip(bvh.order().par_chunks(LANES))
            .for_each(|(block, chunk)| {
                *block = TriangleBlock::EMPTY;
                for (lane, &triangle) in chunk.iter().enumerate().filter(|&(_, &triangle)| triangle != u32::MAX) {
                    block.set(lane, mesh.corners(triangle as usize), triangle);
                }
            });
        let mut blas = Self {
            prefetch_within: Aabb::EMPTY,
            has_flat_normals: has_flat_normals(&mesh),
            affine: AffineMesh::of(&mesh),
            mesh,
            bvh,
            blocks,
            cost_when_built,
        };
        if blas.bytes() > CACHE {
            blas.prefetch_within = blas.bounds();
        }
        blas
    }

    /// The mesh that the hierarchy was built over.
    pub fn mesh(&self) -> &Arc<MeshData> {
        &self.mesh
    }

    /// The hierarchy over the mesh's triangles.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The transform from the square [-1, 1]² in the plane z = 0 to the mesh, if the mesh is two triangles that make up
    /// its image.
    pub(crate) fn local_from_square(&self) -> Option<DAffine3> {
        let mesh = self.affine.as_ref().filter(|mesh| mesh.faces.len() == 1)?;
        Some(mesh.placed)
    }

    /// The local bounds of the triangles that can be hit.
    pub fn bounds(&self) -> Aabb {
        self.bvh.bounds()
    }

    /// Statistics of the hierarchy; `bytes` includes the triangles in leaf order, but not the mesh.
    pub fn stats(&self) -> BvhStats {
        let mut stats = self.bvh.stats();
        stats.bytes = self.bytes();
        stats
    }

    /// The memory of the hierarchy and the triangles in leaf order, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.bvh.bytes() + size_of_val(self.blocks())
    }

    /// Checks the structure as [`Bvh::validate`] does, but a triangle may be in several leaves if their boxes cover it
    /// together. That is checked at some of its points.
    pub fn validate(&self) -> Result<(), String> {
        let mut boxes = vec![Vec::new(); self.mesh.triangles.len()];
        self.bvh.validate_structure(|triangle, leaf| {
            let boxes = boxes
                .get_mut(triangle as usize)
                .ok_or_else(|| format!("no triangle {triangle}"))?;
            boxes.push(*leaf);
            Ok(())
        })?;
        for (triangle, boxes) in boxes.iter().enumerate() {
            let Some(corners) = self.mesh.regular_corners(triangle) else {
                if boxes.is_empty() {
                    continue;
                }
                return Err(format!("triangle {triangle} should not be there"));
            };
            let around = Aabb::from_points(corners);
            if boxes.iter().any(|part| part.intersection(around).is_empty()) {
                return Err(format!("triangle {triangle} is in a leaf that has no part of it"));
            }
            if boxes.len() == 1 && boxes[0].contains(&around) {
                continue;
            }
            // Covers the rounding of points between the corners.
            let margin = 4.0 * f32::EPSILON * around.min.abs().max(around.max.abs());
            let is_held = |point: Vec3| {
                let holds =
                    |part: &Aabb| (part.min - margin).cmple(point).all() && point.cmple(part.max + margin).all();
                boxes.iter().any(holds)
            };
            if let Some(point) = points_of(corners).find(|&point| !is_held(point)) {
                return Err(format!("triangle {triangle} is in no leaf at {point}"));
            }
        }
        Ok(())
    }

    /// The nearest hit with t_min < t < t_max; `ray` is in local space.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<MeshHit> {
        self.closest::<false>(ray, &mut TraversalStats::default())
    }

    /// [`Blas::intersect`], adding its work to `stats`.
    pub fn intersect_counting(&self, ray: &Ray, stats: &mut TraversalStats) -> Option<MeshHit> {
        self.closest::<true>(ray, stats)
    }

    #[inline(always)]
    pub(super) fn closest<const COUNT: bool>(&self, ray: &Ray, stats: &mut TraversalStats) -> Option<MeshHit> {
        if self.prefetch_within.contains_point(ray.origin) {
            return self.closest_prefetching::<COUNT>(ray, stats);
        }
        let mut nearest = Nearest::new(self.blocks(), ray);
        self.bvh
            .closest::<COUNT>(ray, stats, |leaf, t_max| nearest.visit(leaf, t_max));
        nearest.hit
    }

    #[inline(never)]
    fn closest_prefetching<const COUNT: bool>(&self, ray: &Ray, stats: &mut TraversalStats) -> Option<MeshHit> {
        let mut nearest = Nearest::new(self.blocks(), ray);
        let visit = |leaf, t_max: &mut f32| nearest.visit(leaf, t_max);
        self.bvh
            .closest_prefetching::<COUNT>(ray, stats, visit, |leaf| self.prefetch(leaf));
        nearest.hit
    }

    /// Whether the ray hits any triangle with t_min < t < t_max.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        if self.prefetch_within.contains_point(ray.origin) {
            return self.occluded_prefetching(ray);
        }
        let lanes = TriangleRay::new(ray);
        self.bvh.any(ray, |leaf| self.any_in(leaf, &lanes, ray.t_max))
    }

    #[inline(never)]
    fn occluded_prefetching(&self, ray: &Ray) -> bool {
        let lanes = TriangleRay::new(ray);
        let visit = |leaf| self.any_in(leaf, &lanes, ray.t_max);
        self.bvh.any_prefetching(ray, visit, |leaf| self.prefetch(leaf))
    }

    #[inline(always)]
    fn any_in(&self, leaf: Range<usize>, ray: &TriangleRay, t_max: f32) -> bool {
        let blocks = &self.blocks()[Self::blocks_of(leaf)];
        blocks.iter().any(|block| block.any(ray, t_max))
    }

    #[inline(always)]
    fn prefetch(&self, leaf: &Range<usize>) {
        if let Some(block) = self.blocks().get(leaf.start / LANES) {
            block.prefetch();
        }
    }

    /// The corners of the triangle that was hit, from its block: it is in a cache, because the ray has just been tested
    /// against it.
    #[inline(always)]
    pub(super) fn corners(&self, hit: &Hit) -> [Vec3; 3] {
        match self.blocks.get(hit.slot as usize / LANES) {
            Some(block) => block.corners(hit.slot as usize % LANES),
            None => self.mesh.corners(hit.primitive as usize),
        }
    }

    /// The triangles in the order of the leaves.
    #[inline(always)]
    pub(super) fn blocks(&self) -> &[TriangleBlock] {
        &self.blocks
    }

    /// The blocks of the leaf whose triangles are in `range` of the leaf order.
    #[inline(always)]
    pub(super) fn blocks_of(range: Range<usize>) -> Range<usize> {
        range.start / LANES..range.end.div_ceil(LANES)
    }
}

/// The nearest hit so far of a single ray.
struct Nearest<'a> {
    blocks: &'a [TriangleBlock],
    ray: TriangleRay,
    hit: Option<MeshHit>,
}

impl<'a> Nearest<'a> {
    #[inline(always)]
    fn new(blocks: &'a [TriangleBlock], ray: &Ray) -> Self {
        Self {
            blocks,
            ray: TriangleRay::new(ray),
            hit: None,
        }
    }

    #[inline(always)]
    fn visit(&mut self, leaf: Range<usize>, t_max: &mut f32) {
        for number in Blas::blocks_of(leaf) {
            let nearest = self.hit.map(|hit| hit.slot);
            if let Some(found) = self.blocks[number].closest(number, &self.ray, *t_max, nearest) {
                *t_max = found.t;
                self.hit = Some(found);
            }
        }
    }
}

fn has_flat_normals(mesh: &MeshData) -> bool {
    let is_flat = |triangle: &[u32; 3]| {
        let corner = |k: usize| mesh.positions.get(triangle[k] as usize).copied();
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
            return false;
        };
        let normal = (b - a).cross(c - a).try_normalize();
        // The tolerance covers a few roundings of numbers below 1.
        let is_like = |vertex: &u32| match (mesh.normals.get(*vertex as usize), normal) {
            (Some(own), Some(normal)) => own.abs_diff_eq(normal, 4.0 * f32::EPSILON),
            _ => false,
        };
        !is_regular([a, b, c]) || triangle.iter().all(is_like)
    };
    // The first triangle decides for most meshes.
    mesh.triangles.first().is_some_and(is_flat) && mesh.triangles.par_iter().all(is_flat)
}

/// The corners of a triangle, and points between them.
fn points_of([a, b, c]: [Vec3; 3]) -> impl Iterator<Item = Vec3> {
    const STEPS: u32 = 16;
    let weights = (0..=STEPS).flat_map(|u| (0..=STEPS - u).map(move |v| [u, v]));
    weights.map(move |weights| {
        let [u, v] = weights.map(|weight| weight as f32 / STEPS as f32);
        a * (1.0 - u - v) + b * u + c * v
    })
}

/// The box of a triangle, empty for one that is left out.
fn triangle_bounds(mesh: &MeshData, index: usize) -> Aabb {
    mesh.regular_corners(index).map_or(Aabb::EMPTY, Aabb::from_points)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::RayLanes;
    use crate::geometry::primitives::{unit_cube, unit_triangle};

    /// The signed areas all round to zero here, but the distance does not.
    #[test]
    fn a_triangle_seen_from_its_edge_is_not_met() {
        let dir = Vec3::new(1.0, 0.1, 0.0);
        let corner = |x: f32, z: f32| Vec3::new(x, dir.y * x, z);
        let mesh = MeshData {
            positions: vec![corner(5.0, 4.0), corner(3.0, -1.0), corner(4.0, 2.0)],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        };
        let mesh = Blas::build(Arc::new(mesh), SplitMethod::Sah);
        let ray = Ray::new(Vec3::ZERO, dir);
        assert_eq!(mesh.intersect(&ray), None);
        assert!(!mesh.occluded(&ray));
        let mut lanes = RayLanes::NOWHERE;
        lanes.set(3, &ray);
        mesh.intersect_lanes(&lanes, 0xffff, |lane, hit| panic!("{lane}: {hit:?}"));
        assert_eq!(mesh.occluded_packet(&lanes, 0xffff), 0);
    }

    /// The ray's direction is infinite in the mesh's space.
    #[test]
    fn what_is_no_ray_in_its_space_meets_nothing() {
        let mesh = Blas::build(Arc::new(unit_cube()), SplitMethod::Sah);
        let mut lanes = RayLanes::NOWHERE;
        (0..16).for_each(|lane| lanes.set(lane, &Ray::new(Vec3::ZERO, Vec3::INFINITY)));
        mesh.intersect_packet(&lanes, 0xffff, |lane, hit| panic!("{lane}: {hit:?}"));
        mesh.intersect_lanes(&lanes, 0xffff, |lane, hit| panic!("{lane}: {hit:?}"));
        assert_eq!(
            mesh.occluded_packet(&lanes, 0xffff) | mesh.occluded_lanes(&lanes, 0xffff),
            0
        );
    }

    #[test]
    fn normals_across_all_triangles_are_flat() {
        assert!(has_flat_normals(&unit_cube()));
        assert!(!has_flat_normals(&unit_triangle()), "it has none");
        let mut turned = unit_cube();
        turned.normals[23] = (turned.normals[23] + 1e-3 * Vec3::ONE).normalize();
        assert!(!has_flat_normals(&turned));
        let mut inward = unit_cube();
        inward.normals.iter_mut().for_each(|normal| *normal = -*normal);
        assert!(!has_flat_normals(&inward));
        let mut torn = unit_cube();
        torn.triangles[11][2] = 1000;
        assert!(!has_flat_normals(&torn));
    }
}
