//! Maps from the unit square (or cube) to disks, spheres, triangles and cones that preserve area ratios, with their densities.
//!
//! Directions are unit vectors in a local frame with z up. All maps are continuous almost everywhere, so that well spread numbers stay
//! well spread.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, TAU};

/// Uniform points on the unit disk, concentric squares going to concentric circles (Shirley and Chiu 1997).
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - Vec2::ONE;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    let (sin, cos) = angle.sin_cos();
    radius * Vec2::new(cos, sin)
}

/// Directions on the upper hemisphere with density proportional to their cosine; see [`cosine_hemisphere_pdf`].
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let disk = concentric_disk(u);
    disk.extend((1.0 - disk.length_squared()).max(0.0).sqrt())
}

/// Solid angle density of [`cosine_hemisphere`]; zero below the horizon.
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// Uniform directions; the density is [`UNIFORM_SPHERE_PDF`].
pub fn uniform_sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    // (1 - z)(1 + z) without cancellation near the poles.
    let radius = (4.0 * u.x * (1.0 - u.x)).sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Solid angle density of [`uniform_sphere`].
pub const UNIFORM_SPHERE_PDF: f32 = 0.5 * UNIFORM_HEMISPHERE_PDF;

/// Uniform directions with z >= 0; the density is [`UNIFORM_HEMISPHERE_PDF`].
pub fn uniform_hemisphere(u: Vec2) -> Vec3 {
    uniform_cone(u, 1.0)
}

/// Solid angle density of [`uniform_hemisphere`].
pub const UNIFORM_HEMISPHERE_PDF: f32 = 1.0 / TAU;

/// Uniform directions within the cone around z whose half angle has cosine `1 - one_minus_cos`, in (0, 2].
///
/// It takes 1 - cos because narrow cones have lost it in the cosine; from the sine s of a half angle below 90 degrees it is
/// s^2 / (1 + sqrt(1 - s^2)). The density is [`uniform_cone_pdf`].
pub fn uniform_cone(u: Vec2, one_minus_cos: f32) -> Vec3 {
    let disk = concentric_disk(u);
    let depth = disk.length_squared() * one_minus_cos;
    (disk * (one_minus_cos * (2.0 - depth).max(0.0)).sqrt()).extend(1.0 - depth)
}

/// Solid angle density of [`uniform_cone`] inside the cone.
pub fn uniform_cone_pdf(one_minus_cos: f32) -> f32 {
    1.0 / (TAU * one_minus_cos)
}

/// Uniform points in the unit ball, from three numbers; the density is 3 / (4 pi).
pub fn unit_ball(u: Vec2, u_radius: f32) -> Vec3 {
    u_radius.cbrt() * uniform_sphere(u)
}

/// Uniform points on a triangle as barycentric weights (of the second and the third vertex; the first has the rest), by the folding
/// map of Heitz (A Low-Distortion Map Between Triangle and Square, 2019). The density is one over the area.
pub fn uniform_triangle(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let half = 0.5 * u.x;
        Vec2::new(half, u.y - half)
    } else {
        let half = 0.5 * u.y;
        Vec2::new(u.x - half, half)
    }
}
