//! The G-buffer of a picture: the first surface at the centre of each pixel, without light and without noise (Saito and
//! Takahashi, Comprehensible Rendering of 3-D Shapes, SIGGRAPH 1990). It tells which pixels of two pictures show the
//! same surface point. Mirrors and glass show the surfaces seen in them, at their apparent distance.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Vec2, Vec3};

use super::borders::{Met, behind_borders};
use super::camera::Camera;
use super::scene::RenderScene;
use super::tile::Tile;
use super::view::View;
use crate::color::Rgb;
use crate::math::{Ray, offset_origin};
use crate::shading::TransportMode;

/// The most mirrors and glass surfaces that a ray follows.
const MOST_MIRRORS: u32 = 4;

/// The surface that a pixel shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texel {
    /// The length of the path from the camera through the pixel's centre, mirrors and glass included; infinite where
    /// nothing is hit.
    pub distance: f32,
    /// The shading normal in world space, in 127ths.
    normal: [i8; 3],
    /// Whether the surface is seen in a mirror or through glass.
    pub is_specular: bool,
    /// The square roots of the surface's albedo, in 255ths.
    albedo: [u8; 3],
}

impl Texel {
    /// A surface. `albedo` is in [0, 1], `normal` a unit vector.
    pub fn new(distance: f32, normal: Vec3, albedo: Rgb, is_specular: bool) -> Self {
        Self {
            distance,
            normal: normal.to_array().map(|x| (127.0 * x).round() as i8),
            is_specular,
            albedo: albedo.to_array().map(|x| (255.0 * x.max(0.0).sqrt()).round() as u8),
        }
    }

    /// The background, infinitely far away.
    pub fn nothing() -> Self {
        Self::new(f32::INFINITY, Vec3::ZERO, Rgb::ONE, false)
    }

    /// Whether a surface is hit.
    pub fn is_surface(&self) -> bool {
        self.distance.is_finite()
    }

    /// The unit normal in world space, rounded; zero for the background.
    pub fn normal(&self) -> Vec3 {
        Vec3::from(self.normal.map(f32::from)) * (1.0 / 127.0)
    }

    /// The colour of the surface in [0, 1]; white for lights and for the background.
    pub fn albedo(&self) -> Rgb {
        Rgb::from(self.albedo.map(|x| (f32::from(x) * (1.0 / 255.0)).powi(2)))
    }
}

/// The G-buffer of a tile.
#[derive(Clone, Debug, PartialEq)]
pub struct TileGBuffer {
    /// The tile.
    pub tile: Tile,
    /// The texels row by row.
    pub texels: Vec<Texel>,
    /// The number of rays that were traced.
    pub rays: u64,
}

/// The ray through the centre of a pixel of a picture of this size. `sharp` must be a pinhole camera.
pub fn middle_ray(sharp: &Camera, size: Vec2, x: u32, y: u32) -> Ray {
    sharp.ray((Vec2::new(x as f32, y as f32) + 0.5) / size, Vec2::splat(0.5))
}

/// The texels of `tile`; None if `cancel` was set in the meantime. Borders of media are ignored, and masks count as
/// opaque.
pub fn render_gbuffer(scene: &RenderScene, view: &View, tile: Tile, cancel: &AtomicBool) -> Option<TileGBuffer> {
    let sharp = view.camera.sharp();
    let size = Vec2::new(view.width as f32, view.height as f32);
    let mut result = TileGBuffer {
        tile,
        texels: Vec::with_capacity((tile.width * tile.height) as usize),
        rays: 0,
    };
    for y in tile.y..tile.y + tile.height {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        for x in tile.x..tile.x + tile.width {
            let ray = view.sight.narrow(&scene.geometry, middle_ray(&sharp, size, x, y));
            result.texels.push(texel(scene, ray, &mut result.rays));
        }
    }
    Some(result)
}

/// The surface along a ray. At a mirror or glass the ray follows the likelier direction.
fn texel(scene: &RenderScene, mut ray: Ray, rays: &mut u64) -> Texel {
    let (mut way, mut throughput) = (0.0, Rgb::ONE);
    for mirrors in 0..=MOST_MIRRORS {
        let is_specular = mirrors > 0;
        let (met, traced) = behind_borders(scene, &ray, None, |_, _| {});
        *rays += u64::from(traced);
        let Some(Met { hit, slot, point }) = met else {
            let nothing = Texel::nothing();
            return Texel { is_specular, ..nothing };
        };
        way += hit.t;
        let normal = point.shading_normal;
        if slot.light.is_some() {
            return Texel::new(way, normal, Rgb::ONE, is_specular);
        }
        let scattering = scene.scattering(slot.material, &hit, &point, -ray.dir, TransportMode::Radiance);
        let goes_on = !scattering.has_smooth_lobe() && mirrors < MOST_MIRRORS;
        let next = goes_on.then(|| scattering.sample(0.5, Vec2::splat(0.5))).flatten();
        let Some(next) = next else {
            let albedo = throughput * scattering.albedo();
            let albedo = if albedo.is_finite() { albedo } else { Rgb::ONE };
            return Texel::new(way, normal, albedo.clamp(Rgb::ZERO, Rgb::ONE), is_specular || goes_on);
        };
        throughput *= next.weight;
        ray = Ray::new(
            offset_origin(point.position, point.error, point.geometric_normal, next.wi),
            next.wi,
        );
    }
    Texel::nothing()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texel_keeps_what_it_is_made_of() {
        let normal = Vec3::new(0.6, -0.8, 0.0);
        let albedo = Rgb::new(0.0, 0.18, 1.0);
        let texel = Texel::new(3.25, normal, albedo, true);
        assert_eq!(texel.distance, 3.25);
        assert!(texel.is_specular && texel.normal().abs_diff_eq(normal, 0.005));
        assert!((texel.albedo() - albedo).abs().max_element() < 0.004);
        assert_eq!(Texel::nothing().albedo(), Rgb::ONE);
        assert!(Texel::nothing().distance.is_infinite());
    }
}
