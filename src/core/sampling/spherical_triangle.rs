//! Uniform sampling of the solid angle under which a triangle is seen.
//!
//! Arvo, Stratified Sampling of Spherical Triangles, SIGGRAPH 1995; the solid angle after Van Oosterom and Strackee
//! 1983. Computed in double precision, for the sake of slivers.

use glam::{DVec3, Vec2, Vec3};

/// Below this solid angle (sr) a triangle is sampled by area nearly as well, and faster.
const SMALLEST_SOLID_ANGLE: f64 = 1e-3;

/// Sine of the first corner's angle on the sphere below which the division by it loses too many digits.
const LEAST_SINE: f64 = 1e-6;

/// A triangle as seen from one point, prepared for sampling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphericalTriangle {
    origin: DVec3,
    /// A corner of the triangle and its scaled normal: its plane.
    corner: DVec3,
    normal: DVec3,
    /// Unit vectors to the corners.
    a: DVec3,
    b: DVec3,
    c: DVec3,
    /// The sine of the angle at `a` on the sphere; the cosine follows.
    sin_alpha: f64,
    cos_alpha: f64,
    solid_angle: f64,
}

impl SphericalTriangle {
    /// The triangle with `corners` as seen from `origin`, both in one space, with either side visible.
    ///
    /// `None` if the origin lies in the triangle's plane, or if the triangle looks small or as thin as a line: sample
    /// by area then.
    pub fn new(corners: [Vec3; 3], origin: Vec3) -> Option<Self> {
        let origin = origin.as_dvec3();
        let [p0, p1, p2] = corners.map(Vec3::as_dvec3);
        let [to_a, to_b, to_c] = [p0 - origin, p1 - origin, p2 - origin];
        let normal = (p1 - p0).cross(p2 - p0);
        // It is six times the tetrahedron's volume, and small against the lengths where the triangle looks small.
        let volume = to_a.dot(normal).abs();
        let (a_length, b_length, c_length) = (to_a.length(), to_b.length(), to_c.length());
        let product = a_length * b_length * c_length;
        let below = product + to_a.dot(to_b) * c_length + to_b.dot(to_c) * a_length + to_c.dot(to_a) * b_length;
        let solid_angle = 2.0 * volume.atan2(below);
        if solid_angle.is_nan() || solid_angle <= SMALLEST_SOLID_ANGLE || volume <= 0.0 {
            return None;
        }
        let (a, b, c) = (to_a / a_length, to_b / b_length, to_c / c_length);
        // The sine and cosine of the angle at `a`, up to the same factor.
        let (sin, cos) = (volume / product, b.dot(c) - a.dot(b) * a.dot(c));
        let length = (sin * sin + cos * cos).sqrt();
        let (sin_alpha, cos_alpha) = (sin / length, cos / length);
        (sin_alpha > LEAST_SINE).then_some(Self {
            origin,
            corner: p0,
            normal,
            a,
            b,
            c,
            sin_alpha,
            cos_alpha,
            solid_angle,
        })
    }

    /// Solid angle density of every sampled direction.
    pub fn pdf_solid_angle(&self) -> f32 {
        (1.0 / self.solid_angle) as f32
    }

    /// Samples a point on the triangle whose direction from the origin is uniform in solid angle.
    pub fn sample(&self, u: Vec2) -> Vec3 {
        let (u, v) = (f64::from(u.x), f64::from(u.y));
        // The point c' of the edge from `a` to `c` that cuts off the fraction u of the solid angle beside the edge from
        // `a` to `b`: by its cosine q from `a`.
        let (sin_area, cos_area) = (u * self.solid_angle).sin_cos();
        let sin = sin_area * self.cos_alpha - cos_area * self.sin_alpha;
        let cos = cos_area * self.cos_alpha + sin_area * self.sin_alpha;
        let along = cos - self.cos_alpha;
        let across = sin + self.sin_alpha * self.a.dot(self.b);
        let above = (across * cos - along * sin) * self.cos_alpha - across;
        let below = (across * sin + along * cos) * self.sin_alpha;
        let q = (above / below).clamp(-1.0, 1.0);
        // At u = 0 both vanish: c' is `a` itself.
        let q = if q.is_nan() { 1.0 } else { q };
        let cut = q * self.a + (1.0 - q * q).sqrt() * perpendicular(self.c, self.a);
        // On the arc from `b` to c', equal steps of the cosine from `b` are equal solid angles.
        let z = 1.0 - v * (1.0 - cut.dot(self.b));
        let direction = z * self.b + (1.0 - z * z).max(0.0).sqrt() * perpendicular(cut, self.b);
        let distance = (self.corner - self.origin).dot(self.normal) / direction.dot(self.normal);
        (self.origin + distance * direction).as_vec3()
    }
}

/// The unit vector towards `v` that is perpendicular to the unit vector `axis`; zero if `v` is parallel to it.
fn perpendicular(v: DVec3, axis: DVec3) -> DVec3 {
    (v - v.dot(axis) * axis).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;

    fn random(index: u32) -> Vec2 {
        let [x, y, _] = pcg3d([index, 31, 32]).map(unit_float);
        Vec2::new(x, y)
    }

    #[test]
    fn an_octant_is_an_eighth_of_the_sphere() {
        for scale in [1.0, 1e-10, 1e10] {
            let seen = SphericalTriangle::new([Vec3::X, Vec3::Y, Vec3::Z].map(|p| scale * p), Vec3::ZERO);
            let seen = seen.expect("a large triangle");
            assert!((seen.solid_angle - FRAC_PI_2).abs() < 1e-6, "{}", seen.solid_angle);
        }
    }

    /// The mean direction has a closed form: half the sum over edges of the angle times the unit normal of the edge's
    /// plane (Lambert's formula for the vector irradiance of a polygon).
    #[test]
    fn the_mean_direction_is_that_of_the_polygon() {
        let triangles = [
            [
                Vec3::new(0.3, 0.1, 1.0),
                Vec3::new(-0.8, 0.2, 1.1),
                Vec3::new(0.1, 0.9, 0.7),
            ],
            [
                Vec3::new(3.0, 0.0, 0.05),
                Vec3::new(-3.0, 0.1, 0.05),
                Vec3::new(0.1, 4.0, 0.05),
            ],
            [
                Vec3::new(0.0, 0.0, 1.0),
                Vec3::new(0.02, 0.0, 1.0),
                Vec3::new(0.0, 5.0, 1.0),
            ],
        ];
        for corners in triangles {
            let seen = SphericalTriangle::new(corners, Vec3::ZERO).expect("large enough");
            let edge = |from: Vec3, to: Vec3| {
                let (from, to) = (from.as_dvec3(), to.as_dvec3());
                0.5 * from.angle_between(to) * from.cross(to).normalize()
            };
            let [p0, p1, p2] = corners;
            let irradiance = edge(p0, p1) + edge(p1, p2) + edge(p2, p0);
            let outwards = irradiance.dot(p0.as_dvec3()).signum();
            let expected = outwards * irradiance / seen.solid_angle;
            const DRAWS: u32 = 40_000;
            let sum: DVec3 = (0..DRAWS).map(|i| seen.sample(random(i)).as_dvec3().normalize()).sum();
            let mean = sum / f64::from(DRAWS);
            // The tolerance is five standard errors of coordinates that vary by less than one.
            let tolerance = 5.0 / f64::from(DRAWS).sqrt();
            assert!(
                mean.distance(expected) < tolerance,
                "{corners:?}: {mean} instead of {expected}"
            );
        }
    }

    #[test]
    fn samples_lie_on_the_triangle() {
        for index in 0..2000 {
            let corner = |stream| {
                let [x, y, z] = pcg3d([index, stream, 33]).map(unit_float);
                2.0 * Vec3::new(x, y, z) - Vec3::ONE
            };
            let corners = [corner(1), corner(2), corner(3)];
            let origin = if index % 4 == 0 {
                // The origin almost touches the triangle.
                (corners[0] + corners[1] + corners[2]) / 3.0 + 1e-4 * corner(4)
            } else {
                corner(4)
            };
            let Some(seen) = SphericalTriangle::new(corners, origin) else {
                continue;
            };
            for draw in [
                Vec2::ZERO,
                Vec2::splat(1.0 - f32::EPSILON),
                random(index),
                random(index + 5000),
            ] {
                let point = seen.sample(draw).as_dvec3();
                let [a, b, c] = corners.map(|corner| corner.as_dvec3() - point);
                let normal = (b - a).cross(c - a);
                let area = normal.length();
                let parts = [a.cross(b), b.cross(c), c.cross(a)].map(|part| part.dot(normal) / (area * area));
                // Points that look alike from a grazing origin may be far apart on the triangle.
                let cosine = (seen.a.dot(normal) / area).abs().max(1e-3);
                assert!(
                    parts.iter().all(|&part| part > -1e-3 / cosine),
                    "{parts:?} of {corners:?} from {origin} at {draw}"
                );
            }
        }
    }
}
