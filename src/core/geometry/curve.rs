//! One segment of a B-spline with a round cross-section, in its own space. Only the outside can be hit, and ends are as
//! in Mitsuba 3 and Embree.
//!
//! A cubic B-spline sweeps a circle of varying radius, perpendicular to its tangent; it is open at both ends. A point P
//! of its surface belongs to the parameter v with (P - c(v)) . c'(v) = 0 and |P - c(v)| = r(v) (Nakamaru and Ohno, Ray
//! Tracing for Curves Primitive, 2002). The segment is halved until a part is nearly straight. A cylinder around the
//! part then holds its surface, and Newton's method finds the distance on the ray and v at once, from the place where
//! the ray enters that cylinder.
//!
//! Linear segments are in `round_cone`.

use std::f64::consts::TAU;
use std::ops::{Add, Mul, Sub};

use glam::{DVec3, Mat3A, Vec2, Vec3, Vec3A, Vec4, Vec4Swizzles};

use super::local::{LocalSurface, Parametrisation};
use crate::math::{Aabb, Ray, gamma};

/// How control points make up a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Basis {
    /// A uniform cubic B-spline, which goes near its points.
    BSpline,
    /// Straight lines from point to point.
    Linear,
}

impl Basis {
    /// The number of control points that a segment depends on.
    pub fn points(self) -> usize {
        match self {
            Self::BSpline => 4,
            Self::Linear => 2,
        }
    }
}

/// A ray prepared for tests against curves. Distances along it are in units of length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurveRay {
    pub(super) origin: DVec3,
    /// The vector has unit length.
    pub(super) dir: DVec3,
    /// The length of the ray's direction, by which parameters become distances.
    pub(super) length: f64,
    /// The distance before which there is no hit, and its parameter.
    pub(super) near: f64,
    pub(super) t_min: f32,
    /// The origin, and two axes across the ray and its direction, for tests of bounds.
    coarse_origin: Vec3A,
    /// The matrix whose rows are the axes.
    axes: Mat3A,
}

/// A hit of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SegmentHit {
    /// The parameter of the ray.
    pub t: f32,
    /// The angle around the curve in turns, in [0, 1), see [`around`].
    pub u: f32,
    /// The parameter along the segment, in [0, 1].
    pub v: f32,
}

impl CurveRay {
    /// None if the ray has no direction that is finite.
    pub fn new(ray: &Ray) -> Option<Self> {
        let length = ray.dir.as_dvec3().length();
        let dir = ray.dir.as_dvec3() / length;
        let (x, y) = dir.as_vec3().try_normalize()?.any_orthonormal_pair();
        (ray.origin.is_finite() && dir.is_finite()).then(|| Self {
            origin: ray.origin.as_dvec3(),
            dir,
            length,
            near: f64::from(ray.t_min) * length,
            t_min: ray.t_min,
            coarse_origin: ray.origin.into(),
            axes: Mat3A::from_cols(x.into(), y.into(), dir.as_vec3a()).transpose(),
        })
    }

    /// A place as two coordinates across the ray and the distance along it.
    #[inline(always)]
    fn coordinates(&self, place: Vec4) -> Vec3A {
        self.axes * (Vec3A::from_vec4(place) - self.coarse_origin)
    }
}

/// A part of a segment: the interval of its parameter that a node of a binary tree stands for. The whole segment is 1,
/// and the halves of `n` are `2 n` and `2 n + 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part(pub u32);

impl Part {
    pub const WHOLE: Self = Self(1);

    /// The times that the segment was halved.
    fn depth(self) -> u32 {
        self.0.ilog2()
    }

    pub fn halves(self) -> [Self; 2] {
        [2 * self.0, 2 * self.0 + 1].map(Self)
    }

    #[inline(always)]
    fn interval(self) -> [f32; 2] {
        let depth = self.depth();
        let begin = (self.0 - (1 << depth)) as f32;
        let width = 1.0 / (1u32 << depth) as f32;
        [begin * width, (begin + 1.0) * width]
    }
}

/// A segment of a cubic B-spline as a polynomial: positions, and radii as the fourth coordinate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spline {
    points: [Vec4; 4],
    coefficients: [Vec4; 4],
    /// The greatest lengths of the second derivatives of position and radius.
    bend: f32,
}

/// The polynomial of a segment in f64. Two neighbouring segments agree on the place where they meet, also far from the
/// origin.
struct Precise {
    c: [DVec3; 4],
    r: [f64; 4],
}

/// The point of a curve at a parameter, with derivatives, in f64.
struct Jet {
    c: [DVec3; 3],
    r: [f64; 2],
}

impl Spline {
    #[inline(always)]
    pub fn new(points: [Vec4; 4]) -> Self {
        let [a, b, c, d] = points;
        // Differences of neighbours are exact far from the origin.
        let (first, second) = ((a - b) + (c - b), (b - c) + (d - c));
        let bend = |of: Vec4| Vec3A::from_vec4(of).length() + of.w.abs();
        Self {
            points,
            coefficients: [
                b + first * (1.0 / 6.0),
                (c - a) * 0.5,
                first * 0.5,
                (second - first) * (1.0 / 6.0),
            ],
            bend: bend(first).max(bend(second)),
        }
    }

    /// The point at the parameter `v` in [0, 1], and the radius there.
    #[inline(always)]
    pub fn at(&self, v: f32) -> Vec4 {
        let [a, b, c, d] = self.coefficients;
        a + v * (b + v * (c + v * d))
    }

    /// The places at which the segment begins and ends.
    pub fn ends(&self) -> [Vec3; 2] {
        [0.0, 1.0].map(|v| self.at(v).xyz())
    }

    /// The most by which positions and radii in an interval of this width are off the straight line between its ends.
    #[inline(always)]
    fn off_line(&self, width: f32) -> f32 {
        0.125 * width * width * self.bend
    }

    #[inline(always)]
    fn precise(&self) -> Precise {
        fn coefficients<T>([a, b, c, d]: [T; 4]) -> [T; 4]
        where
            T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
        {
            let (first, second) = ((a - b) + (c - b), (b - c) + (d - c));
            [
                b + first * (1.0 / 6.0),
                (c - a) * 0.5,
                first * 0.5,
                (second - first) * (1.0 / 6.0),
            ]
        }
        Precise {
            c: coefficients(self.points.map(|point| point.xyz().as_dvec3())),
            r: coefficients(self.points.map(|point| f64::from(point.w))),
        }
    }

    /// A box around the surface of a part.
    pub fn bounds(&self, part: Part) -> Aabb {
        let [begin, end] = part.interval();
        let ends = [self.at(begin), self.at(end)];
        let off = self.off_line(end - begin);
        let radius = ends[0].w.max(ends[1].w) + off;
        // The curve leaves the box around its ends by less than `off`, and on each axis by no more than its own bend.
        let [first, last] = ends.map(|end| end.xyz());
        let bend = 0.125 * (end - begin).powi(2);
        let [.., c, d] = self.coefficients;
        let [one, other] = [2.0 * c, 2.0 * c + 6.0 * d].map(|of| of.xyz().abs());
        let margin = bend * one.max(other) + Vec3::splat(radius);
        let around = Aabb::from_points([first, last]);
        let rounding = gamma(16) * (around.min.abs().max(around.max.abs()) + margin);
        Aabb {
            min: around.min - margin - rounding,
            max: around.max + margin + rounding,
        }
    }

    /// The nearest hit of a part, nearer than `t_max`.
    #[inline]
    pub fn intersect(&self, part: Part, ray: &CurveRay, mut t_max: f32) -> Option<SegmentHit> {
        let [begin, end] = part.interval();
        let ends = [self.at(begin), self.at(end)].map(|end| (ray.coordinates(end), end.w));
        let mut pending = arrayvec::ArrayVec::<_, { MOST_HALVINGS as usize + 1 }>::new();
        pending.push((begin, end, ends));
        let mut nearest = None;
        while let Some((begin, end, [first, last])) = pending.pop() {
            let off = self.off_line(end - begin);
            let radius = first.1.max(last.1) + off;
            if !may_meet([first.0, last.0], radius, ray, t_max) {
                continue;
            }
            let is_straight = off <= STRAIGHT * radius || end - begin <= NARROWEST;
            if !is_straight && !pending.is_full() {
                let middle = 0.5 * (begin + end);
                let at = self.at(middle);
                let at = (ray.coordinates(at), at.w);
                let halves = [(begin, middle, [first, at]), (middle, end, [at, last])];
                // The nearer half comes first.
                let order = if first.0.z < last.0.z { [1, 0] } else { [0, 1] };
                pending.extend(order.map(|half| halves[half]));
                continue;
            }
            if let Some(hit) = self.meet([begin, end], off, ray, t_max) {
                t_max = hit.t;
                nearest = Some(hit);
            }
        }
        nearest
    }

    /// The hit of an interval that is nearly straight.
    fn meet(&self, interval: [f32; 2], off: f32, ray: &CurveRay, t_max: f32) -> Option<SegmentHit> {
        let [begin, end] = interval.map(f64::from);
        let precise = self.precise();
        let (one, other) = (precise.jet(begin), precise.jet(end));
        let off = f64::from(off);
        let radius = one.r[0].max(other.r[0]) + off;
        let start = start(ray, [one.c[0], other.c[0]], off, radius, t_max)?;
        let width = end - begin;
        let mut s = start.0;
        // Not at an end, where the derivative may be zero.
        let mut v = begin + width * start.1.clamp(0.05, 0.95);
        for _ in 0..MOST_STEPS {
            let Jet { c, r } = precise.jet(v);
            let x = ray.origin + s * ray.dir - c[0];
            let (f, g) = (x.dot(c[1]), x.length_squared() - r[0] * r[0]);
            // f over |c'(v)| is the distance from the plane of the cross-section. Its derivative, times |c'(v)|, is in
            // place of that of f, which has roots where c'(v) is zero.
            let length_squared = c[1].length_squared();
            let f_v = x.dot(c[2]) - length_squared - f * c[1].dot(c[2]) / length_squared;
            let f_s = ray.dir.dot(c[1]);
            let (g_s, g_v) = (2.0 * x.dot(ray.dir), -2.0 * (f + r[0] * r[1]));
            let determinant = f_s * g_v - f_v * g_s;
            let (by_s, by_v) = ((f * g_v - g * f_v) / determinant, (f_s * g - g_s * f) / determinant);
            s -= by_s;
            // A step may leave the interval for a while, but not the neighbourhood in which it is nearly straight.
            v = (v - by_v).clamp(begin - width, end + width);
            if by_s.abs() <= SETTLED * radius && (by_v * by_v * length_squared) <= (SETTLED * radius).powi(2) {
                return precise.accept([begin, end], s, v, ray, t_max);
            }
        }
        None
    }

    /// The surface at a hit.
    pub fn surface(&self, u: f32, v: f32) -> LocalSurface {
        let jet = self.precise().jet(v.into());
        let x = jet.offset(u);
        let position = (jet.c[0] + x).as_vec3();
        LocalSurface {
            position,
            error: gamma(4) * position.abs() + Vec3::splat((SETTLED * jet.r[0]) as f32),
            normal: jet.normal(x).normalize_or(x.normalize_or(DVec3::Z)).as_vec3(),
        }
    }

    /// The parametrisation at a hit on the segment `number` of `count`. `up` is the local direction from which angles
    /// are counted in Mitsuba: its world's z axis.
    pub fn parametrisation(&self, [u, v]: [f32; 2], [number, count]: [usize; 2], up: Vec3) -> Parametrisation {
        let jet = self.precise().jet(v.into());
        let x = jet.offset(u);
        let [_, first, second] = jet.c;
        let length_squared = first.length_squared();
        // The frame turns with the tangent: the offset stays perpendicular to it.
        let turning = -first * (x.dot(second) / length_squared);
        let growing = x.normalize_or_zero() * jet.r[1];
        Parametrisation {
            uv: Vec2::new(
                angle(x, first, up.as_dvec3()) as f32,
                (number as f32 + v) / count as f32,
            ),
            dp_du: (TAU * first.normalize_or_zero().cross(x)).as_vec3(),
            dp_dv: ((first + growing + turning) * count as f64).as_vec3(),
        }
    }
}

/// A part is nearly straight if its curve is off a line by less than this share of its radius.
const STRAIGHT: f32 = 0.1;
/// Narrower intervals of the parameter are not halved.
const NARROWEST: f32 = 1.0 / 64.0;
/// The most times that an interval is halved: as often as the widest one needs.
const MOST_HALVINGS: u32 = 6;
/// The most steps of Newton's method. Three or four suffice but for rays that touch the surface.
const MOST_STEPS: usize = 16;
/// The length of the last step, as a share of the radius. The error is about its square then.
const SETTLED: f64 = 1e-5;
/// The width by which neighbouring intervals overlap, so that no ray passes between them.
const OVERLAP: f64 = 1e-6;

/// The most by which a hit is off the plane of its cross-section, as a share of the radius. Where three control points
/// coincide, the derivative is zero, so that Newton's method also finds places beyond the open end.
const OFF_PLANE: f64 = 1e-3;

impl Precise {
    #[inline(always)]
    fn jet(&self, v: f64) -> Jet {
        let ([a, b, c, d], [e, f, g, h]) = (self.c, self.r);
        Jet {
            c: [
                a + v * (b + v * (c + v * d)),
                b + v * (2.0 * c + 3.0 * v * d),
                2.0 * c + 6.0 * v * d,
            ],
            r: [e + v * (f + v * (g + v * h)), f + v * (2.0 * g + 3.0 * v * h)],
        }
    }

    /// The hit at the distance `s`, if it is within the bounds and on the outside.
    fn accept(&self, [begin, end]: [f64; 2], s: f64, v: f64, ray: &CurveRay, t_max: f32) -> Option<SegmentHit> {
        let is_within = v >= begin - OVERLAP && v <= end + OVERLAP;
        let t = (s / ray.length) as f32;
        if !(is_within && t > ray.t_min && t < t_max) {
            return None;
        }
        let jet = self.jet(v);
        let x = ray.origin + s * ray.dir - jet.c[0];
        let is_across = x.dot(jet.c[1]).abs() < OFF_PLANE * jet.r[0] * jet.c[1].length();
        (is_across && jet.normal(x).dot(ray.dir) < 0.0).then(|| SegmentHit {
            t,
            u: angle(x, jet.c[1], DVec3::Z) as f32,
            v: v.clamp(0.0, 1.0) as f32,
        })
    }
}

impl Jet {
    /// The normal at the offset `x` from the curve, not of unit length. On the inner side of a bend that is too tight
    /// for its radius the surface is folded, and the normal turned.
    #[inline(always)]
    fn normal(&self, x: DVec3) -> DVec3 {
        let [_, first, second] = self.c;
        x * (first.length_squared() - x.dot(second)) - first * (self.r[0] * self.r[1])
    }

    /// The offset from the curve at this angle.
    fn offset(&self, u: f32) -> DVec3 {
        let [x, y] = around(self.c[1], DVec3::Z);
        let (sin, cos) = (TAU * f64::from(u)).sin_cos();
        self.r[0] * (cos * x + sin * y)
    }
}

/// The directions of the angles 0 and a quarter turn around a curve with this tangent, as in Mitsuba: the latter is the
/// part of `up` across the tangent.
fn around(tangent: DVec3, up: DVec3) -> [DVec3; 2] {
    let along = tangent.try_normalize().unwrap_or(DVec3::X);
    let y = (up - along * along.dot(up))
        .try_normalize()
        .unwrap_or_else(|| along.any_orthonormal_vector());
    [y.cross(along), y]
}

/// The angle of the offset `x` around a curve with this tangent in turns, in [0, 1).
pub(super) fn angle(x: DVec3, tangent: DVec3, up: DVec3) -> f64 {
    let [at_zero, at_quarter] = around(tangent, up);
    let turn = x.dot(at_quarter).atan2(x.dot(at_zero)) / TAU;
    let turn = if turn < 0.0 { turn + 1.0 } else { turn };
    // The largest number below 1 in f32 is 1 - 2^-24.
    turn.min(1.0 - f64::from(f32::EPSILON) / 2.0)
}

/// Whether the ray comes as near as `radius` to the line between two places, which are given in its coordinates.
#[inline(always)]
fn may_meet([a, b]: [Vec3A; 2], radius: f32, ray: &CurveRay, t_max: f32) -> bool {
    let far = a.abs().max(b.abs()).max_element();
    // Covers the rounding of coordinates.
    let radius = radius + gamma(16) * (far + ray.coarse_origin.abs().max_element());
    let (along, begin) = (b - a, -a);
    let length_squared = along.x * along.x + along.y * along.y;
    let share = (begin.x * along.x + begin.y * along.y) / length_squared.max(f32::MIN_POSITIVE);
    let nearest = a + share.clamp(0.0, 1.0) * along;
    let is_near = nearest.x * nearest.x + nearest.y * nearest.y <= radius * radius;
    let (first, last) = (a.z.min(b.z) - radius, a.z.max(b.z) + radius);
    is_near && f64::from(last) >= ray.near && first <= t_max * ray.length as f32
}

/// The distance at which the ray enters the cylinder of this radius around the line from `a` to `b`, cut off where no
/// surface of the part can be, and the share of the line there, in [0, 1].
fn start(ray: &CurveRay, [a, b]: [DVec3; 2], off: f64, radius: f64, t_max: f32) -> Option<(f64, f64)> {
    let line = b - a;
    let length = line.length();
    let along = if length > 0.0 { line / length } else { ray.dir };
    let q = ray.origin - a;
    let (q_along, d_along) = (q.dot(along), ray.dir.dot(along));
    let (q_across, d_across) = (q - q_along * along, ray.dir - d_along * along);
    let (square, half) = (d_across.length_squared(), q_across.dot(d_across));
    // The distance of the two lines, from the point of the ray that is nearest to the cylinder's axis.
    let nearest = if square > 0.0 { -half / square } else { 0.0 };
    let room = radius * radius - (q_across + nearest * d_across).length_squared();
    if room < 0.0 {
        return None;
    }
    let reach = (room / square.max(f64::MIN_POSITIVE)).sqrt();
    let margin = off + radius * (4.0 * off / length.max(f64::MIN_POSITIVE)).min(1.0);
    let at = |end: f64| (end - q_along) / d_along;
    let (mut enter, mut leave) = (nearest - reach, nearest + reach);
    if d_along != 0.0 {
        let (one, other) = (at(-margin), at(length + margin));
        enter = enter.max(one.min(other));
        leave = leave.min(one.max(other));
    }
    let is_there = enter <= leave && leave >= ray.near && enter <= f64::from(t_max) * ray.length;
    let share = (q_along + enter * d_along) / length.max(f64::MIN_POSITIVE);
    is_there.then(|| (enter, share.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests;
