//! The earlier picture that is carried over.

use glam::{UVec2, Vec2};

use super::{CarriedTile, Light, tile_and_place};
use crate::render::camera::Camera;
use crate::render::gbuffer::{Texel, middle_ray};

/// An earlier picture as it was shown, with the G-buffer that locates its light.
#[derive(Debug)]
pub struct Earlier {
    /// The camera as a pinhole.
    pub(super) camera: Camera,
    /// The size in pixels.
    pub(super) size: UVec2,
    tiles: Vec<CarriedTile>,
    /// The distance between the rays of neighbouring pixels at their origins, and its growth per unit of distance.
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

    /// The texel of a pixel, and its light.
    pub(super) fn at(&self, pixel: UVec2) -> (&Texel, &Light) {
        let (tile, place) = tile_and_place(self.size, pixel);
        let tile = &self.tiles[tile];
        (&tile.texels[place], &tile.shown[place])
    }

    /// The pixel that contains a point of the film; the nearest one for points outside.
    pub(super) fn pixel_at(&self, film: Vec2) -> UVec2 {
        let pixel = (film * self.size.as_vec2()).clamp(Vec2::ZERO, self.size.as_vec2() - 1.0);
        pixel.as_uvec2()
    }

    /// The distance between the surface points of neighbouring pixels, on a surface at `distance` seen head-on.
    pub(super) fn spacing(&self, distance: f32) -> f32 {
        self.spacing[0] + self.spacing[1] * distance
    }
}
