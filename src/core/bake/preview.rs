//! Previews a level as a game shows it, lit by its lightmaps alone: each pixel is the albedo of the first surface times
//! the irradiance of its texels over pi, plus its emission. A surface without lightmap shows what it transmits or
//! mirrors: glass is passed straight on, and metals are smooth mirrors. All other surfaces without one, such as moving
//! objects, are black.
//!
//! A ray through the centre of each pixel finds the surface. A second one finds the same point on the surfaces with
//! texels, which are triangles even for spheres, so that the two may differ by some texels. The light may change while
//! the view stays: only [`SeenPixels::lit`] is done again.

use std::collections::HashMap;
use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;

use super::finish::LightmapPicture;
use super::lightmap::Lightmaps;
use super::texels::{BakeSurface, Texels};
use crate::accel::{Blas, Detail, SplitMethod};
use crate::color::Rgb;
use crate::geometry::mesh::MeshData;
use crate::light::SurfaceHit;
use crate::math::{Ray, offset_origin};
use crate::memory::{self, Reservation, Shortage};
use crate::render::borders::{Met, behind_borders};
use crate::render::camera::Camera;
use crate::render::scene::RenderScene;
use crate::render::visibility::sight::Sight;
use crate::shading::TransportMode;

/// How far, in texels, the triangles of a lightmap may be from the visible surface.
const REACH: f32 = 3.0;
/// The same for rounding errors, as a share of the distance from the camera.
const ROUNDING: f32 = 1e-4;
/// The index that stands for no texel.
const NONE: u32 = u32::MAX;
/// Bytes per texel, covered or not.
const TEXEL_BYTES: u64 = size_of::<u32>() as u64;
/// Bytes per pixel, with its colour in two pictures, of which one is made while the other is shown.
const PIXEL_BYTES: u64 = (size_of::<Seen>() + 2 * size_of::<Rgb>()) as u64;
/// The most surfaces that a view is transmitted through or mirrored in.
const MOST_TURNS: usize = 8;
/// The square of the largest sine of the angle between directions that count as equal.
const STRAIGHT: f32 = 1e-8;
/// The most emitters in front of each other that are hidden from a camera.
const MOST_HIDDEN: usize = 256;
/// Bytes per triangle, with its corners and its share of the BVH.
const TRIANGLE_BYTES: u64 = 320;

/// Surfaces with lightmaps.
struct Layer {
    triangles: Blas,
    /// The lightmap of each triangle.
    pages: Vec<u32>,
    /// The positions of the corners of each triangle in its lightmap, in texels.
    coordinates: Vec<[Vec2; 3]>,
}

/// The surfaces with lightmaps, with an acceleration structure.
pub struct BakedSurfaces {
    /// Triangles at the same place that face opposite sides are in different layers.
    layers: Vec<Layer>,
    /// For each lightmap the index of the texel at each column and row.
    texels: Vec<Vec<u32>>,
    size: UVec2,
    /// The length of a texel in the world.
    texel: f32,
    _memory: Reservation,
}

/// The surface that is visible in a pixel.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// The radiance that does not depend on the lightmaps.
    own: Rgb,
    albedo: Rgb,
    /// The lightmap, or [`NONE`], and the position in it in texels.
    page: u32,
    at: Vec2,
}

/// The pixels of a view.
pub struct SeenPixels {
    /// Width and height.
    pub size: UVec2,
    pixels: Vec<Seen>,
    _memory: Reservation,
}

/// The lightmaps that light a view.
#[derive(Clone, Copy)]
pub enum LitBy<'a> {
    /// The light gathered so far.
    Gathered(&'a Lightmaps),
    /// The finished pictures.
    Finished(&'a [LightmapPicture]),
}

impl BakedSurfaces {
    /// Prepares surfaces with `texels_per_unit`. An error if the memory budget has no room.
    pub fn new<S>(surfaces: &[BakeSurface], texels: &Texels<S>, texels_per_unit: f32) -> Result<Self, Shortage> {
        let size = texels.size;
        let page_texels = size.x as usize * size.y as usize;
        let count: usize = surfaces.iter().map(|surface| surface.triangles.len()).sum();
        let bytes = TEXEL_BYTES * (page_texels * texels.pages.len()) as u64 + TRIANGLE_BYTES * count as u64;
        let memory = memory::reserve(bytes)?;
        let mut numbers = vec![vec![NONE; page_texels]; texels.pages.len()];
        for (page, range) in numbers.iter_mut().zip(&texels.pages) {
            for texel in range.clone() {
                let place = texels.texels[texel].place;
                page[(place.y * size.x + place.x) as usize] = texel as u32;
            }
        }
        Ok(Self {
            layers: layers(surfaces),
            texels: numbers,
            size,
            texel: 1.0 / texels_per_unit.max(f32::MIN_POSITIVE),
            _memory: memory,
        })
    }

    /// The surface that `camera` sees in each pixel; skies are black and emissive shapes are passed if
    /// `hides_emitters`. An error if the memory budget has no room.
    pub fn see(
        &self,
        scene: &RenderScene,
        camera: &Camera,
        size: UVec2,
        sight: &Sight,
        hides_emitters: bool,
    ) -> Result<SeenPixels, Shortage> {
        let memory = memory::reserve(PIXEL_BYTES * u64::from(size.x) * u64::from(size.y))?;
        let camera = camera.sharp();
        let pixel = |index: u32| {
            let place = UVec2::new(index % size.x, index / size.x).as_vec2() + 0.5;
            let ray = camera.ray(place / size.as_vec2(), Vec2::splat(0.5));
            let ray = sight.narrow(&scene.geometry, ray);
            match hides_emitters {
                true => self.see_along(scene, behind_emitters(scene, ray), true),
                false => self.see_along(scene, ray, false),
            }
        };
        Ok(SeenPixels {
            size,
            pixels: (0..size.x * size.y).into_par_iter().map(pixel).collect(),
            _memory: memory,
        })
    }

    /// The surface along a camera ray, which passes emissive shapes if `hides_emitters`.
    fn see_along(&self, scene: &RenderScene, mut ray: Ray, hides_emitters: bool) -> Seen {
        let mut seen = Seen {
            own: Rgb::ZERO,
            albedo: Rgb::ZERO,
            page: NONE,
            at: Vec2::ZERO,
        };
        // The throughput of the path so far.
        let mut share = Rgb::ONE;
        for turn in 0..=MOST_TURNS {
            let sees_emitters = turn > 0 || !hides_emitters;
            let (met, _) = behind_borders(scene, &ray, None, |_, _| {});
            let Some(Met { hit, slot, point }) = met else {
                if sees_emitters {
                    let sky = scene.lights.infinite().iter();
                    let sky: Rgb = sky.map(|light| scene.lights.radiance_from(*light, ray.dir)).sum();
                    seen.own += share * sky;
                }
                break;
            };
            if let Some(light) = slot.light.filter(|_| sees_emitters) {
                let on_light = SurfaceHit::at(&hit, &point);
                seen.own += share * scene.lights.emitted(light, &on_light, -ray.dir);
            }
            let scattering = scene.scattering(slot.material, &hit, &point, -ray.dir, TransportMode::Radiance);
            let is_open = scattering.null_share() > 0.5;
            if let Some((page, at)) = self.place(&ray, hit.t).filter(|_| !is_open) {
                seen.albedo = share * scattering.albedo().clamp(Rgb::ZERO, Rgb::ONE);
                (seen.page, seen.at) = (page, at);
                break;
            }
            let Some((dir, of_light)) = scattering.onward() else {
                break;
            };
            share *= of_light;
            let is_straight =
                dir.dot(ray.dir) > 0.0 && dir.cross(ray.dir).length_squared() < STRAIGHT * ray.dir.length_squared();
            ray = Ray {
                // If the path ends here, so does its straight continuation.
                t_max: if is_straight { ray.t_max - hit.t } else { f32::INFINITY },
                ..Ray::new(
                    offset_origin(point.position, point.error, point.geometric_normal, dir),
                    dir,
                )
            };
        }
        seen
    }

    /// The lightmap, and the position in it, of the surface that the ray meets at about `t`.
    fn place(&self, ray: &Ray, t: f32) -> Option<(u32, Vec2)> {
        let reach = REACH * self.texel + ROUNDING * t;
        let mut nearest: Option<(f32, u32, Vec2)> = None;
        for layer in &self.layers {
            let mut part = Ray {
                t_min: (t - reach).max(ray.t_min),
                t_max: t + reach,
                ..*ray
            };
            // A wall has two sides, which may both be found.
            for _ in 0..4 {
                let Some(hit) = layer.triangles.intersect(&part) else {
                    break;
                };
                let triangle = hit.triangle as usize;
                let [a, b, c] = layer.triangles.mesh().corners(triangle);
                let off = (hit.t - t).abs();
                let is_front = (b - a).cross(c - a).dot(ray.dir) < 0.0;
                if is_front && nearest.is_none_or(|(best, ..)| off < best) {
                    let [a, b, c] = layer.coordinates[triangle];
                    let at = a + hit.u * (b - a) + hit.v * (c - a);
                    nearest = Some((off, layer.pages[triangle], at));
                }
                part.t_min = hit.t + (ROUNDING * t).max(1e-3 * self.texel);
            }
        }
        nearest.map(|(_, page, at)| (page, at))
    }

    /// The irradiance at a position in a lightmap, filtered between the four nearest texels.
    fn irradiance(&self, light: LitBy, page: u32, at: Vec2) -> Rgb {
        let low = (at - 0.5).floor();
        let share = at - 0.5 - low;
        let (mut sum, mut weights) = (Rgb::ZERO, 0.0);
        for corner in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE] {
            let place = low + corner;
            let weight = (1.0 - (share - corner).abs()).element_product();
            if place.min_element() < 0.0 || place.x >= self.size.x as f32 || place.y >= self.size.y as f32 {
                continue;
            }
            let index = place.y as usize * self.size.x as usize + place.x as usize;
            let value = match light {
                LitBy::Finished(pages) => Some(pages[page as usize].irradiance[index]),
                LitBy::Gathered(light) => match self.texels[page as usize][index] {
                    NONE => None,
                    texel => (!light.is_buried(texel as usize)).then(|| light.light(texel as usize)),
                },
            };
            if let Some(value) = value {
                sum += weight * value;
                weights += weight;
            }
        }
        sum / f32::max(weights, f32::MIN_POSITIVE)
    }
}

/// The camera ray continued behind the emissive shapes that are hidden from the camera.
fn behind_emitters(scene: &RenderScene, mut ray: Ray) -> Ray {
    for _ in 0..MOST_HIDDEN {
        let hit = scene.geometry.intersect(&ray);
        let Some(hit) = hit.filter(|hit| scene.slot(hit).light.is_some()) else {
            break;
        };
        let point = scene.geometry.surface_in(&ray, &hit, Detail::Plain);
        let origin = offset_origin(point.position, point.error, point.geometric_normal, ray.dir);
        ray = Ray {
            t_max: ray.t_max - hit.t,
            ..Ray::new(origin, ray.dir)
        };
    }
    ray
}

impl SeenPixels {
    /// The radiance of each pixel, row by row from the top, linear Rec. 709.
    pub fn lit(&self, surfaces: &BakedSurfaces, light: LitBy) -> Vec<Rgb> {
        let pixel = |seen: &Seen| match seen.page {
            NONE => seen.own,
            page => seen.own + seen.albedo * FRAC_1_PI * surfaces.irradiance(light, page, seen.at),
        };
        self.pixels.par_iter().map(pixel).collect()
    }
}

fn layers(surfaces: &[BakeSurface]) -> Vec<Layer> {
    /// The sorted corners of a triangle, a key that is the same for both of its sides.
    fn key(corners: [Vec3; 3]) -> [[u32; 3]; 3] {
        let mut key = corners.map(|corner| corner.to_array().map(|number| (number + 0.0).to_bits()));
        key.sort_unstable();
        key
    }
    let mut known: HashMap<[[u32; 3]; 3], usize> = HashMap::new();
    let mut parts: Vec<(MeshData, Vec<u32>, Vec<[Vec2; 3]>)> = Vec::new();
    for surface in surfaces {
        for corners in &surface.triangles {
            let positions = corners.map(|corner| surface.positions[corner as usize]);
            let layer = known.entry(key(positions)).and_modify(|layer| *layer += 1).or_insert(0);
            if parts.len() <= *layer {
                parts.push(Default::default());
            }
            let (mesh, pages, coordinates) = &mut parts[*layer];
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(positions);
            mesh.triangles.push([first, first + 1, first + 2]);
            pages.push(surface.page);
            coordinates.push(corners.map(|corner| surface.coordinates[corner as usize]));
        }
    }
    let layer = |(mesh, pages, coordinates)| Layer {
        triangles: Blas::build(Arc::new(mesh), SplitMethod::default()),
        pages,
        coordinates,
    };
    parts.into_iter().map(layer).collect()
}
