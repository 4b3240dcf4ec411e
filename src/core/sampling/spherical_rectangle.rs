//! Uniform sampling of the solid angle under which a rectangle is seen, from one point or from sixteen.
//!
//! Ureña, Fajardo and King, An Area-Preserving Parametrization for Spherical Rectangles, EGSR 2013. In single
//! precision, which needs another formula for the solid angle than the paper's sum of angles. Only for rectangles;
//! other parallelograms are sampled by area.

use glam::Vec3;

use crate::math::{Real, Vector, atan2, real_struct, sin_cos};

/// Cosine of the angle between the edges up to which a parallelogram counts as a rectangle: just the rounding of an
/// `f32` transform.
const PERPENDICULARITY: f64 = 1e-5;

/// Below this solid angle (sr) sampling by area is as good, and this method runs out of digits.
const SMALLEST_SOLID_ANGLE: f32 = 1e-3;

/// The method also runs out of digits for origins beside a rectangle and lower than this above its plane, relative to
/// the distance.
const LOWEST: f32 = 0.02;

real_struct! {
    #[same]
    /// A rectangle prepared to be seen from many points.
    pub struct Rectangle<R> {
        corner: R::Vec3,
        /// Unit vectors along the edges, and the normal.
        x_axis: R::Vec3,
        y_axis: R::Vec3,
        z_axis: R::Vec3,
        width: R,
        height: R,
    }
}

/// A rectangle as seen from one point, prepared for sampling.
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle<R: Real = f32> {
    axes: [R::Vec3; 3],
    origin: R::Vec3,
    /// The rectangle along those axes, relative to the origin: `x[0]` to `x[1]` and `y[0]` to `y[1]` at the height
    /// `above`.
    x: [R; 2],
    y: [R; 2],
    above: R,
    solid_angle: R,
}

/// Cosine and sine of an angle, to add angles without computing them.
#[derive(Clone, Copy)]
struct Turn<R> {
    cos: R,
    sin: R,
}

impl<R: Real> Turn<R> {
    /// The direction of (x, y), seen from the origin.
    #[inline(always)]
    fn towards(x: R, y: R) -> Self {
        let scale = R::ONE / length(x, y);
        Self {
            cos: x * scale,
            sin: y * scale,
        }
    }

    /// The turn whose sine is the product of two sines.
    #[inline(always)]
    fn of_sines(a: Self, b: Self) -> Self {
        Self {
            cos: length(a.cos, a.sin * b.cos),
            sin: a.sin * b.sin,
        }
    }

    #[inline(always)]
    fn then(self, other: Self) -> Self {
        Self {
            cos: self.cos.mul_add(other.cos, -self.sin * other.sin),
            sin: self.sin.mul_add(other.cos, self.cos * other.sin),
        }
    }
}

impl Rectangle {
    /// The rectangle `corner + a edge_u + b edge_v`, a and b in [0, 1]. `None` if the edges are not perpendicular, or
    /// one has no length.
    pub fn new(corner: Vec3, edge_u: Vec3, edge_v: Vec3) -> Option<Self> {
        let (edge_u, edge_v) = (edge_u.as_dvec3(), edge_v.as_dvec3());
        let (width, height) = (edge_u.length(), edge_v.length());
        let is_rectangle = edge_u.dot(edge_v).abs() <= PERPENDICULARITY * width * height;
        if !is_rectangle || width * height == 0.0 {
            return None;
        }
        let (x, y) = (edge_u / width, edge_v / height);
        Some(Self {
            corner,
            x_axis: x.as_vec3(),
            y_axis: y.as_vec3(),
            z_axis: x.cross(y).as_vec3(),
            width: width as f32,
            height: height as f32,
        })
    }
}

impl<R: Real> Rectangle<R> {
    /// Unit normal.
    #[inline(always)]
    pub(crate) fn normal(&self) -> R::Vec3 {
        self.z_axis
    }

    /// The point at these fractions of the edges, from 0 to 1.
    #[inline(always)]
    pub fn at(&self, [a, b]: [R; 2]) -> R::Vec3 {
        self.corner
            .plus_scaled(a * self.width, self.x_axis)
            .plus_scaled(b * self.height, self.y_axis)
    }

    /// Selects `yes` where `condition` holds, else `no`.
    #[inline(always)]
    pub(crate) fn select(condition: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            corner: R::Vec3::select(condition, yes.corner, no.corner),
            x_axis: R::Vec3::select(condition, yes.x_axis, no.x_axis),
            y_axis: R::Vec3::select(condition, yes.y_axis, no.y_axis),
            z_axis: R::Vec3::select(condition, yes.z_axis, no.z_axis),
            width: R::select(condition, yes.width, no.width),
            height: R::select(condition, yes.height, no.height),
        }
    }

    /// The height of its highest corner over the plane through `origin` with this normal, and the cosine between the
    /// normal and the direction to its middle.
    #[inline(always)]
    pub(crate) fn heights_over(&self, origin: R::Vec3, normal: R::Vec3) -> (R, R) {
        let to_corner = self.corner - origin;
        let along = normal.dot(self.x_axis) * self.width;
        let across = normal.dot(self.y_axis) * self.height;
        let highest = normal.dot(to_corner) + along.max(R::ZERO) + across.max(R::ZERO);
        let to_middle = to_corner
            .plus_scaled(R::HALF * self.width, self.x_axis)
            .plus_scaled(R::HALF * self.height, self.y_axis);
        (highest, normal.dot(to_middle.normalize()))
    }

    /// A mask of the rays from `origin` along `dir` that meet the rectangle.
    #[inline(always)]
    pub(crate) fn is_met(&self, origin: R::Vec3, dir: R::Vec3) -> R::Mask {
        let to_corner = self.corner - origin;
        let t = to_corner.dot(self.z_axis) / dir.dot(self.z_axis);
        let [x, y] = [self.x_axis, self.y_axis].map(|axis| t * dir.dot(axis) - to_corner.dot(axis));
        let within = |x: R, end: R| !x.is_less(R::ZERO) & !x.is_more(end);
        t.is_more(R::ZERO) & within(x, self.width) & within(y, self.height)
    }

    /// The rectangle as seen from a point in the same space, on either side.
    #[inline(always)]
    pub fn seen_from(&self, origin: R::Vec3) -> SphericalRectangle<R> {
        let axes = [self.x_axis, self.y_axis, self.z_axis];
        let to_corner = self.corner - origin;
        let [x, y, above] = axes.map(|axis| to_corner.dot(axis));
        let (x, y) = ([x, x + self.width], [y, y + self.height]);
        SphericalRectangle {
            axes,
            origin,
            x,
            y,
            above,
            solid_angle: self.solid_angle(x, y, above.abs()),
        }
    }

    /// The solid angle of the rectangle from `x[0]` to `x[1]` and `y[0]` to `y[1]`, `height` above the origin.
    ///
    /// It is a sum of four arc tangents. At both ends of a short edge they are nearly equal where the rectangle looks
    /// thin or small, so their difference is computed directly. The long edges have digits enough.
    #[inline(always)]
    fn solid_angle(&self, x: [R; 2], y: [R; 2], height: R) -> R {
        let is_high = self.width.is_less(self.height);
        let choose = |high: [R; 2], wide: [R; 2]| [0, 1].map(|end| R::select(is_high, high[end], wide[end]));
        let (long, short, extent) = (choose(y, x), choose(x, y), self.width.min(self.height));
        // The scale prevents products from overflowing.
        let largest = |[a, b]: [R; 2]| a.abs().max(b.abs());
        let scale = R::ONE / largest(x).max(largest(y)).max(height);
        let [l0, l1] = long.map(|l| l * scale);
        let [s0, s1] = short.map(|s| s * scale);
        let (z, extent) = (height * scale, extent * scale);
        let is_beside = (s0 * s1).is_more(R::ZERO);
        // The angle by which the short edge at `l` contributes to the solid angle on its left.
        let angle = |l: R| {
            let square = l.mul_add(l, z * z);
            let (r0, r1) = (s0.mul_add(s0, square).sqrt(), s1.mul_add(s1, square).sqrt());
            let (sin0, sin1) = (s0 / r0, s1 / r1);
            let both = r0 * r1 * s1.mul_add(r0, s0 * r1);
            let difference = R::select(is_beside, extent * (s0 + s1) * square / both, sin1 - sin0);
            atan2(l * z * difference, (l * l * sin0).mul_add(sin1, z * z))
        };
        angle(l1) - angle(l0)
    }
}

impl<R: Real> SphericalRectangle<R> {
    /// Solid angle of the rectangle, steradian, in [0, 2 pi].
    #[inline(always)]
    pub fn solid_angle(&self) -> R {
        self.solid_angle
    }

    /// Solid angle density of every sampled direction.
    #[inline(always)]
    pub fn pdf_solid_angle(&self) -> R {
        R::ONE / self.solid_angle
    }

    /// The height of the rectangle's plane over the origin, along its normal.
    #[inline(always)]
    pub(crate) fn above(&self) -> R {
        self.above
    }

    /// A mask of the origins that are higher over the plane, on either side, than this share of the longer edge.
    #[inline(always)]
    pub(crate) fn is_apart(&self, share: f32) -> R::Mask {
        let longer = (self.x[1] - self.x[0]).max(self.y[1] - self.y[0]);
        self.above.abs().is_more(longer * R::splat(share))
    }

    /// A mask of the origins for which it can be sampled: not in the rectangle's plane, nor beside it and low above the
    /// plane, nor where the solid angle is tiny. Sample by area elsewhere.
    #[inline(always)]
    pub fn is_large(&self) -> R::Mask {
        let height = self.above.abs();
        // The distance of the origin beside the rectangle.
        let gap = |[a, b]: [R; 2]| a.abs().min(b.abs()).only((a * b).is_more(R::ZERO));
        let is_low = height.is_less(gap(self.x).max(gap(self.y)) * R::splat(LOWEST));
        R::is_above(self.solid_angle, SMALLEST_SOLID_ANGLE) & R::is_above(height, 0.0) & !is_low
    }

    /// Samples a point on the rectangle whose direction from the origin is uniform in solid angle.
    #[inline(always)]
    pub fn sample(&self, u: [R; 2]) -> R::Vec3 {
        self.origin + self.sample_offset(u)
    }

    /// [`Self::sample`] relative to the origin: the direction to the point, exact also where the origin is far from
    /// that of the space.
    #[inline(always)]
    pub(crate) fn sample_offset(&self, [u, v]: [R; 2]) -> R::Vec3 {
        let ([x0, x1], [y0, y1], height) = (self.x, self.y, self.above.abs());
        // The planes through the origin and three of the edges. Their unit normals have, beside z, only an x or only a
        // y component, so that neighbours' dot products are products of z components. The interior angle
        // between neighbours is acos(-n n') = pi / 2 + asin(n n').
        let [n0, n2, n3] = [-y0, y1, -x0].map(|offset| Turn::towards(height, offset));
        let last = Turn::of_sines(n2, n3).then(Turn::of_sines(n3, n0));
        // The angle at which the solid angle left of x is zero: pi less the two angles above.
        let start = Turn {
            cos: -last.cos,
            sin: last.sin,
        };
        // The x at which the part of the rectangle on its left covers the fraction u of the solid angle: with the
        // paper's f = m / sin and c = +-1 / sqrt(f^2 + b0^2), x = -c z0 / sqrt(1 - c^2), both fractions of
        // roots in one.
        let (sin, cos) = sin_cos(u * self.solid_angle);
        let turn = Turn { cos, sin }.then(start);
        let m = turn.cos.mul_add(n0.sin, -n2.sin);
        let root = m.mul_add(m, -(n0.cos * turn.sin).squared()).max(R::ZERO).sqrt();
        let x = height * turn.sin.copy_sign(turn.sin * m) / root;
        let x = R::select(x.equals(x), x.max(x0).min(x1), x0 + u * (x1 - x0));
        // On the segment of this x, equal steps of the sine of the elevation are equal solid angles.
        let distance = length(x, height);
        let (h0, h1) = (y0 / length(y0, distance), y1 / length(y1, distance));
        let h = v.mul_add(h1 - h0, h0);
        let rest = (-h).mul_add(h, R::ONE).max(R::splat(f32::MIN_POSITIVE));
        let y = (h * distance / rest.sqrt()).max(y0).min(y1);
        let [x_axis, y_axis, z_axis] = self.axes;
        x_axis * x + y_axis * y + z_axis * self.above
    }
}

#[inline(always)]
fn length<R: Real>(a: R, b: R) -> R {
    a.mul_add(a, b * b).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Same;
    use crate::math::lanes::{LANES, Lanes, Vec3Lanes};

    fn numbers(seed: usize) -> [f32; 2] {
        [0.754_877_7, 0.569_840_3].map(|factor| (seed as f32 * factor + 0.1).fract())
    }

    /// Origins near and far, beside and in front, on both sides, touching the rectangle and edge-on.
    #[test]
    fn samples_in_lanes_are_those_of_one() {
        let corner = Vec3::new(0.3, -0.4, 1.0);
        let (mut checked, mut worst_angle, mut worst_place) = (0, 0.0f32, 0.0f32);
        for edges in [
            [Vec3::X * 0.46, Vec3::Z * -0.38],
            [Vec3::new(3.0, 4.0, 0.0), Vec3::new(-0.8, 0.6, 0.0) * 0.5],
            [Vec3::new(0.0, 300.0, 0.0), Vec3::new(0.02, 0.0, 0.01)],
        ] {
            let rectangle = Rectangle::new(corner, edges[0], edges[1]).expect("perpendicular");
            let normal = edges[0].cross(edges[1]).normalize();
            let middle = corner + 0.5 * (edges[0] + edges[1]);
            for start in (0..8192usize).step_by(LANES) {
                let mut origins = Vec3Lanes::ZERO;
                let mut u = [Lanes::ZERO; 2];
                for lane in 0..LANES {
                    let (a, b) = (numbers(start + lane), numbers(5 * (start + lane) + 1));
                    let distance = 0.02 * 500f32.powf(b[1]);
                    let place = match lane % 4 {
                        0 => corner + a[0] * edges[0] + a[1] * edges[1] + normal * (1e-6 * distance),
                        1 => corner + 2.0 * a[0] * edges[0] - a[1] * edges[1] + normal * (0.1 * distance),
                        _ => middle + Vec3::new(a[0] - 0.5, a[1] - 0.5, b[0] - 0.5).normalize() * distance,
                    };
                    origins.set(lane, place);
                    let point = numbers(3 * (start + lane) + 7);
                    (0..2).for_each(|axis| u[axis].as_mut_array()[lane] = point[axis]);
                }
                let lanes = Same::<Lanes>::same(rectangle).seen_from(origins);
                let (places, is_large) = (lanes.sample(u), lanes.is_large().to_bitmask());
                for lane in 0..LANES {
                    let one = rectangle.seen_from(origins.get(lane));
                    let found = lanes.solid_angle().as_array()[lane];
                    // Edge-on the uncertainty is that of the height above the plane, by the rounding of coordinates.
                    let offset = origins.get(lane) - middle;
                    let allowed = 2e-5
                        + 8e-7 * ((origins.get(lane) - corner).length() + corner.length()) / offset.dot(normal).abs();
                    if !one.is_large() || is_large >> lane & 1 == 0 {
                        // At the threshold rounding decides.
                        let least = found.min(one.solid_angle());
                        let is_edge_on =
                            offset.dot(normal).abs() < 1.01 * LOWEST * offset.length().max(edges[0].length());
                        assert!(is_edge_on || least <= (1.0 + allowed) * SMALLEST_SOLID_ANGLE, "{least}");
                        continue;
                    }
                    worst_angle = worst_angle.max((found / one.solid_angle() - 1.0).abs() / allowed);
                    let expected = one.sample(u.map(|numbers| numbers.as_array()[lane]));
                    let place = places.get(lane) - expected;
                    // By the edges, or by the angle where the rectangle is so near that it reaches the horizon.
                    let [along, across] = edges.map(|edge| place.dot(edge).abs() / edge.length_squared());
                    let angle = place.length() / expected.distance(origins.get(lane));
                    worst_place = worst_place.max(along.max(across).min(angle));
                    checked += 1;
                }
            }
        }
        assert!(checked > 15_000, "{checked}");
        assert!(worst_angle < 1.0, "{worst_angle}");
        assert!(worst_place < 1e-2, "{worst_place}");
    }
}
