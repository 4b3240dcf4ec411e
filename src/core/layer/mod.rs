//! Layers: the outputs of a picture beside its colours, for compositing, denoising and checking (AOVs, arbitrary output
//! variables). This module defines their meanings and names; `render::layers` computes them.
//!
//! Layers of surfaces describe the first surface that does not let the camera ray pass straight on: surfaces behind the
//! holes of a mask count, and each sample of a pixel decides anew. All layers but cryptomattes and ids are plain means
//! over the samples that the reconstruction filter has assigned to a pixel; the negative weights of some filters apply
//! to light alone.

mod names;

pub use self::names::{UnknownLayer, layer_names};

/// A layer of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// The share of the samples that meet a surface, in [0, 1]: the opacity of the foreground, which is 0 where the
    /// camera sees the sky or nothing. It is the channel `A` of the picture; all colours but the sky's are
    /// premultiplied by it.
    Alpha,
    /// The albedo of the surface in [0, 1], linear Rec. 709: the mean over all samples, of which those without a
    /// surface count as black.
    Albedo,
    /// The shading normal in world space, as interpolated from vertices and without bumps: the mean of the unit vectors
    /// of the samples that meet a surface, shorter than 1 where they differ. Zero without a surface.
    Normal,
    /// The geometric normal in world space, as [`Self::Normal`].
    GeometricNormal,
    /// [`Self::Normal`] in camera space: x to the left of the picture, y up, z into the scene.
    CameraNormal,
    /// [`Self::GeometricNormal`] in camera space, as [`Self::CameraNormal`].
    CameraGeometricNormal,
    /// The distance from the origin of the camera ray to the surface in world units: the mean over the samples that
    /// meet one, or 0 without any. It is measured along the ray, not along the axis of the camera.
    Depth,
    /// The position on the surface in world space: the mean over the samples that meet one, or 0 without any.
    Position,
    /// The surface's texture coordinates: the mean over the samples that meet one, or 0 without any.
    Uv,
    /// The motion in pixels, to the right and down, from the surface's position in the previous frame to that in this
    /// one: the mean over all samples. The sky moves with the camera's rotation. Zero in a picture that is not a frame
    /// of a sequence.
    Motion,
    /// A whole number for each shape: its index in the scene, counted from 1, or 0 where the ray hits nothing. It is
    /// that of the pixel's first sample, without any filter, and of the first surface even where that has a hole.
    ObjectId,
    /// A whole number for each material, counted from 1, as [`Self::ObjectId`].
    MaterialId,
    /// The number of samples of the pixel.
    Samples,
    /// The estimated variance of the pixel's luminance, which is the square of its standard error; 0 below two samples.
    Variance,
    /// The light that one surface has scattered between a light and the camera, linear Rec. 709. Surfaces that let
    /// light pass straight on do not count. Direct, indirect and emitted light sum up to the picture.
    Direct,
    /// The light that two or more surfaces have scattered.
    Indirect,
    /// The light that reaches the camera unscattered: visible lamps and the sky.
    Emitted,
    /// The light of each lamp or emitter of the scene, in a layer of its own; if there are more than sixteen, the rest
    /// share the last. They sum up to the picture.
    LightGroups,
    /// The denoised picture, if a denoiser is installed.
    Denoised,
    /// The albedo for the denoiser, in [0, 1]: that of the first surface that is not perfectly specular, tinted by the
    /// surfaces in front of it.
    DenoiserAlbedo,
    /// The world normal for the denoiser, of the same surface.
    DenoiserNormal,
    /// The cryptomatte of objects: the shapes in a pixel, each with its coverage.
    CryptoObject,
    /// The cryptomatte of materials.
    CryptoMaterial,
}

/// A set of layers.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Layers(u32);

impl Layer {
    /// All layers, in the order in which they are listed and written.
    pub const ALL: [Self; 23] = [
        Self::Alpha,
        Self::Albedo,
        Self::Normal,
        Self::GeometricNormal,
        Self::CameraNormal,
        Self::CameraGeometricNormal,
        Self::Depth,
        Self::Position,
        Self::Uv,
        Self::Motion,
        Self::ObjectId,
        Self::MaterialId,
        Self::Samples,
        Self::Variance,
        Self::Direct,
        Self::Indirect,
        Self::Emitted,
        Self::LightGroups,
        Self::Denoised,
        Self::DenoiserAlbedo,
        Self::DenoiserNormal,
        Self::CryptoObject,
        Self::CryptoMaterial,
    ];

    const fn bit(self) -> u32 {
        1 << self as u32
    }
}

impl Layers {
    /// The set of these layers.
    pub const fn of(layers: &[Layer]) -> Self {
        let (mut bits, mut place) = (0, 0);
        while place < layers.len() {
            bits |= layers[place].bit();
            place += 1;
        }
        Self(bits)
    }

    /// Whether the layer is in the set.
    pub const fn contains(self, layer: Layer) -> bool {
        self.0 & layer.bit() != 0
    }

    /// Whether a layer is in both sets.
    pub const fn has_any_of(self, others: Self) -> bool {
        self.0 & others.0 != 0
    }

    /// Whether the set is empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The layers of either set.
    #[must_use]
    pub const fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// The layers that are in this set and not in the other.
    #[must_use]
    pub const fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// The layers in the order of [`Layer::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Layer> {
        Layer::ALL.into_iter().filter(move |&layer| self.contains(layer))
    }
}

impl FromIterator<Layer> for Layers {
    fn from_iter<T: IntoIterator<Item = Layer>>(layers: T) -> Self {
        Self(layers.into_iter().fold(0, |bits, layer| bits | layer.bit()))
    }
}

impl std::fmt::Debug for Layers {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_set().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_hold_what_was_put_in() {
        let all: Layers = Layer::ALL.into_iter().collect();
        assert_eq!(all.iter().collect::<Vec<_>>(), Layer::ALL);
        let some = Layers::of(&[Layer::Uv, Layer::Albedo]);
        assert_eq!(some.iter().collect::<Vec<_>>(), [Layer::Albedo, Layer::Uv]);
        assert!(some.contains(Layer::Uv) && !some.contains(Layer::Depth) && !some.is_empty());
        assert_eq!(
            some.and(Layers::of(&[Layer::Depth])).without(some),
            Layers::of(&[Layer::Depth])
        );
        assert!(!some.has_any_of(all.without(some)) && Layers::default().is_empty());
    }
}
