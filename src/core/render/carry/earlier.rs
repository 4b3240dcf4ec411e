//! The picture that is carried over.

use glam::{UVec2, Vec2};

use super::{CarriedTile, Light, tile_and_place};
use crate::render::camera::Camera;
use crate::render::gbuffer::{Texel, middle_ray};

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
