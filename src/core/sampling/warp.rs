//! Maps from the unit square (or cube) to disks, spheres, triangles and cones that preserve area ratios, with their
//! densities.
//!
//! Directions are unit vectors in a local frame with z up. All maps are continuous almost everywhere, so that well
//! distributed numbers stay well distributed.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, TAU};

use glam::{Vec2, Vec3};

use crate::math::{Real, Vector, cube_root, sin_cos};

/// Uniform points on the unit disk, concentric squares going to concentric circles (Shirley and Chiu 1997).
#[inline(always)]
pub fn concentric_disk<R: Real>([u, v]: [R; 2]) -> [R; 2] {
    let (x, y) = (u + u - R::ONE, v + v - R::ONE);
    let is_wide = x.abs().is_more(y.abs());
    let radius = R::select(is_wide, x, y);
    let ratio = R::select(is_wide, y, x) / radius;
    let eighth = R::splat(FRAC_PI_4) * ratio;
    let angle = R::select(is_wide, eighth, R::splat(FRAC_PI_2) - eighth);
    let (sin, cos) = sin_cos(angle);
    // At the centre it is 0 / 0.
    let is_off_centre = !radius.equals(R::ZERO);
    [(radius * cos).only(is_off_centre), (radius * sin).only(is_off_centre)]
}

/// Directions on the upper hemisphere with density proportional to their cosine; see [`cosine_hemisphere_pdf`].
#[inline(always)]
pub fn cosine_hemisphere<R: Real>(u: [R; 2]) -> R::Vec3 {
    let [x, y] = concentric_disk(u);
    let z = (-x).mul_add(x, (-y).mul_add(y, R::ONE));
    R::Vec3::of(x, y, z.max(R::ZERO).sqrt())
}

/// Solid angle density of [`cosine_hemisphere`]; zero below the horizon.
#[inline(always)]
pub fn cosine_hemisphere_pdf<R: Real>(cos_theta: R) -> R {
    cos_theta.max(R::ZERO) * R::splat(FRAC_1_PI)
}

/// Uniform directions; the density is [`UNIFORM_SPHERE_PDF`].
#[inline(always)]
pub fn uniform_sphere<R: Real>([u, v]: [R; 2]) -> R::Vec3 {
    let z = R::ONE - (u + u);
    // (1 - z)(1 + z) without cancellation near the poles.
    let radius = (R::splat(4.0) * u * (R::ONE - u)).sqrt();
    let (sin, cos) = sin_cos(R::splat(TAU) * v);
    R::Vec3::of(radius * cos, radius * sin, z)
}

/// The direction at the height `z`, rotated about the z axis by the fraction `turn` of a full turn.
#[inline(always)]
pub(crate) fn at_height<R: Real>([turn, z]: [R; 2]) -> R::Vec3 {
    let (sin, cos) = sin_cos(R::splat(TAU) * turn);
    let radius = ((R::ONE - z) * (R::ONE + z)).max(R::ZERO).sqrt();
    R::Vec3::of(radius * cos, radius * sin, z)
}

/// Solid angle density of [`uniform_sphere`].
pub const UNIFORM_SPHERE_PDF: f32 = 0.5 * UNIFORM_HEMISPHERE_PDF;

/// Uniform directions with z >= 0; the density is [`UNIFORM_HEMISPHERE_PDF`].
pub fn uniform_hemisphere(u: [f32; 2]) -> Vec3 {
    uniform_cone(u, 1.0)
}

/// Solid angle density of [`uniform_hemisphere`].
pub const UNIFORM_HEMISPHERE_PDF: f32 = 1.0 / TAU;

/// Uniform directions within the cone around z whose half angle has cosine `1 - one_minus_cos`, in (0, 2].
///
/// The argument is 1 - cos because the cosine of narrow cones has lost it; from the sine s of a half angle below 90
/// degrees it is s^2 / (1 + sqrt(1 - s^2)). The density is [`uniform_cone_pdf`].
#[inline(always)]
pub fn uniform_cone<R: Real>(u: [R; 2], one_minus_cos: R) -> R::Vec3 {
    let [x, y] = concentric_disk(u);
    let depth = x.mul_add(x, y * y) * one_minus_cos;
    let stretch = (one_minus_cos * (R::splat(2.0) - depth).max(R::ZERO)).sqrt();
    R::Vec3::of(x * stretch, y * stretch, R::ONE - depth)
}

/// Solid angle density of [`uniform_cone`] inside the cone.
#[inline(always)]
pub fn uniform_cone_pdf<R: Real>(one_minus_cos: R) -> R {
    R::ONE / (R::splat(TAU) * one_minus_cos)
}

/// Uniform points in the unit ball, from three numbers; the density is 3 / (4 pi).
#[inline(always)]
pub fn unit_ball<R: Real>(u: [R; 2], u_radius: R) -> R::Vec3 {
    uniform_sphere(u) * cube_root(u_radius)
}

/// Uniform points on a triangle as barycentric weights (of the second and the third vertex; the first has the rest), by
/// the folding map of Heitz (A Low-Distortion Map Between Triangle and Square, 2019). The density is one over the area.
pub fn uniform_triangle(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let half = 0.5 * u.x;
        Vec2::new(half, u.y - half)
    } else {
        let half = 0.5 * u.y;
        Vec2::new(u.x - half, half)
    }
}
