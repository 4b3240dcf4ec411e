//! The positions of a new picture's pixels in an earlier one.

use std::sync::Arc;

use glam::{UVec2, Vec2, Vec3};

use super::{CarriedTile, Light, middle, tile_and_place};
use crate::math::Ray;
use crate::render::camera::Camera;
use crate::render::gbuffer::{Texel, middle_ray};

/// The edge in pixels of the blocks whose displacement is guessed as a whole.
const GUESSED: u32 = 8;
/// The number of iterations after which a guess no longer improves.
const ROUNDS: u32 = 4;
/// The share of its worth that light keeps at a guessed pixel.
const GUESS: f32 = 0.25;
/// The share of its worth that light keeps when it is interpolated between pixels, and its largest worth then, because
/// interpolation blurs it.
const MOVED: f32 = 0.9;
const MOST_MOVED: f32 = 256.0;
/// The largest worth where pixels around it show another surface, and thus a part of its light.
const EDGE: f32 = 32.0;
/// The largest worth of light in mirrors and glass when the camera has moved: only in plane ones does the reflection
/// move as if it were at its apparent position.
const SPECULAR: f32 = 64.0;
/// The factor on the tolerance of distances for surfaces seen in mirrors and glass.
const SPECULAR_SLACK: f32 = 4.0;
/// The least cosine between the normals of a point in two views.
const SAME_NORMAL: f32 = 0.9;
/// The largest relative difference of distances to the same point, beyond that due to the size of pixels.
const SAME_DISTANCE: f32 = 0.004;
/// The least share of the four pixels around a point that has to show its surface.
const LEAST_SHARE: f32 = 0.05;

/// The map from a new picture's pixels to an earlier picture.
#[derive(Debug)]
pub struct Reprojection {
    earlier: Arc<Earlier>,
    camera: Camera,
    size: UVec2,
    /// Whether the camera has not moved since the earlier picture.
    is_still: bool,
    /// The guessed displacement on the film of each block of pixels, row by row; empty if the camera has not moved.
    displacements: Vec<Vec2>,
}

impl Reprojection {
    /// The reprojection from an earlier picture to one of this size in pixels by `camera`, which must be a pinhole.
    pub(super) fn new(earlier: Arc<Earlier>, camera: Camera, size: UVec2) -> Self {
        let mut reprojection = Self {
            is_still: earlier.camera == camera,
            earlier,
            camera,
            size,
            displacements: Vec::new(),
        };
        if !reprojection.is_still {
            let middles = |edge: u32| {
                (0..edge)
                    .step_by(GUESSED as usize)
                    .map(move |at| at.midpoint((at + GUESSED).min(edge)))
            };
            let rows = middles(size.y).flat_map(|y| middles(size.x).map(move |x| (x, y)));
            reprojection.displacements = rows.map(|(x, y)| reprojection.guessed_displacement(x, y)).collect();
        }
        reprojection
    }

    /// The earlier picture.
    pub(super) fn earlier(&self) -> Arc<Earlier> {
        self.earlier.clone()
    }

    /// Whether each pixel has the same position in the earlier picture.
    fn is_identity(&self) -> bool {
        self.is_still && self.size == self.earlier.size
    }

    /// The texel and the light of a pixel, as far as they can be guessed without tracing rays.
    pub(super) fn guess(&self, x: u32, y: u32) -> (Texel, Light) {
        if self.is_identity() {
            let (&texel, &light) = self.earlier.at(UVec2::new(x, y));
            return (texel, light);
        }
        let block = y / GUESSED * self.size.x.div_ceil(GUESSED) + x / GUESSED;
        let displacement = self.displacements.get(block as usize).copied().unwrap_or(Vec2::ZERO);
        let film = middle(self.size, x, y) + displacement;
        let (&texel, &light) = self.earlier.at(self.earlier.pixel_at(film));
        let is_inside = film.cmpge(Vec2::ZERO).all() && film.cmple(Vec2::ONE).all();
        let share = match self.is_still {
            true => 1.0,
            false if is_inside => GUESS,
            false => 0.0,
        };
        let worth = light.worth * share;
        (texel, Light { worth, ..light })
    }

    /// The displacement of a pixel to the earlier picture, on the film: a point on its ray at the distance of the
    /// earlier surface is projected to the earlier camera, repeatedly until the surface there agrees.
    fn guessed_displacement(&self, x: u32, y: u32) -> Vec2 {
        let ray = middle_ray(&self.camera, self.size.as_vec2(), x, y);
        let own = middle(self.size, x, y);
        let mut film = own;
        for _ in 0..ROUNDS {
            let seen = self.earlier.pixel_at(film);
            let (texel, _) = self.earlier.at(seen);
            let distance = match texel.is_surface() {
                true => self.place_of_earlier(seen, texel.distance).distance(ray.origin),
                false => texel.distance,
            };
            match self.seen_before(&ray, distance) {
                Some((before, _)) => film = before,
                None => break,
            }
        }
        film - own
    }

    fn place_of_earlier(&self, pixel: UVec2, distance: f32) -> Vec3 {
        let ray = middle_ray(&self.earlier.camera, self.earlier.size.as_vec2(), pixel.x, pixel.y);
        ray.origin + ray.dir * distance
    }

    /// The film coordinates in the earlier picture of the point at this distance along a ray, and its distance there.
    /// None behind the camera.
    fn seen_before(&self, ray: &Ray, distance: f32) -> Option<(Vec2, f32)> {
        match distance.is_finite() {
            true => {
                let before = (self.earlier.camera).ray_to(ray.origin + ray.dir * distance, Vec2::splat(0.5))?;
                Some((before.film, before.distance))
            }
            false => Some((self.earlier.camera.project_direction(ray.dir)?, distance)),
        }
    }

    /// The light of a pixel that shows `texel`.
    pub(super) fn find(&self, x: u32, y: u32, texel: &Texel) -> Light {
        if self.is_identity() {
            let (before, &light) = self.earlier.at(UVec2::new(x, y));
            if before == texel {
                return light;
            }
        }
        let ray = middle_ray(&self.camera, self.size.as_vec2(), x, y);
        let before = match self.is_still {
            true => Some((middle(self.size, x, y), texel.distance)),
            false => self.seen_before(&ray, texel.distance),
        };
        let Some((film, distance)) = before else {
            return Light::default();
        };
        let facing = texel.normal().dot(ray.dir).abs().max(0.05);
        let slack = SAME_DISTANCE * distance + 1.5 * self.earlier.spacing(distance) / facing;
        let slack = if texel.is_specular {
            SPECULAR_SLACK * slack
        } else {
            slack
        };
        let is_same = |before: &Texel| {
            before.is_specular == texel.is_specular
                && match distance.is_finite() {
                    true => {
                        (before.distance - distance).abs() <= slack
                            && before.normal().dot(texel.normal()) >= SAME_NORMAL
                    }
                    false => before.distance.is_infinite(),
                }
        };
        let mut light = self.between(film, is_same);
        if !self.is_still && texel.is_specular {
            light.worth = light.worth.min(SPECULAR);
        }
        light
    }

    /// The light interpolated between the four pixels around a point of the film, over those that show the same
    /// surface; no light far outside of the film.
    pub(super) fn between(&self, film: Vec2, is_same: impl Fn(&Texel) -> bool) -> Light {
        let size = self.earlier.size.as_ivec2();
        let place = film * self.earlier.size.as_vec2() - 0.5;
        // NaN fails as well.
        if !(place.cmpge(Vec2::NEG_ONE).all() && place.cmple(self.earlier.size.as_vec2()).all()) {
            return Light::default();
        }
        let corner = place.floor();
        let share = place - corner;
        // A point at the very centre of a pixel gets that pixel's light unchanged.
        let is_whole = share.cmplt(Vec2::splat(1e-3)).all() || share.cmpgt(Vec2::splat(1.0 - 1e-3)).all();
        let (mut sum, mut weights) = (Light::default(), 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (x, y) = (corner.x as i32 + dx, corner.y as i32 + dy);
            if x < 0 || y < 0 || x >= size.x || y >= size.y {
                continue;
            }
            let part = |share: f32, step: i32| if step == 0 { 1.0 - share } else { share };
            let weight = part(share.x, dx) * part(share.y, dy);
            let (texel, light) = self.earlier.at(UVec2::new(x as u32, y as u32));
            if weight > 0.0 && is_same(texel) {
                sum.light += light.light * weight;
                sum.worth += light.worth * weight;
                sum.variance += light.variance * weight;
                weights += weight;
            }
        }
        if weights < LEAST_SHARE {
            return Light::default();
        }
        let worth = sum.worth / weights;
        let worth = match is_whole {
            true => worth,
            false if weights < 0.999 => (MOVED * worth).min(EDGE),
            false => (MOVED * worth).min(MOST_MOVED),
        };
        Light {
            light: sum.light / weights,
            worth,
            variance: sum.variance / weights,
        }
    }
}

/// A picture as it was shown, with what tells where its light belongs.
#[derive(Debug)]
pub struct Earlier {
    /// The camera, with everything in focus.
    pub(super) camera: Camera,
    /// Pixels.
    pub(super) size: UVec2,
    tiles: Vec<CarriedTile>,
    /// How far the rays of neighbouring pixels are apart at their origins, and how much they part on the way.
    spacing: [f32; 2],
}

impl Earlier {
    /// `tiles` are those of a picture of this size in pixels, in the order of [`crate::render::tile::tiles`].
    pub(super) fn new(camera: Camera, size: UVec2, tiles: Vec<CarriedTile>) -> Self {
        let ray = |x| middle_ray(&camera, size.as_vec2(), x, size.y / 2);
        let (one, other) = (ray(size.x / 2), ray(size.x / 2 + 1));
        Self {
            camera,
            size,
            tiles,
            spacing: [
                one.origin.distance(other.origin),
                one.dir.normalize().distance(other.dir.normalize()),
            ],
        }
    }

    /// What a pixel shows, and its light.
    pub(super) fn at(&self, pixel: UVec2) -> (&Texel, &Light) {
        let (tile, place) = tile_and_place(self.size, pixel);
        let tile = &self.tiles[tile];
        (&tile.texels[place], &tile.shown[place])
    }

    /// The pixel around a place of the film; the nearest one for places outside.
    pub(super) fn pixel_at(&self, film: Vec2) -> UVec2 {
        let pixel = (film * self.size.as_vec2()).clamp(Vec2::ZERO, self.size.as_vec2() - 1.0);
        pixel.as_uvec2()
    }

    /// The distance between what neighbouring pixels show of a surface at this distance that is seen from the front.
    pub(super) fn spacing(&self, distance: f32) -> f32 {
        self.spacing[0] + self.spacing[1] * distance
    }
}
