//! [`SphericalRectangle`](super::SphericalRectangle) seen from sixteen points at once, in single precision.
//!
//! The map is the same. The solid angle is that of two triangles (Van Oosterom and Strackee, The Solid Angle of a Plane Triangle, 1983),
//! whose formula loses no digits where it is small, as sums of angles do.

use std::f32::consts::TAU;

use glam::Vec3;

use super::spherical_rectangle::{Rectangle, SMALLEST_SOLID_ANGLE};
use crate::math::Vector;
use crate::math::lanes::{Lanes, Vec3Lanes, copy_sign};

/// A rectangle, prepared to be looked at from sixteen points at once.
#[derive(Clone, Copy, Debug)]
pub struct RectangleLanes {
    corner: Vec3,
    /// Unit vectors along the edges.
    x: Vec3,
    y: Vec3,
    width: f32,
    height: f32,
}

/// A point of the rectangle per lane.
#[derive(Clone, Copy, Debug)]
pub struct RectangleSampleLanes {
    pub position: Vec3Lanes,
    /// The solid angle in steradians; the density of the direction is its reciprocal.
    pub solid_angle: Lanes,
    /// A mask of the lanes whose solid angle is not too small. The other fields count only there.
    pub is_valid: Lanes,
}

/// Cosine and sine of angles.
#[derive(Clone, Copy)]
struct Turns {
    cos: Lanes,
    sin: Lanes,
}

impl Turns {
    #[inline(always)]
    fn of_sines(sin: Lanes) -> Self {
        let cos = sin.mul_neg_add(sin, Lanes::ONE).fast_max(Lanes::ZERO).sqrt();
        Self { cos, sin }
    }

    #[inline(always)]
    fn then(self, other: Self) -> Self {
        Self {
            cos: self.cos.mul_sub(other.cos, self.sin * other.sin),
            sin: self.sin.mul_add(other.cos, self.cos * other.sin),
        }
    }
}

#[inline(always)]
fn length(a: Lanes, b: Lanes) -> Lanes {
    a.mul_add(a, b * b).sqrt()
}

impl RectangleLanes {
    /// Takes the unit vectors along the edges and their lengths from `rectangle`.
    pub fn new(rectangle: &Rectangle) -> Self {
        let (corner, [x, y], [width, height]) = rectangle.parts();
        Self {
            corner,
            x,
            y,
            width,
            height,
        }
    }

    /// Samples points whose directions from `origin` are uniform in solid angle, by `u` and `v` in [0, 1).
    #[inline(always)]
    pub fn sample(&self, origin: Vec3Lanes, [u, v]: [Lanes; 2]) -> RectangleSampleLanes {
        let (zero, one) = (Lanes::ZERO, Lanes::ONE);
        let (x_axis, y_axis) = (Vec3Lanes::splat(self.x), Vec3Lanes::splat(self.y));
        let normal = Vec3Lanes::splat(self.x.cross(self.y));
        let to_corner = Vec3Lanes::splat(self.corner) - origin;
        let above = to_corner.dot(normal);
        let height = above.abs();
        let (x0, y0) = (to_corner.dot(x_axis), to_corner.dot(y_axis));
        let (x1, y1) = (x0 + Lanes::splat(self.width), y0 + Lanes::splat(self.height));

        let solid_angle = self.solid_angle([x0, x1], [y0, y1], height);

        // This is the scalar form with z0 = -height.
        let [n0, n2, n3] = [-y0, y1, -x0].map(|offset| offset / length(offset, height));
        let last = Turns::of_sines(n2 * n3).then(Turns::of_sines(n3 * n0));
        let start = Turns {
            cos: -last.cos,
            sin: last.sin,
        };
        let a0 = n0.mul_neg_add(n0, one).fast_max(zero);
        let (sin, cos) = (u * solid_angle).sin_cos();
        let turn = Turns { cos, sin }.then(start);
        let m = turn.cos.mul_sub(n0, n2);
        let root = m.mul_sub(m, a0 * turn.sin * turn.sin).fast_max(zero).sqrt();
        let x = height * copy_sign(turn.sin, turn.sin * m) / root;
        let x = x.is_nan().select(x0 + u * (x1 - x0), x.fast_max(x0).fast_min(x1));

        let distance = length(x, height);
        let (h0, h1) = (y0 / length(y0, distance), y1 / length(y1, distance));
        let h = v.mul_add(h1 - h0, h0);
        let rest = h.mul_neg_add(h, one).fast_max(Lanes::splat(f32::MIN_POSITIVE));
        let y = (h * distance / rest.sqrt()).fast_max(y0).fast_min(y1);
        let position = origin
            .plus_scaled(x, x_axis)
            .plus_scaled(y, y_axis)
            .plus_scaled(above, normal);
        RectangleSampleLanes {
            position,
            solid_angle,
            is_valid: solid_angle.simd_gt(Lanes::splat(SMALLEST_SOLID_ANGLE as f32)) & height.simd_gt(zero),
        }
    }

    /// The rectangle [x0, x1] x [y0, y1] at `height` over the origin.
    #[inline(always)]
    fn solid_angle(&self, x: [Lanes; 2], y: [Lanes; 2], height: Lanes) -> Lanes {
        // The scale is such that no product of six lengths overflows.
        let largest = |[a, b]: [Lanes; 2]| a.abs().fast_max(b.abs());
        let scale = Lanes::ONE / largest(x).fast_max(largest(y)).fast_max(height);
        let [x0, x1] = x.map(|x| x * scale);
        let [y0, y1] = y.map(|y| y * scale);
        let z = height * scale;
        let z2 = z * z;
        let product = |xa: Lanes, ya: Lanes, xb: Lanes, yb: Lanes| xa.mul_add(xb, ya.mul_add(yb, z2));
        let norm = |x: Lanes, y: Lanes| product(x, y, x, y).sqrt();
        let [a, b, c, d] = [norm(x0, y0), norm(x1, y0), norm(x1, y1), norm(x0, y1)];
        let (ab, ac, bc) = (
            product(x0, y0, x1, y0),
            product(x0, y0, x1, y1),
            product(x1, y0, x1, y1),
        );
        let (ad, dc) = (product(x0, y0, x0, y1), product(x0, y1, x1, y1));
        // The tangent of half the solid angle of either triangle is volume / sum.
        let volume = z * (x1 - x0) * (y1 - y0);
        let first = (a * b).mul_add(c, ab.mul_add(c, ac.mul_add(b, bc * a)));
        let second = (a * c).mul_add(d, ac.mul_add(d, ad.mul_add(c, dc * a)));
        let half = (volume * (first + second)).atan2(first.mul_sub(second, volume * volume));
        let whole = half + half;
        // It cannot be more than a hemisphere: rounding has turned it around.
        whole
            .simd_lt(Lanes::ZERO)
            .select(whole + Lanes::splat(2.0 * TAU), whole)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::math::lanes::LANES;

    fn numbers(seed: usize) -> Vec2 {
        Vec2::new(
            (seed as f32 * 0.754_877_7).fract(),
            (seed as f32 * 0.569_840_3 + 0.1).fract(),
        )
    }

    /// Compares with the scalar form in double precision, from near and far, beside and before, on both sides.
    #[test]
    fn samples_are_those_of_one() {
        let corner = Vec3::new(0.3, -0.4, 1.0);
        let (mut checked, mut worst_angle, mut worst_place) = (0, 0.0f32, 0.0f32);
        for edges in [
            [Vec3::X * 0.46, Vec3::Z * -0.38],
            [Vec3::new(3.0, 4.0, 0.0), Vec3::new(-0.8, 0.6, 0.0) * 0.5],
        ] {
            let rectangle = Rectangle::new(corner, edges[0], edges[1]).expect("perpendicular");
            let lanes = RectangleLanes::new(&rectangle);
            let middle = corner + 0.5 * (edges[0] + edges[1]);
            for start in (0..8192usize).step_by(LANES) {
                let mut origins = Vec3Lanes::ZERO;
                let points: [Vec2; LANES] = std::array::from_fn(|lane| numbers(3 * (start + lane) + 7));
                for lane in 0..LANES {
                    let (a, b) = (numbers(start + lane), numbers(5 * (start + lane) + 1));
                    let direction = Vec3::new(a.x - 0.5, a.y - 0.5, b.x - 0.5).normalize();
                    origins.set(lane, middle + direction * 0.02 * 500f32.powf(b.y));
                }
                let sample = lanes.sample(origins, [points.map(|p| p.x).into(), points.map(|p| p.y).into()]);
                for (lane, &point) in points.iter().enumerate() {
                    let seen = rectangle.seen_from(origins.get(lane));
                    let is_valid = sample.is_valid.to_bitmask() >> lane & 1 == 1;
                    let Some(seen) = seen.filter(|_| is_valid) else {
                        // On the border rounding decides which form sees the rectangle.
                        assert!(seen.is_none_or(|seen| seen.solid_angle() < 1.01 * SMALLEST_SOLID_ANGLE as f32));
                        continue;
                    };
                    let found = sample.solid_angle.as_array()[lane];
                    // Seen edge-on it is as uncertain as the height over its plane, by the rounding of coordinates.
                    let offset = origins.get(lane) - middle;
                    let height = offset.dot(edges[0].cross(edges[1]).normalize()).abs();
                    let allowed = 4e-6 + 8e-7 * (offset.length() + corner.length()) / height;
                    worst_angle = worst_angle.max((found / seen.solid_angle() - 1.0).abs() / allowed);
                    let place = sample.position.get(lane) - seen.sample(point);
                    let relative = place.dot(edges[0].normalize()).abs() / edges[0].length();
                    worst_place =
                        worst_place.max(relative.max(place.dot(edges[1].normalize()).abs() / edges[1].length()));
                    checked += 1;
                }
            }
        }
        assert!(checked > 10_000);
        assert!(worst_angle < 1.0, "{worst_angle}");
        assert!(worst_place < 1e-2, "{worst_place}");
    }
}
