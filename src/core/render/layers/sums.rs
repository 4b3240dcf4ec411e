//! The per-pixel sums from which layers are computed.

use std::ops::Range;

use glam::Vec2;

use super::cryptomatte::Matte;
use super::notes::LayerNotes;
use super::{Layer, Layer as L, Layers};
use crate::color::Rgb;
use crate::render::lanes::Job;
use crate::render::path::PathSample;
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::shading::TransportMode;

/// The layers of a film beside the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FilmLayers {
    /// The number of light groups with separate layers.
    pub groups: usize,
    /// The layers.
    pub layers: Layers,
    /// Whether light paths may splat light onto any pixel.
    pub splats: bool,
}

/// A sum over the samples of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::render) enum Sum {
    /// The number of samples that meet a surface.
    Covered,
    Albedo,
    Normal,
    GeometricNormal,
    Depth,
    Position,
    Uv,
    Motion,
    Direct,
    Indirect,
    Emitted,
}

/// All sums, each with the number of its components and the layers that need it.
const SUMS: [(Sum, usize, Layers); 11] = [
    (
        Sum::Covered,
        1,
        Layers::of(&[
            L::Alpha,
            L::Normal,
            L::GeometricNormal,
            L::CameraNormal,
            L::CameraGeometricNormal,
            L::Depth,
            L::Position,
            L::Uv,
        ]),
    ),
    (Sum::Albedo, 3, Layers::of(&[L::Albedo])),
    (Sum::Normal, 3, Layers::of(&[L::Normal, L::CameraNormal])),
    (
        Sum::GeometricNormal,
        3,
        Layers::of(&[L::GeometricNormal, L::CameraGeometricNormal]),
    ),
    (Sum::Depth, 1, Layers::of(&[L::Depth])),
    (Sum::Position, 3, Layers::of(&[L::Position])),
    (Sum::Uv, 2, Layers::of(&[L::Uv])),
    (Sum::Motion, 2, Layers::of(&[L::Motion])),
    (Sum::Direct, 3, Layers::of(&[L::Direct])),
    (Sum::Indirect, 3, Layers::of(&[L::Indirect])),
    (Sum::Emitted, 3, Layers::of(&[L::Emitted])),
];

/// The layers of cryptomattes.
const MATTES: [Layer; 2] = [Layer::CryptoObject, Layer::CryptoMaterial];

impl FilmLayers {
    /// Whether light is separated by its origin.
    pub fn parts_light(&self) -> bool {
        let parts = Layers::of(&[Layer::Direct, Layer::Indirect, Layer::Emitted]);
        self.groups > 0 || self.layers.has_any_of(parts)
    }

    /// The sums that are kept, with the numbers of their components.
    fn sums(self) -> impl Iterator<Item = (Sum, usize)> {
        let kept = SUMS.iter().filter(move |(.., layers)| self.layers.has_any_of(*layers));
        kept.map(|&(sum, components, _)| (sum, components))
    }

    /// The number of values stored for each pixel: red, green and blue of each light group, then the sums.
    pub(in crate::render) fn values(self) -> usize {
        3 * self.groups + self.sums().map(|(_, components)| components).sum::<usize>()
    }

    /// The range of a sum among the values of a pixel.
    pub(in crate::render) fn place(self, wanted: Sum) -> Option<Range<usize>> {
        let mut start = 3 * self.groups;
        for (sum, components) in self.sums() {
            if sum == wanted {
                return Some(start..start + components);
            }
            start += components;
        }
        None
    }

    /// The cryptomattes that are kept.
    fn mattes(self) -> impl Iterator<Item = Layer> {
        MATTES.into_iter().filter(move |&layer| self.layers.contains(layer))
    }

    /// The number of cryptomattes that are kept for each pixel.
    pub(in crate::render) fn matte_count(self) -> usize {
        self.mattes().count()
    }

    /// The index of a cryptomatte among those of a pixel.
    pub(in crate::render) fn matte_place(self, wanted: Layer) -> Option<usize> {
        self.mattes().position(|layer| layer == wanted)
    }

    /// Whether any layer needs notes along the paths.
    pub(in crate::render) fn are_noted(self) -> bool {
        self.values() > 0 || self.matte_count() > 0
    }

    /// The memory for a pixel in bytes, with that of a picture file in which it is saved.
    pub(in crate::render) fn pixel_bytes(self) -> usize {
        let saved: usize = self.layers.iter().map(channels).sum();
        self.sum_bytes() + size_of::<f32>() * (saved + 3 * self.groups)
    }

    /// The memory of the sums of a pixel in bytes.
    pub(in crate::render) fn sum_bytes(self) -> usize {
        size_of::<f32>() * self.values() + size_of::<Matte>() * self.matte_count()
    }
}

/// The number of channels of the layer in a picture file, without those of light groups.
fn channels(layer: Layer) -> usize {
    match layer {
        L::Alpha | L::Depth | L::ObjectId | L::MaterialId | L::Samples | L::Variance => 1,
        L::Uv | L::Motion => 2,
        L::LightGroups => 0,
        L::CryptoObject | L::CryptoMaterial => 12,
        _ => 3,
    }
}

/// The layers of some pixels as sums.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerSums {
    /// The values of each pixel, contiguous, as many as the [`FilmLayers`] have: the light of each group as red, green
    /// and blue, then the sums.
    pub values: Vec<f32>,
    /// The cryptomattes of each pixel, contiguous.
    pub mattes: Vec<Matte>,
}

impl LayerSums {
    /// Room for `pixels` pixels.
    pub(in crate::render) fn with_capacity(kept: FilmLayers, pixels: usize) -> Self {
        Self {
            values: Vec::with_capacity(pixels * kept.values()),
            mattes: Vec::with_capacity(pixels * kept.matte_count()),
        }
    }

    /// Resizes to `pixels` pixels. Old values stay.
    pub(in crate::render) fn resize(&mut self, kept: FilmLayers, pixels: usize) {
        self.values.resize(pixels * kept.values(), 0.0);
        self.mattes.resize(pixels * kept.matte_count(), Matte::default());
    }

    /// The values of the pixel with this index.
    pub(in crate::render) fn values_of(&self, kept: FilmLayers, pixel: usize) -> &[f32] {
        let count = kept.values();
        &self.values[pixel * count..][..count]
    }

    /// The light of each group, from the values of a pixel.
    pub(in crate::render) fn groups(values: &[f32], kept: FilmLayers) -> impl Iterator<Item = Rgb> {
        values[..3 * kept.groups].chunks_exact(3).map(Rgb::from_slice)
    }

    /// Adds further samples of the same pixels.
    pub(in crate::render) fn append(&mut self, next: &Self) {
        let values = self.values.iter_mut().zip(&next.values);
        values.for_each(|(sum, new)| *sum += new);
        let mattes = self.mattes.iter_mut().zip(&next.mattes);
        mattes.for_each(|(sum, new)| sum.merge(new));
    }

    /// Adds to the pixels from `first` on those of `new` from `from` on, one for each of `counts`: the numbers of
    /// samples that are in the sums so far.
    pub(in crate::render) fn add(&mut self, kept: FilmLayers, first: usize, new: &Self, from: usize, counts: &[u32]) {
        let (values, mattes) = (kept.values(), kept.matte_count());
        if values > 0 {
            let sums = self.values[first * values..].chunks_exact_mut(values);
            for ((sums, new), &samples) in sums.zip(new.values[from * values..].chunks_exact(values)).zip(counts) {
                match samples {
                    0 => sums.copy_from_slice(new),
                    _ => sums.iter_mut().zip(new).for_each(|(sum, new)| *sum += new),
                }
            }
        }
        if mattes > 0 {
            let sums = self.mattes[first * mattes..].chunks_exact_mut(mattes);
            for ((sums, new), &samples) in sums.zip(new.mattes[from * mattes..].chunks_exact(mattes)).zip(counts) {
                match samples {
                    0 => sums.copy_from_slice(new),
                    _ => sums.iter_mut().zip(new).for_each(|(sum, new)| sum.merge(new)),
                }
            }
        }
    }
}

/// Sums up the layers of one pixel after the other.
pub(in crate::render) struct PixelLayers<'a> {
    scene: &'a RenderScene,
    view: &'a View,
    kept: FilmLayers,
    /// Whether the surface of each sample has to be looked up.
    has_surfaces: bool,
    pub sums: LayerSums,
}

impl<'a> PixelLayers<'a> {
    /// Room for the layers of `pixels` pixels.
    pub fn new(scene: &'a RenderScene, view: &'a View, pixels: usize) -> Self {
        let kept = view.film_layers();
        let of_others = [
            Sum::Covered,
            Sum::Depth,
            Sum::Motion,
            Sum::Direct,
            Sum::Indirect,
            Sum::Emitted,
        ];
        Self {
            scene,
            view,
            kept,
            has_surfaces: kept.sums().any(|(sum, _)| !of_others.contains(&sum)),
            sums: LayerSums::with_capacity(kept, pixels),
        }
    }

    /// Goes on to the next pixel.
    pub fn begin_pixel(&mut self) {
        let (values, mattes) = (&mut self.sums.values, &mut self.sums.mattes);
        values.resize(values.len() + self.kept.values(), 0.0);
        mattes.resize(mattes.len() + self.kept.matte_count(), Matte::default());
    }

    /// Adds the sample of `job`, whose light has the weight `weight`, from its notes.
    pub fn add(&mut self, job: Job, sample: &PathSample, weight: f32, notes: &LayerNotes, number: usize) {
        let (noted, groups) = notes.get(number);
        let start = self.sums.values.len() - self.kept.values();
        let values = &mut self.sums.values[start..];
        let (of_groups, mut rest) = values.split_at_mut(3 * self.kept.groups);
        for (sum, light) in of_groups
            .iter_mut()
            .zip(groups.iter().flat_map(|light| light.to_array()))
        {
            *sum += light * weight;
        }
        let surface = match &noted.surface {
            Some((ray, hit)) if self.has_surfaces => Some(self.scene.geometry.surface(ray, hit)),
            _ => None,
        };
        for (sum, components) in self.kept.sums() {
            let value = match sum {
                Sum::Direct => noted.light[1] * weight,
                Sum::Indirect => noted.light[2] * weight,
                Sum::Emitted => noted.light[0] * weight,
                Sum::Covered => Rgb::splat(f32::from(u8::from(noted.surface.is_some()))),
                Sum::Depth if noted.surface.is_some() => Rgb::splat(sample.depth + noted.beyond),
                Sum::Normal => surface.map_or(Rgb::ZERO, |surface| surface.shading_normal),
                Sum::GeometricNormal => surface.map_or(Rgb::ZERO, |surface| surface.geometric_normal),
                Sum::Position => surface.map_or(Rgb::ZERO, |surface| surface.position),
                Sum::Motion => self.view.before.as_ref().map_or(Rgb::ZERO, |before| {
                    let (geometry, camera) = (&self.scene.geometry, &self.view.camera);
                    let motion = match &noted.surface {
                        Some((ray, hit)) => before.motion(geometry, camera, ray, Some(hit)),
                        None => {
                            let ray = self.view.camera_sample(job.pixel, job.index).ray;
                            before.motion(geometry, camera, &ray, None)
                        }
                    };
                    (motion * Vec2::new(self.view.width as f32, self.view.height as f32)).extend(0.0)
                }),
                Sum::Uv => surface.map_or(Rgb::ZERO, |surface| surface.uv.extend(0.0)),
                Sum::Albedo => match (&noted.surface, &surface) {
                    (Some((ray, hit)), Some(point)) => {
                        let material = self.scene.slot(hit).material;
                        let mode = TransportMode::Radiance;
                        self.scene.scattering(material, hit, point, -ray.dir, mode).albedo()
                    }
                    _ => Rgb::ZERO,
                },
                Sum::Depth => Rgb::ZERO,
            };
            let (now, others) = rest.split_at_mut(components);
            if value.is_finite() {
                now.iter_mut()
                    .zip(value.to_array())
                    .for_each(|(sum, value)| *sum += value);
            }
            rest = others;
        }
        let Some((_, hit)) = &noted.surface else {
            return;
        };
        let start = self.sums.mattes.len() - self.kept.matte_count();
        for (layer, matte) in self.kept.mattes().zip(&mut self.sums.mattes[start..]) {
            matte.add(match layer {
                Layer::CryptoObject => hit.instance,
                _ => self.scene.slot(hit).material.0,
            });
        }
    }
}
