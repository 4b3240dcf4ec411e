//! Meshes of a few triangles, against sixteen rays at once.
//!
//! The test is watertight: it takes signed volumes of the ray with each edge from the sum and the difference of the
//! edge's corners (Davidovic et al., Efficient and robust edge functions, 2012). A volume is computed once for the
//! triangles that share the edge, so that no ray passes between them. Only a ray within rounding of a corner may.

use arrayvec::ArrayVec;
use glam::Vec3;

use super::ray_lanes::RayLanes;
use crate::geometry::mesh::MeshData;
use crate::math::Aabb;
use crate::math::Vector;
use crate::math::lanes::{Lanes, Vec3Lanes};

const MOST_TRIANGLES: usize = 16;
const MOST_CORNERS: usize = 16;
const MOST_EDGES: usize = 32;

/// A mesh whose corners at the same position are merged.
#[derive(Clone, Debug)]
pub(super) struct TinyMesh {
    bounds: Aabb,
    corners: Vec<Vec3>,
    /// Each edge runs from its first corner to its second.
    edges: Vec<[usize; 2]>,
    triangles: Vec<TinyTriangle>,
}

#[derive(Clone, Debug)]
struct TinyTriangle {
    /// Index into the mesh's triangles.
    index: u32,
    /// The edges opposite its corners, each with 1, or with -1 if the triangle runs along it backwards.
    edges: [(usize, f32); 3],
    corner: usize,
    /// The normal, not of unit length.
    normal: Vec3,
}

/// The barycentric weights of the points at which lines meet a triangle's plane.
pub(super) struct WeightLanes {
    /// Weights of corners 1 and 2, times `sum`.
    pub u: Lanes,
    pub v: Lanes,
    pub sum: Lanes,
    /// The lanes whose line passes through the triangle.
    pub inside: Lanes,
}

impl TinyMesh {
    /// None if the mesh is too large, or if no ray can hit it.
    pub fn new(mesh: &MeshData) -> Option<Self> {
        if mesh.triangles.len() > MOST_TRIANGLES {
            return None;
        }
        let mut tiny = Self {
            bounds: Aabb::EMPTY,
            corners: Vec::new(),
            edges: Vec::new(),
            triangles: Vec::new(),
        };
        for index in 0..mesh.triangles.len() {
            let Some(points) = mesh.regular_corners(index) else {
                continue;
            };
            let [a, b, c] = points.map(|point| tiny.corner(point));
            let edges = [(b, c), (c, a), (a, b)].map(|(from, to)| tiny.edge(from, to));
            tiny.triangles.push(TinyTriangle {
                index: index as u32,
                edges,
                corner: a,
                normal: (points[1] - points[0]).cross(points[2] - points[0]),
            });
        }
        let fits = tiny.corners.len() <= MOST_CORNERS && tiny.edges.len() <= MOST_EDGES && !tiny.triangles.is_empty();
        tiny.bounds = Aabb::from_points(tiny.corners.iter().copied());
        fits.then_some(tiny)
    }

    fn corner(&mut self, point: Vec3) -> usize {
        let known = self.corners.iter().position(|&corner| corner == point);
        known.unwrap_or_else(|| {
            self.corners.push(point);
            self.corners.len() - 1
        })
    }

    fn edge(&mut self, from: usize, to: usize) -> (usize, f32) {
        if let Some(known) = self.edges.iter().position(|&edge| edge == [from, to]) {
            return (known, 1.0);
        }
        if let Some(known) = self.edges.iter().position(|&edge| edge == [to, from]) {
            return (known, -1.0);
        }
        self.edges.push([from, to]);
        (self.edges.len() - 1, 1.0)
    }

    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// The index in the mesh of the `number`-th triangle.
    pub fn triangle(&self, number: usize) -> u32 {
        self.triangles[number].index
    }

    /// Calls `visit` for each triangle with the parameters at which the local `rays` meet its plane, until it returns
    /// true.
    #[inline(always)]
    pub fn each_hit(&self, rays: &RayLanes, mut visit: impl FnMut(Lanes, WeightLanes, usize) -> bool) {
        // The corners relative to the origins, and their cross products with the directions. The list is large, so it
        // is filled in place.
        let mut corners = ArrayVec::<[Vec3Lanes; 2], MOST_CORNERS>::new();
        for &corner in &self.corners {
            let (p, d) = (Vec3Lanes::splat(corner) - rays.origin, rays.dir);
            corners.push([p, p.cross(d)]);
        }
        // 2 dir . (p x q) = (p - q) . ((p + q) x dir): with the difference first, the error scales with the edge's
        // length, not with its distance.
        let mut volumes = ArrayVec::<Lanes, MOST_EDGES>::new();
        for &[from, to] in &self.edges {
            let edge = Vec3Lanes::splat(self.corners[from] - self.corners[to]);
            volumes.push(edge.dot(corners[from][1] + corners[to][1]));
        }
        for (number, triangle) in self.triangles.iter().enumerate() {
            let volume = |(edge, sign): (usize, f32)| volumes[edge] * Lanes::splat(sign);
            let (w, u, v) = (
                volume(triangle.edges[0]),
                volume(triangle.edges[1]),
                volume(triangle.edges[2]),
            );
            let zero = Lanes::ZERO;
            let lowest = w.fast_min(u).fast_min(v);
            let highest = w.fast_max(u).fast_max(v);
            let inside = lowest.simd_ge(zero) | highest.simd_le(zero);
            if inside.none() {
                continue;
            }
            let sum = w + u + v;
            let normal = Vec3Lanes::splat(triangle.normal);
            let t = corners[triangle.corner][0].dot(normal) / rays.dir.dot(normal);
            // A triangle seen edge-on may have weights that sum to zero.
            let inside = inside & sum.simd_ne(zero);
            if visit(t, WeightLanes { u, v, sum, inside }, number) {
                return;
            }
        }
    }
}
