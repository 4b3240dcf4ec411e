//! One triangle: the ray test and the surface at a hit.
//!
//! The test is Moeller and Trumbore's (JGT 1997): signed volumes of the ray with each edge, and with the plane. Each edge's volume is
//! evaluated from the sum and the difference of its two corners relative to the ray's origin, so the two triangles at a shared edge get
//! exactly opposite numbers and no ray slips between them (the form Embree's robust mode uses; Davidovic et al., Efficient and
//! robust edge functions, 2012). The weights are divided by their own sum, not by the determinant, which keeps them in [0, 1] at grazing angles.

use glam::{Vec2, Vec3};

use super::local::{LocalHit, LocalSurface};
use crate::math::{Ray, gamma};

/// Which sides of a triangle can be hit. The front is the side from which its corners turn counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Faces {
    Both,
    FrontOnly,
}

/// Six times the signed volumes of a ray with a triangle's parts; `weights` belong to corners 0, 1, 2 and are twice that.
#[derive(Clone, Copy)]
pub(crate) struct Volumes {
    pub weights: [f32; 3],
    /// Ray parameter of the plane, as a fraction.
    pub t_numerator: f32,
    /// Negative when the ray meets the front.
    pub determinant: f32,
}

/// Plain arithmetic on scalars, without branches, so that a loop over lanes becomes vector code.
#[inline(always)]
pub(crate) fn volumes(origin: [f32; 3], dir: [f32; 3], corners: [[f32; 3]; 3]) -> Volumes {
    let [a, b, c] = corners.map(|p| sub(p, origin));
    let normal = cross(sub(b, a), sub(c, a));
    Volumes {
        weights: [edge(b, c, dir), edge(c, a, dir), edge(a, b, dir)],
        t_numerator: dot(a, normal),
        determinant: dot(dir, normal),
    }
}

impl Volumes {
    /// Whether the line of the ray passes through the triangle, edges included.
    #[inline(always)]
    pub fn inside(&self) -> bool {
        let [u, v, w] = self.weights;
        (u >= 0.0) & (v >= 0.0) & (w >= 0.0) | (u <= 0.0) & (v <= 0.0) & (w <= 0.0)
    }

    #[inline(always)]
    pub fn t(&self) -> f32 {
        self.t_numerator / self.determinant
    }

    /// Barycentric weights of corners 1 and 2.
    #[inline(always)]
    pub fn uv(&self) -> (f32, f32) {
        let [w0, w1, w2] = self.weights;
        let sum = w0 + w1 + w2;
        (w1 / sum, w2 / sum)
    }
}

#[inline(always)]
fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// 2 dir . (p x q), exactly negated when p and q change places.
#[inline(always)]
fn edge(p: [f32; 3], q: [f32; 3], dir: [f32; 3]) -> f32 {
    let sum = [p[0] + q[0], p[1] + q[1], p[2] + q[2]];
    dot(cross(sub(p, q), sum), dir)
}

/// The hit of `ray` with the triangle, `None` for a miss, a ray within the plane, a triangle without area.
pub fn intersect(ray: &Ray, corners: [Vec3; 3], faces: Faces) -> Option<LocalHit> {
    let volumes = volumes(ray.origin.to_array(), ray.dir.to_array(), corners.map(|p| p.to_array()));
    let t = volumes.t();
    if !volumes.inside() || !(t > 0.0 && t < ray.t_max) || (faces == Faces::FrontOnly && volumes.determinant >= 0.0) {
        return None;
    }
    let (u, v) = volumes.uv();
    (u.is_finite() && v.is_finite()).then_some(LocalHit { t, u, v })
}

/// Whether a triangle has finite corners and an area that the test can see; others can never be hit and need not be stored.
pub fn is_regular(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    corners.iter().all(|p| p.is_finite()) && normal.is_finite() && normal != Vec3::ZERO
}

/// The surface at the weights `u`, `v` of corners 1 and 2; `uv` is (u, v), as for a mesh without texture coordinates.
pub fn surface(corners: [Vec3; 3], u: f32, v: f32) -> LocalSurface {
    let [a, b, c] = corners;
    let w = 1.0 - u - v;
    let position = w * a + u * b + v * c;
    let (edge_b, edge_c) = (b - a, c - a);
    let normal = edge_b.cross(edge_c);

    // Rounding of the interpolation, and of the distance to the plane as the ray test evaluates it: (a - origin) . normal, where each
    // component of the normal is a difference of products (large for slivers).
    let interpolation = gamma(7) * (w.abs() * a.abs() + u.abs() * b.abs() + v.abs() * c.abs());
    let (p, q) = (edge_b.abs(), edge_c.abs());
    let products = Vec3::new(p.y * q.z + p.z * q.y, p.z * q.x + p.x * q.z, p.x * q.y + p.y * q.x);
    let reach = (position - a).abs() + interpolation;
    let plane = gamma(8) * reach.dot(products) / normal.length();
    let longest = p.max(q).max_element();
    LocalSurface {
        position,
        error: interpolation + Vec3::splat(plane.min(MAX_PLANE_ERROR * longest)),
        normal,
        uv: Vec2::new(u, v),
    }
}

/// Slivers so thin that their computed plane is mere rounding must not push rays visibly far away; in units of the longest edge.
const MAX_PLANE_ERROR: f32 = 1e-3;
