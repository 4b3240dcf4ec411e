//! Computes the layers of a film from its sums.

use glam::{Vec2, Vec3};

use super::cryptomatte::Matte;
use super::sums::Sum;
use super::{FilmLayers, Layer};
use crate::color::Rgb;
use crate::render::camera::Camera;
use crate::render::film::Film;

/// A layer, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub enum LayerPixels {
    /// Colours, linear Rec. 709.
    Colors(Vec<Rgb>),
    /// Vectors or points.
    Vectors(Vec<Vec3>),
    /// Texture coordinates, or motion in the picture.
    Pairs(Vec<Vec2>),
    /// Numbers.
    Numbers(Vec<f32>),
    /// Whole numbers.
    Ids(Vec<u32>),
}

impl Film {
    /// A layer; pixels without samples are zero. None if the film does not keep it, and for layers that are not one
    /// value per pixel: light groups (see [`Self::light_group`]), cryptomattes (see [`Self::mattes`]) and the denoised
    /// picture. `camera` is the view's.
    pub fn layer(&self, layer: Layer, camera: &Camera) -> Option<LayerPixels> {
        let (kept, samples) = (self.layers(), |x, y| self.samples(x, y));
        let is_kept = kept.layers.contains(layer);
        let surface = |sum| self.surface_means(kept, sum);
        Some(match layer {
            _ if !is_kept => return None,
            Layer::Alpha => LayerPixels::Numbers(self.sample_means(kept, Sum::Covered)?.map(|value| value.x).collect()),
            Layer::Albedo => LayerPixels::Colors(self.sample_means(kept, Sum::Albedo)?.collect()),
            Layer::Normal => LayerPixels::Vectors(surface(Sum::Normal)?.collect()),
            Layer::GeometricNormal => LayerPixels::Vectors(surface(Sum::GeometricNormal)?.collect()),
            Layer::CameraNormal => LayerPixels::Vectors(in_camera(surface(Sum::Normal)?, camera)),
            Layer::CameraGeometricNormal => LayerPixels::Vectors(in_camera(surface(Sum::GeometricNormal)?, camera)),
            Layer::Depth => LayerPixels::Numbers(surface(Sum::Depth)?.map(|value| value.x).collect()),
            Layer::Position => LayerPixels::Vectors(surface(Sum::Position)?.collect()),
            Layer::Uv => LayerPixels::Pairs(surface(Sum::Uv)?.map(Vec3::truncate).collect()),
            Layer::Motion => {
                let motion = self.sample_means(kept, Sum::Motion)?;
                LayerPixels::Pairs(motion.map(Vec3::truncate).collect())
            }
            Layer::Direct => LayerPixels::Colors(self.sample_means(kept, Sum::Direct)?.collect()),
            Layer::Indirect => LayerPixels::Colors(self.sample_means(kept, Sum::Indirect)?.collect()),
            Layer::Emitted => LayerPixels::Colors(self.sample_means(kept, Sum::Emitted)?.collect()),
            Layer::ObjectId => LayerPixels::Ids(self.ids(|hit| hit.instance)),
            Layer::MaterialId => LayerPixels::Ids(self.ids(|hit| hit.material.0)),
            Layer::Samples => LayerPixels::Numbers(self.each_pixel(|x, y| samples(x, y) as f32).collect()),
            Layer::Variance => {
                let variance = |x, y| self.standard_error(x, y).map_or(0.0, |error| error * error);
                LayerPixels::Numbers(self.each_pixel(variance).collect())
            }
            Layer::DenoiserAlbedo => LayerPixels::Colors(self.albedo()),
            Layer::DenoiserNormal => LayerPixels::Vectors(self.normal()),
            Layer::LightGroups | Layer::Denoised | Layer::CryptoObject | Layer::CryptoMaterial => return None,
        })
    }

    /// The light of a group; None if the film does not keep it.
    pub fn light_group(&self, group: usize) -> Option<Vec<Rgb>> {
        let place = 3 * group..3 * group + 3;
        (group < self.layers().groups).then(|| self.each_pixel(|x, y| self.mean_at(x, y, place.clone())).collect())
    }

    /// The ids in each pixel with its number of samples, for a cryptomatte that the film keeps.
    pub fn mattes(&self, layer: Layer) -> Option<Vec<(Matte, u32)>> {
        let place = self.layers().matte_place(layer)?;
        let of_pixel = |x, y| (self.matte(x, y, place), self.samples(x, y));
        Some(self.each_pixel(of_pixel).collect())
    }

    fn each_pixel<'a, T: 'a>(&'a self, of: impl Fn(u32, u32) -> T + 'a) -> impl Iterator<Item = T> + 'a {
        (0..self.height() * self.width()).map(move |place| of(place % self.width(), place / self.width()))
    }

    /// A sum over the samples of each pixel, divided by their number.
    fn sample_means(&self, kept: FilmLayers, sum: Sum) -> Option<impl Iterator<Item = Vec3>> {
        let place = kept.place(sum)?;
        Some(self.each_pixel(move |x, y| self.mean_at(x, y, place.clone())))
    }

    /// A sum over the samples of each pixel, divided by the number of samples that meet a surface.
    fn surface_means(&self, kept: FilmLayers, sum: Sum) -> Option<impl Iterator<Item = Vec3>> {
        let (place, covered) = (kept.place(sum)?, kept.place(Sum::Covered)?.start);
        Some(self.each_pixel(move |x, y| match self.layer_sums(x, y) {
            Some(values) if values[covered] > 0.0 => vector(&values[place.clone()]) / values[covered],
            _ => Vec3::ZERO,
        }))
    }

    fn mean_at(&self, x: u32, y: u32, place: std::ops::Range<usize>) -> Vec3 {
        let sums = self.layer_sums(x, y);
        sums.map_or(Vec3::ZERO, |values| vector(&values[place]) / self.samples(x, y) as f32)
    }

    fn ids(&self, of: impl Fn(super::super::scene::FirstHit) -> u32) -> Vec<u32> {
        let id = |x, y| match self.samples(x, y) {
            0 => 0,
            _ => self.first_hit(x, y).map_or(0, |hit| of(hit) + 1),
        };
        self.each_pixel(id).collect()
    }
}

/// A vector of up to three components; the others are zero.
fn vector(components: &[f32]) -> Vec3 {
    let of = |place: usize| components.get(place).copied().unwrap_or(0.0);
    Vec3::new(of(0), of(1), of(2))
}

fn in_camera(normals: impl Iterator<Item = Vec3>, camera: &Camera) -> Vec<Vec3> {
    normals.map(|normal| camera.direction_in_camera(normal)).collect()
}
