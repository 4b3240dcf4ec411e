//! Uniform sampling of the solid angle under which a rectangle is seen.
//!
//! Ureña, Fajardo and King, An Area-Preserving Parametrization for Spherical Rectangles, EGSR 2013. In double precision inside, for the
//! sake of small and distant rectangles. Only for rectangles; a parallelogram that is none is sampled by area.

use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::TAU;

/// Cosine of the edges' angle up to which a parallelogram counts as a rectangle: the rounding of an `f32` transform, no more.
const PERPENDICULARITY: f64 = 1e-5;

/// Below this solid angle (sr) sampling by area is as good, and this method runs out of digits in single precision.
pub(super) const SMALLEST_SOLID_ANGLE: f64 = 1e-3;

/// A rectangle, prepared to be looked at from many points.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    corner: Vec3,
    /// Unit vectors along the edges.
    x: DVec3,
    y: DVec3,
    width: f64,
    height: f64,
}

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
    /// The z components of the unit normals of the planes through the origin and the edges y = y0 and y = y1; 1 - b0^2.
    b0: f64,
    b1: f64,
    a0: f64,
    /// The angle at which the solid angle left of x is zero.
    start: Turn,
    solid_angle: f64,
}

/// Cosine and sine of an angle: sums of angles without the angles.
#[derive(Clone, Copy, Debug)]
struct Turn {
    cos: f64,
    sin: f64,
}

impl Turn {
    /// The turn by an angle in [-pi / 2, pi / 2], given its sine.
    fn of_sine(sin: f64) -> Self {
        let cos = (1.0 - sin * sin).max(0.0).sqrt();
        Self { cos, sin }
    }

    fn then(self, other: Self) -> Self {
        Self {
            cos: self.cos * other.cos - self.sin * other.sin,
            sin: self.sin * other.cos + self.cos * other.sin,
        }
    }
}

impl Rectangle {
    /// The rectangle `corner + a edge_u + b edge_v`, a and b in [0, 1]. `None` if the edges are not perpendicular, or one has no length.
    pub fn new(corner: Vec3, edge_u: Vec3, edge_v: Vec3) -> Option<Self> {
        let (edge_u, edge_v) = (edge_u.as_dvec3(), edge_v.as_dvec3());
        let (width, height) = (edge_u.length(), edge_v.length());
        let is_rectangle = edge_u.dot(edge_v).abs() <= PERPENDICULARITY * width * height;
        if !is_rectangle || width * height == 0.0 {
            return None;
        }
        Some(Self {
            corner,
            x: edge_u / width,
            y: edge_v / height,
            width,
            height,
        })
    }

    /// The corner, the unit vectors along the edges, and the lengths of the edges.
    pub(super) fn parts(&self) -> (Vec3, [Vec3; 2], [f32; 2]) {
        let axes = [self.x, self.y].map(|axis| axis.as_vec3());
        (self.corner, axes, [self.width as f32, self.height as f32])
    }

    /// The rectangle as seen from a point in the same space, on either side. `None` if the point lies in the rectangle's plane, or if the solid
    /// angle is tiny: sample by area then.
    pub fn seen_from(&self, origin: Vec3) -> Option<SphericalRectangle> {
        let Self { x, y, .. } = *self;
        let origin = origin.as_dvec3();
        let to_corner = self.corner.as_dvec3() - origin;
        let normal = x.cross(y);
        let above = to_corner.dot(normal);
        let (z, z0) = if above > 0.0 {
            (-normal, -above)
        } else {
            (normal, above)
        };
        let (x0, y0) = (to_corner.dot(x), to_corner.dot(y));
        let (x1, y1) = (x0 + self.width, y0 + self.height);

        // The unit normals of the four planes through the origin and an edge have, beside z, only an x or only a y component, so that
        // neighbours' dot products are products of z components.
        let [n0, n1, n2, n3] = [-y0, x1, y1, -x0].map(|offset| offset / length(offset, z0));
        // The interior angle between neighbours is acos(-n n') = pi / 2 + asin(n n'): the solid angle, their sum less two pi, is
        // the sum of the arc sines.
        let [g0, g1, g2, g3] = [n0 * n1, n1 * n2, n2 * n3, n3 * n0].map(Turn::of_sine);
        let last = g2.then(g3);
        let all = g0.then(g1).then(last);
        let turned = all.sin.atan2(all.cos);
        // The rectangle fills more than half a hemisphere, a negative angle or a rounded whole turn, only for points closely before it.
        let is_before = x0 < 0.0 && x1 > 0.0 && y0 < 0.0 && y1 > 0.0;
        let is_close = is_before && -z0 < self.width.min(self.height);
        let solid_angle = if is_close && turned <= SMALLEST_SOLID_ANGLE {
            turned + TAU
        } else {
            turned
        };
        if solid_angle.is_nan() || solid_angle <= SMALLEST_SOLID_ANGLE || z0 == 0.0 {
            return None;
        }
        Some(SphericalRectangle {
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
            a0: z0 * z0 / (y0 * y0 + z0 * z0),
            // This is pi less the last two.
            start: Turn {
                cos: -last.cos,
                sin: last.sin,
            },
            solid_angle,
        })
    }
}

impl SphericalRectangle {
    /// Solid angle of the rectangle, steradian, in (0, 2 pi].
    pub fn solid_angle(&self) -> f32 {
        self.solid_angle as f32
    }

    /// Solid angle density of every sampled direction.
    pub fn pdf_solid_angle(&self) -> f32 {
        (1.0 / self.solid_angle) as f32
    }

    /// Samples a point on the rectangle whose direction from the origin is uniform in solid angle.
    pub fn sample(&self, u: Vec2) -> Vec3 {
        let (u, v) = (f64::from(u.x), f64::from(u.y));
        // The x at which the part of the rectangle on its left covers the fraction u of the solid angle: with the paper's f = m / sin and
        // c = +-1 / sqrt(f^2 + b0^2), x = -c z0 / sqrt(1 - c^2), both fractions of roots in one.
        let (sin, cos) = (u * self.solid_angle).sin_cos();
        let turn = Turn { cos, sin }.then(self.start);
        let m = turn.cos * self.b0 - self.b1;
        let root = (m * m - self.a0 * turn.sin * turn.sin).max(0.0).sqrt();
        let x = (-self.z0 * turn.sin.copysign(turn.sin * m) / root).clamp(self.x0, self.x1);
        let x = if x.is_nan() {
            self.x0 + u * (self.x1 - self.x0)
        } else {
            x
        };
        // On the segment of this x, equal steps of the sine of the elevation are equal solid angles.
        let distance = length(x, self.z0);
        let (h0, h1) = (self.y0 / length(self.y0, distance), self.y1 / length(self.y1, distance));
        let h = h0 + v * (h1 - h0);
        let y = (h * distance / (1.0 - h * h).max(f64::MIN_POSITIVE).sqrt()).clamp(self.y0, self.y1);
        (self.origin + x * self.x + y * self.y + self.z0 * self.z).as_vec3()
    }
}

/// The length of (a, b). Coordinates that were `f32` cannot overflow here, which is all that `hypot` would prevent, at ten times the cost.
fn length(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
