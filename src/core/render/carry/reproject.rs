//! Where the pixels of a new picture were in an earlier one.

use std::sync::Arc;

use glam::{UVec2, Vec2, Vec3};

use super::earlier::Earlier;
use super::{Light, middle};
use crate::math::Ray;
use crate::render::camera::Camera;
use crate::render::gbuffer::{Texel, middle_ray};

/// The edge of the blocks whose place is guessed as a whole, in pixels.
const GUESSED: u32 = 8;
/// The rounds after which a guess is as good as it gets.
const ROUNDS: u32 = 4;
/// The share of its worth that light keeps for a guessed pixel.
const GUESS: f32 = 0.25;
/// The share of its worth that light keeps when it is interpolated between pixels, and what it is worth at most then,
/// because that blurs it.
const MOVED: f32 = 0.9;
const MOST_MOVED: f32 = 256.0;
/// What it is worth at most where pixels around it show something else, and with it a part of their light.
const EDGE: f32 = 32.0;
/// What light in mirrors and glass is worth at most when the camera has moved: only what plane ones show has moved as
/// if it were where it seems to be.
const SPECULAR: f32 = 64.0;
/// How many times as far off things in mirrors and glass may be.
const SPECULAR_SLACK: f32 = 4.0;
/// The least cosine between the normals of two views of one place.
const SAME_NORMAL: f32 = 0.9;
/// Distances to the same place differ by no more than this share, beside what follows from the size of pixels.
const SAME_DISTANCE: f32 = 0.004;
/// The least share of the four pixels around a place that has to show it.
const LEAST_SHARE: f32 = 0.05;

/// The way from an earlier picture to a new one.
#[derive(Debug)]
pub struct Reprojection {
    earlier: Arc<Earlier>,
    camera: Camera,
    size: UVec2,
    /// Whether the camera is that of the earlier picture.
    is_still: bool,
    /// How far blocks of pixels were from their places on the film, row by row, by a guess; empty if the camera is
    /// still.
    ways: Vec<Vec2>,
}

impl Reprojection {
    /// From an earlier picture to one of this size in pixels by `camera`, which has everything in focus.
    pub(super) fn new(earlier: Arc<Earlier>, camera: Camera, size: UVec2) -> Self {
        let mut reprojection = Self {
            is_still: earlier.camera == camera,
            earlier,
            camera,
            size,
            ways: Vec::new(),
        };
        if !reprojection.is_still {
            let middles = |edge: u32| {
                (0..edge)
                    .step_by(GUESSED as usize)
                    .map(move |at| at.midpoint((at + GUESSED).min(edge)))
            };
            let rows = middles(size.y).flat_map(|y| middles(size.x).map(move |x| (x, y)));
            reprojection.ways = rows.map(|(x, y)| reprojection.guessed_way(x, y)).collect();
        }
        reprojection
    }

    /// The earlier picture.
    pub(super) fn earlier(&self) -> Arc<Earlier> {
        self.earlier.clone()
    }

    /// Whether each pixel was at the same place in the earlier picture.
    fn is_identity(&self) -> bool {
        self.is_still && self.size == self.earlier.size
    }

    /// What a pixel shows and its light, as far as it can be told without tracing rays.
    pub(super) fn guess(&self, x: u32, y: u32) -> (Texel, Light) {
        if self.is_identity() {
            let (&texel, &light) = self.earlier.at(UVec2::new(x, y));
            return (texel, light);
        }
        let block = y / GUESSED * self.size.x.div_ceil(GUESSED) + x / GUESSED;
        let way = self.ways.get(block as usize).copied().unwrap_or(Vec2::ZERO);
        let film = middle(self.size, x, y) + way;
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

    /// How far a pixel was from its place on the film: what the earlier picture shows there is seen from the new place,
    /// as often as it takes to agree.
    fn guessed_way(&self, x: u32, y: u32) -> Vec2 {
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

    /// The film coordinates in the earlier picture of what lies at this distance along a ray, and its distance there.
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

    /// The light between the four pixels around a place of the film, of which those count that show the same; no light
    /// far outside of it.
    pub(super) fn between(&self, film: Vec2, is_same: impl Fn(&Texel) -> bool) -> Light {
        let size = self.earlier.size.as_ivec2();
        let place = film * self.earlier.size.as_vec2() - 0.5;
        // Numbers that are none, too.
        if !(place.cmpge(Vec2::NEG_ONE).all() && place.cmple(self.earlier.size.as_vec2()).all()) {
            return Light::default();
        }
        let corner = place.floor();
        let share = place - corner;
        // A pixel in the very middle is itself.
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
