//! One segment of a linear curve: the convex hull of the spheres at its ends, a cone that touches both, with their caps
//! (Han, Wald, Usher, Wu, Wang, Pascucci, Hansen and Johnson, Ray Tracing Generalized Tube Primitives, 2019).

use std::f64::consts::TAU;

use glam::{DVec3, Vec2, Vec3, Vec4, Vec4Swizzles};

use super::curve::{CurveRay, SegmentHit, angle};
use super::local::{LocalSurface, Parametrisation};
use crate::math::{Aabb, Ray, gamma};

/// A segment of a linear curve: the convex hull of two spheres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundCone {
    a: DVec3,
    /// From the first centre to the second.
    axis: DVec3,
    radius: f64,
    /// The second radius minus the first.
    growth: f64,
    /// The squared length of the lines that touch both spheres. Not above 0 if one sphere is within the other.
    square: f64,
}

impl RoundCone {
    #[inline(always)]
    pub fn new([from, to]: [Vec4; 2]) -> Self {
        let (a, radius) = (from.xyz().as_dvec3(), f64::from(from.w));
        let axis = to.xyz().as_dvec3() - a;
        let growth = f64::from(to.w) - radius;
        Self {
            a,
            axis,
            radius,
            growth,
            square: axis.length_squared() - growth * growth,
        }
    }

    /// A box around the hull.
    pub fn bounds([from, to]: [Vec4; 2]) -> Aabb {
        let around = |point: Vec4| Aabb {
            min: point.xyz() - point.w,
            max: point.xyz() + point.w,
        };
        let Aabb { min, max } = around(from).union(around(to));
        let rounding = gamma(8) * min.abs().max(max.abs());
        Aabb {
            min: min - rounding,
            max: max + rounding,
        }
    }

    /// The parameter of the sphere that touches the hull nearest to the offset `q` from the first centre.
    #[inline(always)]
    fn parameter(&self, q: DVec3) -> f64 {
        if self.square > 0.0 {
            (q.dot(self.axis) + self.radius * self.growth) / self.square
        } else {
            f64::from(self.growth > 0.0)
        }
    }

    /// Whether a place is within the hull, by more than rounding.
    pub fn holds(&self, place: DVec3) -> bool {
        let q = place - self.a;
        let v = self.parameter(q).clamp(0.0, 1.0);
        let radius = self.radius + v * self.growth;
        (q - v * self.axis).length() < radius * (1.0 - 1e-6)
    }

    /// The place where the ray enters the hull, nearer than `t_max`: the hit, and the place itself. The cap at the
    /// begin is left out unless `begins`: it is part of the cap at the end of the segment before.
    #[inline]
    pub fn intersect(&self, ray: &CurveRay, t_max: f32, begins: impl FnOnce() -> bool) -> Option<(SegmentHit, DVec3)> {
        let q = ray.origin - self.a;
        let sphere = |center: DVec3, radius: f64| {
            let from = q - center;
            let nearest = -from.dot(ray.dir);
            let room = radius * radius - (from + nearest * ray.dir).length_squared();
            (room >= 0.0).then(|| nearest - room.sqrt())
        };
        let on_sphere = |v: f64| sphere(v * self.axis, self.radius + v * self.growth);
        // The hull is convex: the ray enters it where it enters the cone between the caps, or one of these.
        let v_at = |s: f64| self.parameter(q + s * ray.dir);
        let (s, v) = self
            .enter_cone(q, ray.dir)
            .map(|s| (s, v_at(s)))
            .filter(|(_, v)| (0.0..=1.0).contains(v))
            .or_else(|| {
                let s = on_sphere(0.0).filter(|s| v_at(*s) <= 0.0)?;
                begins().then_some((s, 0.0))
            })
            .or_else(|| on_sphere(1.0).map(|s| (s, 1.0)).filter(|(s, _)| v_at(*s) >= 1.0))?;
        let t = (s / ray.length) as f32;
        let is_met = t > ray.t_min && t < t_max;
        let x = q + s * ray.dir - v * self.axis;
        is_met.then(|| {
            let hit = SegmentHit {
                t,
                u: angle(x, self.axis, DVec3::Z) as f32,
                v: v as f32,
            };
            (hit, ray.origin + s * ray.dir)
        })
    }

    /// The distance at which the ray enters the infinite cone.
    #[inline(always)]
    fn enter_cone(&self, q: DVec3, dir: DVec3) -> Option<f64> {
        if self.square <= 0.0 {
            return None;
        }
        // The cone is where the least power of a place with regard to the spheres along the axis is zero. The place is
        // taken relative to the point of the ray that is nearest to the first centre.
        let nearest = -q.dot(dir);
        let q = q + nearest * dir;
        let (d_axis, q_axis) = (dir.dot(self.axis), q.dot(self.axis) + self.radius * self.growth);
        let a = 1.0 - d_axis * d_axis / self.square;
        let b = -q_axis * d_axis / self.square;
        let c = q.length_squared() - self.radius * self.radius - q_axis * q_axis / self.square;
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return None;
        }
        // The root at which the ray goes inwards, without cancellation.
        let root = discriminant.sqrt();
        let s = if b > 0.0 { -(b + root) / a } else { c / (root - b) };
        s.is_finite().then_some(nearest + s)
    }

    /// The unit normal where `ray` meets the hull at `t`, which belongs to the sphere at `v`.
    fn normal(&self, ray: &Ray, t: f32, v: f32) -> DVec3 {
        let place = ray.origin.as_dvec3() + f64::from(t) * ray.dir.as_dvec3();
        let x = place - self.a - f64::from(v) * self.axis;
        x.try_normalize().unwrap_or(DVec3::Z)
    }

    /// The surface at a hit.
    pub fn surface(&self, ray: &Ray, t: f32, v: f32) -> LocalSurface {
        let normal = self.normal(ray, t, v);
        let radius = self.radius + f64::from(v) * self.growth;
        let position = (self.a + f64::from(v) * self.axis + radius * normal).as_vec3();
        LocalSurface {
            position,
            error: gamma(4) * position.abs() + Vec3::splat(gamma(4) * radius as f32),
            normal: normal.as_vec3(),
        }
    }

    /// The parametrisation at a hit, as [`super::curve::Spline::parametrisation`] has it. Caps have the tangents of the
    /// cone next to them.
    pub fn parametrisation(
        &self,
        (ray, t, v): (&Ray, f32, f32),
        [number, count]: [usize; 2],
        up: Vec3,
    ) -> Parametrisation {
        let normal = self.normal(ray, t, v);
        let radius = self.radius + f64::from(v) * self.growth;
        Parametrisation {
            uv: Vec2::new(
                angle(normal, self.axis, up.as_dvec3()) as f32,
                (number as f32 + v) / count as f32,
            ),
            dp_du: (TAU * radius * self.axis.normalize_or_zero().cross(normal)).as_vec3(),
            dp_dv: ((self.axis + self.growth * normal) * count as f64).as_vec3(),
        }
    }
}
