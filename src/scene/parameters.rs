//! The kinds of parameters that plugins have, and what values of those consist of.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use bevy::prelude::*;

use super::medium::{Coefficients, VolumeParameter};
use super::parameter_info::ParameterInfo;
use super::sensor::FovAxis;
use super::sun_position::SunPosition;
use super::texture::{ChosenPicture, Parameter, SquarePath, Texture};
use crate::color::Rgb;

/// Declares the kinds of parameters: a reference to the value, to be read or to be changed.
macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident($value:ty),)*) => {
        /// The value of a parameter, to be read.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) enum ParameterRef<'p> {
            $($(#[$doc])* $kind(&'p $value),)*
        }

        /// The value of a parameter, to be changed. What is left alone keeps its value, which in a fresh plugin is the format's default.
        #[derive(Debug, PartialEq)]
        pub(crate) enum ParameterMut<'p> {
            $($(#[$doc])* $kind(&'p mut $value),)*
        }
    };
}

kinds! {
    /// A share of the light by colour, 0 to 1.
    Reflectance(Parameter<Rgb>),
    /// A picture of normals, (normal + 1) / 2 in the shading frame.
    Normals(Parameter<Rgb>),
    Float(Parameter<f32>),
    /// A height in units of the scene: a texture, to which the format gives no name.
    Height(Parameter<f32>),
    /// A number that is the same everywhere.
    Number(f32),
    Flag(bool),
    /// A flag of ours, which no other program knows: off by default, and written only where it is on.
    Extension(bool),
    Ior(Ior),
    /// The index of a conductor: `material`, or `eta` and `k`.
    ConductorIor(ConductorIor),
    Distribution(Distribution),
    /// The roughness: `alpha`, or `alpha_u` and `alpha_v`.
    Roughness(Roughness),
    /// The roughness of a model that looks the same in all directions.
    UniformRoughness(Roughness),
    /// The index of a principled surface: `specular` or `eta`.
    PrincipledIndex(PrincipledIndex),
    /// The absorption: `eumelanin` and `pheomelanin`, or `sigma_a` and `scale`.
    Absorption(Absorption),
    /// Light that is sent out, by colour: not negative, without upper bound.
    Emission(Rgb),
    TexturedEmission(Parameter<Rgb>),
    /// A share of the light by colour, 0 to 1, the same everywhere.
    UniformReflectance(Rgb),
    /// A factor on light.
    Factor(f32),
    /// Degrees.
    Angle(f32),
    Integer(i32),
    /// The absolute path of a picture's file.
    Picture(PathBuf),
    OptionalTexture(Option<Texture>),
    /// The cone of a spot: `cutoff_angle` and `beam_width`.
    Cone(Cone),
    /// The field of view: `fov` and `fov_axis`.
    FieldOfView(FieldOfView),
    /// The position of the sun: `sun_direction`, or place and time.
    SunPosition(SunPosition),
    /// The sampling weight, which is written only if it is not 1.
    SamplingWeight(f32),
    /// A factor of ours, which no other program knows: 1 by default, and written only where it is not.
    ExtensionFactor(f32),
    /// The coefficients of a medium: `sigma_t` and `albedo`, or `sigma_s` and `sigma_a`.
    Coefficients(Coefficients),
    /// Light that is sent out in space, by colour: an extension, which is written only where there is some.
    VolumeEmission(VolumeParameter<Rgb>),
    /// A share from 0 to 1 that may vary in space.
    VolumeShare(VolumeParameter<f32>),
    /// A list of numbers that are not negative.
    Values(Vec<f32>),
}

impl ParameterMut<'_> {
    /// Puts the picture at a place of the value if that has the name `parameter` in the file. Where there was no texture before, a
    /// picture of anything but colours is looked at raw.
    pub(crate) fn set_picture(self, info: &ParameterInfo, parameter: &str, place: SquarePath, picture: &ChosenPicture) {
        let is = |info: &ParameterInfo| info.name == parameter;
        match self {
            Self::Reflectance(color) if is(info) => set_picture(color, place, picture, false),
            Self::Normals(normals) if is(info) => set_picture(normals, place, picture, true),
            Self::Float(number) | Self::Height(number) if is(info) => set_picture(number, place, picture, true),
            Self::ConductorIor(ConductorIor::Given { eta, .. }) if is(&ETA) => set_picture(eta, place, picture, true),
            Self::ConductorIor(ConductorIor::Given { k, .. }) if is(&K) => set_picture(k, place, picture, true),
            Self::Absorption(Absorption::Given { sigma_a, .. }) if is(&SIGMA_A) => {
                set_picture(sigma_a, place, picture, true)
            }
            Self::Roughness(roughness) | Self::UniformRoughness(roughness) => match roughness {
                Roughness::Isotropic(alpha) if is(&ALPHA) => set_picture(alpha, place, picture, true),
                Roughness::Anisotropic { u, .. } if is(&ALPHA_U) => set_picture(u, place, picture, true),
                Roughness::Anisotropic { v, .. } if is(&ALPHA_V) => set_picture(v, place, picture, true),
                _ => {}
            },
            _ => {}
        }
    }
}

impl ParameterMut<'_> {
    /// Shows `meet` every texture of the value, with the declaration that it has in the file.
    pub(crate) fn for_each_texture(
        self,
        info: &'static ParameterInfo,
        meet: &mut impl FnMut(&'static ParameterInfo, &mut Texture),
    ) {
        match self {
            Self::Reflectance(value) | Self::Normals(value) | Self::TexturedEmission(value) => {
                show_texture(info, value, meet);
            }
            Self::Float(value) | Self::Height(value) => show_texture(info, value, meet),
            Self::ConductorIor(ConductorIor::Given { eta, k }) => {
                show_texture(&ETA, eta, meet);
                show_texture(&K, k, meet);
            }
            Self::Absorption(Absorption::Given { sigma_a, .. }) => show_texture(&SIGMA_A, sigma_a, meet),
            Self::Roughness(roughness) | Self::UniformRoughness(roughness) => match roughness {
                Roughness::Isotropic(alpha) => show_texture(&ALPHA, alpha, meet),
                Roughness::Anisotropic { u, v } => {
                    show_texture(&ALPHA_U, u, meet);
                    show_texture(&ALPHA_V, v, meet);
                }
            },
            Self::OptionalTexture(Some(texture)) => meet(info, texture),
            _ => {}
        }
    }
}

fn show_texture<T>(
    info: &'static ParameterInfo,
    value: &mut Parameter<T>,
    meet: &mut impl FnMut(&'static ParameterInfo, &mut Texture),
) {
    if let Parameter::Texture(texture) = value {
        meet(info, texture);
    }
}

fn set_picture<T>(value: &mut Parameter<T>, place: SquarePath, picture: &ChosenPicture, raw: bool) {
    let was_plain = matches!(value, Parameter::Constant(_));
    value.set_picture_at(place, picture.clone());
    if let Parameter::Texture(Texture::Bitmap(bitmap)) = value
        && was_plain
    {
        bitmap.raw = raw;
    }
}

/// The name of a bump map's texture where the file gives none.
pub(crate) const HEIGHT: &str = "height";

/// The largest index of refraction or extinction; the highest measured ones in the visible range are below 10.
const HIGHEST_INDEX: f32 = 100.0;

/// The indices of refraction of dielectrics.
pub(crate) const INDICES: RangeInclusive<f32> = 0.01..=HIGHEST_INDEX;

/// The indices of refraction that sliders offer.
pub(crate) const OFFERED_INDICES: RangeInclusive<f32> = 1.0..=3.0;

/// The roughness that sliders offer: at zero there would be no rough surface.
const OFFERED_ROUGHNESS: RangeInclusive<f32> = 0.001..=1.0;

/// The largest absorption coefficient of a hair, factor on it, and concentration of a pigment: blacker than any.
const MOST_ABSORPTION: f32 = 1e6;

pub(crate) const MATERIAL: ParameterInfo = ParameterInfo::new(
    "material",
    "Metal",
    "A metal by its chemical name, with indices as they were measured; or eta and k as numbers.",
    "a name of the list",
);

pub(crate) const ETA: ParameterInfo = ParameterInfo::new(
    "eta",
    "Eta",
    "Real part of the metal's index of refraction, by colour.",
    "0 to 100 per channel, or a texture",
)
.within(0.0..=HIGHEST_INDEX);

pub(crate) const K: ParameterInfo = ParameterInfo::new(
    "k",
    "K",
    "Extinction: imaginary part of the metal's index of refraction, by colour. It is what makes a metal opaque.",
    "0 to 100 per channel, or a texture",
)
.within(0.0..=HIGHEST_INDEX);

pub(crate) const ALPHA: ParameterInfo = ParameterInfo::new(
    "alpha",
    "Roughness",
    "Spread of the slopes of tiny facets: the root of their mean square. Small is shiny.",
    "0.0001 to 1 and beyond, or a texture; 0.001 to 0.01 polished, 0.1 to 0.3 satin, 0.5 matt",
)
.within(1e-4..=100.0)
.offering(OFFERED_ROUGHNESS)
.usually(0.1);

pub(crate) const ALPHA_U: ParameterInfo = ParameterInfo::new(
    "alpha_u",
    "Roughness u",
    "Spread of the facets' slopes along the first tangent, in which u grows: apart from the other it looks brushed.",
    "0.0001 to 1 and beyond, or a texture",
)
.within(1e-4..=100.0)
.offering(OFFERED_ROUGHNESS)
.usually(0.1);

pub(crate) const ALPHA_V: ParameterInfo = ParameterInfo::new(
    "alpha_v",
    "Roughness v",
    "Spread of the facets' slopes along the second tangent, in which v grows.",
    "0.0001 to 1 and beyond, or a texture",
)
.within(1e-4..=100.0)
.offering(OFFERED_ROUGHNESS)
.usually(0.1);

pub(crate) const SPECULAR: ParameterInfo = ParameterInfo::new(
    "specular",
    "Specular",
    "How strongly a surface that is no metal mirrors head on: the reflectance there over 0.08.",
    "0 to 1; 0.5 is an index of refraction of 1.5",
)
.within(0.0..=1.0)
.usually(0.5);

pub(crate) const PRINCIPLED_ETA: ParameterInfo = ParameterInfo::new(
    "eta",
    "Index",
    "Index of refraction inside over outside: how strongly the surface mirrors and, where it is glass, how far it bends light.",
    "0.01 to 100; plastic and glass have 1.5, water 1.33",
).within(INDICES).offering(OFFERED_INDICES).usually(1.5);

pub(crate) const EUMELANIN: ParameterInfo = ParameterInfo::new(
    "eumelanin",
    "Eumelanin",
    "How much there is of the pigment that makes hair brown and black.",
    "0 or more; 0.3 blond, 1.3 brown, 8 black",
)
.within(0.0..=MOST_ABSORPTION)
.usually(1.3);

pub(crate) const PHEOMELANIN: ParameterInfo = ParameterInfo::new(
    "pheomelanin",
    "Pheomelanin",
    "How much there is of the pigment that makes hair red.",
    "0 or more; 0.2 is common, 1 is red",
)
.within(0.0..=MOST_ABSORPTION)
.usually(0.2);

pub(crate) const SIGMA_A: ParameterInfo = ParameterInfo::new(
    "sigma_a",
    "Absorption",
    "How much light a fibre absorbs, by colour: the share exp(-1) is left after a way of its radius through an absorption of 1.",
    "0 or more per channel, or a texture",
).within(0.0..=MOST_ABSORPTION);

pub(crate) const ABSORPTION_SCALE: ParameterInfo =
    ParameterInfo::new("scale", "Scale", "Factor on the absorption.", "0 or more")
        .within(0.0..=MOST_ABSORPTION)
        .usually(1.0);

/// The complex index of refraction of a conductor, per colour channel.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum ConductorIor {
    /// A name such as `Au`, `Cu`; `none` is a perfect mirror.
    Named(String),
    /// The optical constants as numbers or textures.
    Given {
        /// The real part of the refractive index relative to the outside, not negative.
        eta: Parameter<Rgb>,
        /// The imaginary part of it (extinction), not negative.
        k: Parameter<Rgb>,
    },
}

/// Index of refraction of a dielectric.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Ior {
    /// A name such as `water`, `bk7`.
    Named(String),
    /// A number above 0; 1 is that of vacuum.
    Number(f32),
}

/// The distribution of the normals of a rough surface's facets.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Gaussian slopes.
    Beckmann,
    /// Slopes with longer tails (Walter et al. 2007).
    Ggx,
}

impl Distribution {
    /// The name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Beckmann => "beckmann",
            Self::Ggx => "ggx",
        }
    }

    /// The distribution of this name; None if there is none.
    pub fn of_name(name: &str) -> Option<Self> {
        [Self::Beckmann, Self::Ggx]
            .into_iter()
            .find(|known| known.name() == name)
    }
}

/// Width of the distribution of slopes (not its square root), above 0.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Roughness {
    /// The same in all directions of the surface.
    Isotropic(Parameter<f32>),
    /// The roughness along each of the two tangents.
    Anisotropic {
        /// The roughness along the direction in which u grows.
        u: Parameter<f32>,
        /// The roughness along the direction in which v grows.
        v: Parameter<f32>,
    },
}

impl Default for Roughness {
    fn default() -> Self {
        Self::Isotropic(ALPHA.usual.into())
    }
}

/// The reflectance of a principled surface at normal incidence.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum PrincipledIndex {
    /// The reflectance over 0.08, in [0, 1].
    Specular(f32),
    /// Refractive index inside over outside, above 0.
    Eta(f32),
}

impl Default for PrincipledIndex {
    fn default() -> Self {
        Self::Specular(SPECULAR.usual)
    }
}

/// The absorption of light inside a hair.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Absorption {
    /// The absorption follows from pigments.
    Melanin {
        /// The concentration of the pigment that makes hair brown and black, at least 0.
        eumelanin: f32,
        /// The concentration of the pigment that makes hair red, at least 0.
        pheomelanin: f32,
    },
    /// The absorption is given by its coefficient.
    Given {
        /// The coefficient per radius, at least 0.
        sigma_a: Parameter<Rgb>,
        /// A factor on it, at least 0.
        scale: f32,
    },
}

impl Default for Absorption {
    /// The format's brown.
    fn default() -> Self {
        Self::Melanin {
            eumelanin: EUMELANIN.usual,
            pheomelanin: PHEOMELANIN.usual,
        }
    }
}

/// The angles of a cone from its axis in degrees.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// The angle beyond which there is no light.
    pub cutoff_angle: f32,
    /// The angle within which there is all of the light.
    pub beam_width: f32,
}

/// The angle across a picture.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct FieldOfView {
    /// Degrees.
    pub fov: f32,
    /// The extent of the picture along which it is measured.
    pub axis: FovAxis,
}

pub(crate) const CUTOFF_ANGLE: ParameterInfo = ParameterInfo::degrees(
    "cutoff_angle",
    "Cutoff",
    "Angle from the axis beyond which there is no light.",
    "degrees, above 0 and up to 90",
)
.within(0.01..=180.0)
.offering(0.1..=90.0);

pub(crate) const BEAM_WIDTH: ParameterInfo = ParameterInfo::degrees(
    "beam_width",
    "Beam",
    "Angle from the axis within which the light has all of its strength; from there to the cutoff it fades.",
    "degrees, 0 up to the cutoff",
);

pub(crate) const FOV: ParameterInfo = ParameterInfo::degrees(
    "fov",
    "Field of view",
    "Angle across the picture.",
    "degrees, above 0 and below 180",
)
.within(1e-3..=179.9)
.offering(1.0..=170.0);

pub(crate) const FOV_AXIS: ParameterInfo = ParameterInfo::new(
    "fov_axis",
    "FOV axis",
    "The edge of the picture, or its diagonal, that the field of view spans.",
    "horizontal, vertical, diagonal, smaller or larger edge",
);
