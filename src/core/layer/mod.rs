//! Layers: the outputs of a picture beside its colours, for compositing, denoising and checking (AOVs, arbitrary output
//! variables). This module defines their meanings and names; `render::layers` computes them.
//!
//! Layers of surfaces describe the first surface that does not let the camera ray pass straight on: surfaces behind the
//! holes of a mask count, and each sample of a pixel decides anew. All layers but cryptomattes and ids are plain means
//! over the samples that the reconstruction filter has assigned to a pixel; the negative weights of some filters apply
//! to light alone.

mod names;

pub use self::names::{UnknownLayer, layer_names};

declare_names! {
    /// A layer of the picture.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Layer {
        /// The share of the samples that meet a surface, in [0, 1]: the opacity of what stands before the background,
        /// which is 0 where the camera sees the sky or nothing. It is the channel `A` of the picture; colours are
        /// premultiplied by it but for the light of the sky.
        Alpha = "alpha" => "Alpha",
        /// The albedo of the surface in [0, 1], linear Rec. 709: the mean over all samples, of which those without a
        /// surface count as black.
        Albedo = "albedo" => "Albedo",
        /// The shading normal in world space, as interpolated from vertices and without bumps: the mean of the unit
        /// vectors of the samples that meet a surface, shorter than 1 where they differ. Zero without a surface.
        Normal = "normal" => "Normal",
        /// The geometric normal in world space, as [`Self::Normal`].
        GeometricNormal = "geometric-normal" => "Geometric normal",
        /// [`Self::Normal`] in camera space: x to the left of the picture, y up, z into the scene.
        CameraNormal = "camera-normal" => "Normal seen from the camera",
        /// [`Self::GeometricNormal`] in camera space, as [`Self::CameraNormal`].
        CameraGeometricNormal = "camera-geometric-normal" => "Geometric normal seen from the camera",
        /// The distance from the origin of the camera ray to the surface in world units: the mean over the samples that
        /// meet one, or 0 without any. It is measured along the ray, not along the axis of the camera.
        Depth = "depth" => "Depth",
        /// The place on the surface in world space: the mean over the samples that meet one, or 0 without any.
        Position = "position" => "Position",
        /// The surface's texture coordinates: the mean over the samples that meet one, or 0 without any.
        Uv = "uv" => "Texture coordinates",
        /// The way in pixels, to the right and down, from where the surface was in the picture of the frame before to
        /// where it is now: the mean over all samples. The sky moves with the camera's turns. Zero in a picture that is
        /// no frame of a sequence.
        Motion = "motion" => "Motion since the frame before",
        /// A whole number for each shape: the place of the shape in the scene, counted from 1, or 0 where nothing is
        /// hit. It is that of the pixel's first sample, without any filter, and of the first surface even where it has
        /// a hole.
        ObjectId = "object-id" => "Object number",
        /// A whole number for each material, counted from 1, as [`Self::ObjectId`].
        MaterialId = "material-id" => "Material number",
        /// The number of samples of the pixel.
        Samples = "samples" => "Samples",
        /// The estimated variance of the pixel's luminance, which is the square of its standard error; 0 below two
        /// samples.
        Variance = "variance" => "Variance",
        /// The light that one surface has scattered on its way from a light to the camera, linear Rec. 709. Surfaces
        /// that let light pass straight on do not count. Direct, indirect and emitted light sum up to the picture.
        Direct = "direct" => "Direct light",
        /// The light that two surfaces or more have scattered.
        Indirect = "indirect" => "Indirect light",
        /// The light that comes to the camera without having been scattered: lamps and the sky that are seen.
        Emitted = "emitted" => "Emitted light",
        /// The light of each lamp or emitter of the scene, in a layer of its own; if there are very many, the
        /// last share one. They sum up to the picture.
        LightGroups = "light-groups" => "Light groups",
        /// The picture without noise, where a denoiser is there.
        Denoised = "denoised" => "Denoised",
        /// The albedo that the denoiser is given, in [0, 1]: that of the first surface that is not perfectly specular,
        /// tinted by what it is seen through.
        DenoiserAlbedo = "denoiser-albedo" => "Albedo for the denoiser",
        /// The world normal that the denoiser is given, of the same surface.
        DenoiserNormal = "denoiser-normal" => "Normal for the denoiser",
        /// The cryptomatte of objects: which shapes are in a pixel, and how much of it each covers.
        CryptoObject = "crypto-object" => "Cryptomatte of objects",
        /// The cryptomatte of materials.
        CryptoMaterial = "crypto-material" => "Cryptomatte of materials",
    }
}

/// A set of layers.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Layers(u32);

impl Layer {
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
