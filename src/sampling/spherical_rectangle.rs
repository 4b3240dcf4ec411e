//! Uniform sampling of the solid angle under which a rectangle is seen.
//!
//! Ureña, Fajardo and King, An Area-Preserving Parametrization for Spherical Rectangles, EGSR 2013. In double precision inside, for the
//! sake of small and distant rectangles. Only for rectangles; a parallelogram that is none is sampled by area.

use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::PI;

/// Cosine of the edges' angle up to which a parallelogram counts as a rectangle: the rounding of an `f32` transform, no more.
const PERPENDICULARITY: f64 = 1e-5;

/// Below this solid angle (sr) area sampling is as good, and this one runs out of digits.
const SMALLEST_SOLID_ANGLE: f64 = 1e-6;

/// A rectangle as seen from one point, prepared for sampling.
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle {
    origin: DVec3,
    /// Unit vectors along the edges, and the normal towards the origin's side.
    x: DVec3,
    y: DVec3,
    z: DVec3,
    /// The rectangle in that frame, relative to the origin: [x0, x1] x [y0, y1] at height z0 < 0.
    x0: f64,
    x1: f64,
    y0: f64,
    y1: f64,
    z0: f64,
    /// z components of the unit normals of the planes through the origin and the edges y = y0 and y = y1.
    b0: f64,
    b1: f64,
    /// The angle at which the solid angle left of x is zero.
    k: f64,
    solid_angle: f64,
}

impl SphericalRectangle {
    /// The rectangle `corner + a edge_u + b edge_v`, a and b in [0, 1], seen from `origin`; all in one space, either side visible.
    ///
    /// `None` if the edges are not perpendicular, if the origin lies in the rectangle's plane, or if the solid angle is tiny: sample by
    /// area then.
    pub fn new(corner: Vec3, edge_u: Vec3, edge_v: Vec3, origin: Vec3) -> Option<Self> {
        let (origin, edge_u, edge_v) = (origin.as_dvec3(), edge_u.as_dvec3(), edge_v.as_dvec3());
        let (width, height) = (edge_u.length(), edge_v.length());
        if edge_u.dot(edge_v).abs() > PERPENDICULARITY * width * height {
            return None;
        }
        let (x, y) = (edge_u / width, edge_v / height);
        let to_corner = corner.as_dvec3() - origin;
        let normal = x.cross(y);
        let z = if to_corner.dot(normal) > 0.0 { -normal } else { normal };
        let (x0, y0, z0) = (to_corner.dot(x), to_corner.dot(y), to_corner.dot(z));
        let (x1, y1) = (x0 + width, y0 + height);

        // The unit normals of the four planes through the origin and an edge have, beside z, only an x or only a y component, so that
        // neighbours' dot products are products of z components.
        let [n0, n1, n2, n3] = [-y0, x1, y1, -x0].map(|offset| offset / length(offset, z0));
        // The interior angle between neighbours is acos(-n n') = pi / 2 + asin(n n'): the solid angle, their sum less two pi, is
        // the sum of the arc sines.
        let [g0, g1, g2, g3] = [n0 * n1, n1 * n2, n2 * n3, n3 * n0].map(f64::asin);
        let solid_angle = g0 + g1 + g2 + g3;
        if solid_angle.is_nan() || solid_angle <= SMALLEST_SOLID_ANGLE || z0 == 0.0 {
            return None;
        }
        Some(Self {
            origin,
            x,
            y,
            z,
            x0,
            x1,
            y0,
            y1,
            z0,
            b0: n0,
            b1: n2,
            k: PI - g2 - g3,
            solid_angle,
        })
    }

    /// Solid angle of the rectangle, steradian, in (0, 2 pi].
    pub fn solid_angle(&self) -> f32 {
        self.solid_angle as f32
    }

    /// Solid angle density of every sampled direction.
    pub fn pdf_solid_angle(&self) -> f32 {
        (1.0 / self.solid_angle) as f32
    }

    /// A point on the rectangle, whose direction from the origin is uniform in solid angle.
    pub fn sample(&self, u: Vec2) -> Vec3 {
        let (u, v) = (f64::from(u.x), f64::from(u.y));
        // The x at which the part of the rectangle on its left covers the fraction u of the solid angle.
        let (sin, cos) = (u * self.solid_angle + self.k).sin_cos();
        let f = (cos * self.b0 - self.b1) / sin;
        let c = (f.signum() / (f * f + self.b0 * self.b0).sqrt()).clamp(-1.0, 1.0);
        let x = (-c * self.z0 / (1.0 - c * c).sqrt()).clamp(self.x0, self.x1);
        let x = if x.is_nan() {
            self.x0 + u * (self.x1 - self.x0)
        } else {
            x
        };
        // On the segment of that x equal steps of the sine of the elevation are equal solid angles.
        let distance = length(x, self.z0);
        let (h0, h1) = (self.y0 / length(self.y0, distance), self.y1 / length(self.y1, distance));
        let h = h0 + v * (h1 - h0);
        let y = (h * distance / (1.0 - h * h).max(f64::MIN_POSITIVE).sqrt()).clamp(self.y0, self.y1);
        (self.origin + x * self.x + y * self.y + self.z0 * self.z).as_vec3()
    }
}

/// Length of (a, b). Coordinates that were `f32` cannot overflow here, which is all that `hypot` would look after, at ten times the cost.
fn length(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
