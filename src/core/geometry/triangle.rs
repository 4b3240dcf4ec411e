//! One triangle: the ray test and the surface at a hit.
//!
//! The test is Moeller and Trumbore's (JGT 1997): signed volumes of the ray with each edge, and with the plane. The
//! volumes of the edges are computed in a space where the ray is the third axis, as signed areas (Woop, Benthin, Wald,
//! Watertight Ray/Triangle Intersection, JCGT 2013): each corner is transformed independently of its triangle, so the
//! two triangles at a shared edge get exactly opposite numbers and no ray slips between them. The weights are divided
//! by their own sum, not by the determinant, which keeps them in [0, 1] at grazing angles.

use std::ops::{Add, Mul, Sub};

use glam::{Vec2, Vec3};

use super::local::{LocalHit, LocalSurface, Parametrisation};
use crate::math::{Ray, Real, Vector, gamma};

/// The sides of a triangle that can be hit. The front is the side from which its corners turn counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Faces {
    /// Rays hit front and back.
    Both,
    /// Rays hit only the front, and pass through the back.
    FrontOnly,
}

/// The operations that the test needs of a number: f32, or a SIMD vector for several triangles at once.
pub(crate) trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Number for T {}

/// A ray prepared for the test. Axes are permuted so that the largest component of the direction is the third.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TriangleRay {
    /// For each of the permuted axes its original axis.
    pub axes: [usize; 3],
    /// The origin in permuted axes, as are all further fields.
    origin: [f32; 3],
    dir: [f32; 3],
    /// The shear along the first two axes for each unit of the third.
    shear: [f32; 2],
    pub t_min: f32,
}

impl TriangleRay {
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let size = ray.dir.abs();
        let largest = match (size.x > size.y, size.x > size.z, size.y > size.z) {
            (true, true, _) => 0,
            (false, _, true) => 1,
            _ => 2,
        };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][largest];
        let turned = |v: Vec3| axes.map(|axis| v[axis]);
        let dir = turned(ray.dir);
        Self {
            axes,
            origin: turned(ray.origin),
            dir,
            shear: [dir[0] / dir[2], dir[1] / dir[2]],
            t_min: ray.t_min,
        }
    }

    /// Points in permuted axes relative to the origin; `splat` copies a number to all lanes.
    #[inline(always)]
    pub fn relative<T: Number>(&self, corners: [[T; 3]; 3], splat: impl Fn(f32) -> T) -> [[T; 3]; 3] {
        let origin = [splat(self.origin[0]), splat(self.origin[1]), splat(self.origin[2])];
        [
            sub(corners[0], origin),
            sub(corners[1], origin),
            sub(corners[2], origin),
        ]
    }

    /// The barycentric weights of corners 0, 1, 2, times their sum, for corners [relative](Self::relative) to the
    /// origin. The ray's line meets the triangle if none is negative, or none positive.
    #[inline(always)]
    pub fn weights<T: Number>(&self, [a, b, c]: [[T; 3]; 3], splat: impl Fn(f32) -> T) -> [T; 3] {
        let shear = [splat(self.shear[0]), splat(self.shear[1])];
        let sheared = |p: [T; 3]| [p[0] - shear[0] * p[2], p[1] - shear[1] * p[2]];
        let (a, b, c) = (sheared(a), sheared(b), sheared(c));
        [area(b, c), area(c, a), area(a, b)]
    }

    /// The numerator and the denominator of the distance to the plane of corners [relative](Self::relative) to the
    /// origin. The denominator is negative if the ray meets the front.
    #[inline(always)]
    pub fn plane<T: Number>(&self, [a, b, c]: [[T; 3]; 3], splat: impl Fn(f32) -> T) -> [T; 2] {
        let normal = cross(sub(b, a), sub(c, a));
        let dir = [splat(self.dir[0]), splat(self.dir[1]), splat(self.dir[2])];
        [dot(a, normal), dot(dir, normal)]
    }
}

/// Twice the area of the triangle of `p`, `q` and the origin. It is exactly negated when `p` and `q` are swapped.
#[inline(always)]
fn area<T: Number>(p: [T; 2], q: [T; 2]) -> T {
    p[0] * q[1] - p[1] * q[0]
}

#[inline(always)]
fn sub<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn cross<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn dot<T: Number>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The hit of `ray` with the triangle; `None` for a miss, a ray within the plane, or a triangle without area.
pub fn intersect(ray: &Ray, corners: [Vec3; 3], faces: Faces) -> Option<LocalHit> {
    let own = TriangleRay::new(ray);
    let corners = own.relative(corners.map(|p| own.axes.map(|axis| p[axis])), |x| x);
    let [w0, w1, w2] = own.weights(corners, |x| x);
    let [t_numerator, determinant] = own.plane(corners, |x| x);
    let inside = w0.min(w1).min(w2) >= 0.0 || w0.max(w1).max(w2) <= 0.0;
    let t = t_numerator / determinant;
    let turned_away = faces == Faces::FrontOnly && determinant >= 0.0;
    let met = inside && t > ray.t_min && t < ray.t_max && !turned_away;
    let sum = w0 + w1 + w2;
    (met && sum != 0.0).then(|| LocalHit {
        t,
        u: w1 / sum,
        v: w2 / sum,
    })
}

/// Whether a triangle has finite corners and an area that the test can resolve; others can never be hit and need not be
/// stored.
pub(crate) fn is_regular(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    corners.iter().all(|p| p.is_finite()) && normal.is_finite() && normal != Vec3::ZERO
}

/// The surface at the barycentric weights `u`, `v` of corners 1 and 2.
#[inline(always)]
pub fn surface<R: Real>([a, b, c]: [R::Vec3; 3], u: R, v: R) -> LocalSurface<R> {
    let w = R::ONE - u - v;
    let position = a * w + b * u + c * v;
    let (edge_b, edge_c) = (b - a, c - a);
    let normal = edge_b.cross(edge_c);

    // The rounding error of the interpolation, and of the distance to the plane as the ray test evaluates it: (a -
    // origin) . normal, where each component of the normal is a difference of products (large for slivers).
    let size = |v: R::Vec3| v.map(R::abs);
    let interpolation = (size(a) * w.abs() + size(b) * u.abs() + size(c) * v.abs()) * R::splat(gamma(7));
    let (p, q) = (size(edge_b), size(edge_c));
    let products = R::Vec3::of(
        p.y() * q.z() + p.z() * q.y(),
        p.z() * q.x() + p.x() * q.z(),
        p.x() * q.y() + p.y() * q.x(),
    );
    let reach = size(position - a) + interpolation;
    let plane = R::splat(gamma(8)) * reach.dot(products) / normal.length_squared().sqrt();
    let longest = p.max_element().max(q.max_element());
    LocalSurface {
        position,
        error: interpolation + R::Vec3::even(plane.min(R::splat(MAX_PLANE_ERROR) * longest)),
        normal,
    }
}

/// The parametrisation at the barycentric weights `u`, `v` of corners 1 and 2, with `uvs` at the corners; without them
/// uv is (u, v). If they have no area, the derivatives are zero.
pub(crate) fn parametrisation(corners: [Vec3; 3], u: f32, v: f32, uvs: Option<[Vec2; 3]>) -> Parametrisation {
    let (edge_b, edge_c) = (corners[1] - corners[0], corners[2] - corners[0]);
    let Some(uvs) = uvs else {
        return Parametrisation {
            uv: Vec2::new(u, v),
            dp_du: edge_b,
            dp_dv: edge_c,
        };
    };
    let (to_b, to_c) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
    let determinant = to_b.perp_dot(to_c);
    let inverse = if determinant == 0.0 { 0.0 } else { determinant.recip() };
    Parametrisation {
        uv: (1.0 - u - v) * uvs[0] + u * uvs[1] + v * uvs[2],
        dp_du: (to_c.y * edge_b - to_b.y * edge_c) * inverse,
        dp_dv: (to_b.x * edge_c - to_c.x * edge_b) * inverse,
    }
}

/// The largest error of the plane, in units of the longest edge: the computed plane of very thin slivers is mere
/// rounding and must not push rays visibly far away.
const MAX_PLANE_ERROR: f32 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    #[test]
    fn back_faces_are_culled_on_request_only() {
        let front = Ray::new(Vec3::new(0.25, 0.5, 1.0), Vec3::NEG_Z * 0.5);
        let back = Ray::new(Vec3::new(0.25, 0.5, -1.0), Vec3::Z * 0.5);
        let expected = Some(LocalHit {
            t: 2.0,
            u: 0.25,
            v: 0.5,
        });
        assert_eq!(intersect(&front, CORNERS, Faces::Both), expected);
        assert_eq!(intersect(&back, CORNERS, Faces::Both), expected);
        assert_eq!(intersect(&front, CORNERS, Faces::FrontOnly), expected);
        assert_eq!(intersect(&back, CORNERS, Faces::FrontOnly), None);
    }

    #[test]
    fn grazing_rays_hit_within_the_triangle() {
        for exponent in 1..12 {
            let slope = 10f32.powi(-exponent);
            // The ray is aimed at (1/4, 1/4, 0) from far along x.
            let ray = Ray::new(Vec3::new(0.25 - 8.0, 0.25, 8.0 * slope), Vec3::new(1.0, 0.0, -slope));
            let hit = intersect(&ray, CORNERS, Faces::Both).unwrap();
            let position = surface(CORNERS, hit.u, hit.v).position;
            assert!(
                (position - Vec3::new(0.25, 0.25, 0.0)).length() < 1e-5,
                "{slope} {position}"
            );
        }
        let within = Ray::new(Vec3::new(-1.0, 0.25, 0.0), Vec3::X);
        assert_eq!(intersect(&within, CORNERS, Faces::Both), None);
    }

    #[test]
    fn a_shared_edge_gives_opposite_numbers() {
        let [p, q, r, s] = [[0.1, 0.7, -3.3], [1.7, 0.3, 2.1], [0.2, -0.9, 0.4], [2.3, 1.9, -0.7]];
        for dir in [
            Vec3::new(0.2, -0.9, 0.4),
            Vec3::new(-1.2, 0.9, 0.4),
            Vec3::new(0.3, 0.3, 0.3),
        ] {
            let ray = TriangleRay::new(&Ray::new(Vec3::new(0.3, 0.1, 0.7), dir));
            let weights = |corners: [[f32; 3]; 3]| ray.weights(ray.relative(corners, |x| x), |x| x);
            assert_eq!(weights([p, q, r])[2], -weights([q, p, s])[2]);
        }
    }

    #[test]
    fn triangles_without_area_are_not_regular() {
        assert!(is_regular(CORNERS));
        assert!(!is_regular([Vec3::ZERO, Vec3::ONE, Vec3::ONE]));
        assert!(!is_regular([Vec3::ZERO, Vec3::X, Vec3::splat(f32::NAN)]));
    }
}
