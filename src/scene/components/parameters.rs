//! The kinds of plugin parameters, and the types of their values.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use bevy::math::Affine2;
use bevy::prelude::*;

use super::declare::declare_parameters;
use super::fov_axis::FovAxis;
use super::medium::{Coefficients, VolumeParameter};
use super::parameter_info::ParameterInfo;
use super::pattern::{Choice, Stop};
use super::texture::{Parameter, Texture};
use super::wall_openings::Opening;
use crate::color::Rgb;

/// Declares the kinds of parameters: a shared and a mutable reference to the value.
macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident($value:ty),)*) => {
        /// A shared reference to the value of a parameter.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) enum ParameterRef<'p> {
            $($(#[$doc])* $kind(&'p $value),)*
        }

        /// A mutable reference to the value of a parameter. Unchanged values of a fresh plugin are the format's
        /// defaults.
        #[derive(Debug, PartialEq)]
        pub(crate) enum ParameterMut<'p> {
            $($(#[$doc])* $kind(&'p mut $value),)*
        }
    };
}

kinds! {
    /// A reflectance by colour, 0 to 1.
    Reflectance(Parameter<Rgb>),
    /// A picture of normals, (normal + 1) / 2 in the shading frame.
    Normals(Parameter<Rgb>),
    Float(Parameter<f32>),
    /// A height in units of the scene: a texture, which has no fixed name in the format.
    Height(Parameter<f32>),
    /// A constant number.
    Number(f32),
    Flag(bool),
    /// A flag of this program only: off by default, and written only if it is on.
    Extension(bool),
    Ior(Ior),
    /// The index of a conductor: `material`, or `eta` and `k`.
    ConductorIor(ConductorIor),
    Distribution(Distribution),
    /// The roughness: `alpha`, or `alpha_u` and `alpha_v`.
    Roughness(Roughness),
    /// The roughness of an isotropic model.
    UniformRoughness(Roughness),
    /// The index of a principled surface: `specular` or `eta`.
    PrincipledIndex(PrincipledIndex),
    /// The absorption: `eumelanin` and `pheomelanin`, or `sigma_a` and `scale`.
    Absorption(Absorption),
    /// Emitted light by colour: not negative, without upper bound.
    Emission(Rgb),
    TexturedEmission(Parameter<Rgb>),
    /// A constant reflectance by colour, 0 to 1.
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
    /// A factor of this program only: 1 by default, and written only if it is not.
    ExtensionFactor(f32),
    /// The coefficients of a medium: `sigma_t` and `albedo`, or `sigma_s` and `sigma_a`.
    Coefficients(Coefficients),
    /// Emission in space, by colour: an extension, which is written only if it is not zero.
    VolumeEmission(VolumeParameter<Rgb>),
    /// A share from 0 to 1 that may vary in space.
    VolumeShare(VolumeParameter<f32>),
    /// A list of numbers that are not negative.
    Values(Vec<f32>),
    /// A length in units of the thing's own space.
    Length(f32),
    /// A whole number that is not negative.
    Count(u32),
    /// The openings of a wall.
    Openings(Vec<Opening>),
    /// A colour or a texture inside a texture, without bounds.
    Nested(Parameter<Rgb>),
    /// The uv transform of a texture.
    Placing(Affine2),
    /// One of a few names.
    Choice(Choice),
    /// The colours of a ramp.
    Stops(Vec<Stop>),
}

/// A value with declared parameters, in the order of the declaration.
pub(crate) trait Declared {
    /// Calls `meet` with every parameter.
    fn visit<'p>(&'p self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterRef<'p>));

    /// Calls `meet` with every parameter, mutable.
    fn visit_mut(&mut self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterMut));
}

/// The default name of a bump map's texture.
pub(crate) const HEIGHT: &str = "height";

/// The largest index of refraction or extinction; the highest measured ones in the visible range are below 10.
const HIGHEST_INDEX: f32 = 100.0;

/// The indices of refraction of dielectrics.
pub(crate) const INDICES: RangeInclusive<f32> = 0.01..=HIGHEST_INDEX;

/// The indices of refraction that sliders offer.
pub(crate) const OFFERED_INDICES: RangeInclusive<f32> = 1.0..=3.0;

/// The roughness that sliders offer: at zero the surface would not be rough.
const OFFERED_ROUGHNESS: RangeInclusive<f32> = 0.001..=1.0;

/// The limit of a hair's absorption coefficient, of the factor on it, and of pigment concentrations: practically black.
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
    /// Optical constants as numbers or textures.
    Given {
        /// The real part of the refractive index relative to the outside, not negative.
        eta: Parameter<Rgb>,
        /// The imaginary part of it (extinction), not negative.
        k: Parameter<Rgb>,
    },
}

/// The index of refraction of a dielectric.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Ior {
    /// A name such as `water`, `bk7`.
    Named(String),
    /// A number above 0; 1 for vacuum.
    Number(f32),
}

declare_names! {
    /// The microfacet distribution of a rough surface.
    #[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Distribution {
        /// Gaussian slopes.
        Beckmann = "beckmann" => "Beckmann",
        /// Slopes with longer tails (Walter et al. 2007).
        Ggx = "ggx" => "GGX",
    }
}

/// The width alpha of the distribution of slopes (not its square root), above 0.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Roughness {
    /// The same in all directions.
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

/// The absorption inside a hair.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Absorption {
    /// Absorption by pigments.
    Melanin {
        /// The concentration of the brown and black pigment, at least 0.
        eumelanin: f32,
        /// The concentration of the red pigment, at least 0.
        pheomelanin: f32,
    },
    /// Absorption by its coefficient.
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
    /// The angle beyond which the intensity is zero.
    pub cutoff_angle: f32,
    /// The angle within which the intensity is full.
    pub beam_width: f32,
}

/// The field of view of a picture.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct FieldOfView {
    /// Degrees.
    pub fov: f32,
    /// The extent of the picture along which it is measured.
    pub axis: FovAxis,
}

/// The position of the sun, or the data from which it follows.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum SunPosition {
    /// The direction to the sun in the world; of any length.
    Direction(Vec3),
    /// The direction computed from a place and time. In the light's own space x is then south and y west.
    PlaceAndTime(PlaceAndTime),
}

declare_parameters! {
    /// A place on earth and a local time there: by default an afternoon in Tokyo, as in the format.
    #[derive(Reflect, Clone, Copy, Debug, PartialEq)]
    pub struct PlaceAndTime {
        /// Degrees, north positive.
        latitude: f32 = 35.6894 => Angle(
            ParameterInfo::degrees("latitude", "Latitude", "Of the place, north positive.", "degrees").within(-90.0..=90.0)
        ),
        /// Degrees, east positive.
        longitude: f32 = 139.6917 => Angle(
            ParameterInfo::degrees("longitude", "Longitude", "Of the place, east positive.", "degrees").within(-360.0..=360.0)
        ),
        /// The hours that local time is ahead of universal time.
        timezone: f32 = 9.0 => Number(ParameterInfo::new(
            "timezone",
            "Time zone",
            "How far local time is ahead of universal time.",
            "hours, -24 to 24",
        )
        .within(-24.0..=24.0)
        .in_units(" h")),
        /// The year of the Gregorian calendar.
        year: i32 = 2010 => Integer(
            ParameterInfo::new("year", "Year", "Of the date.", "-4000 to 9999").within(-4000.0..=9999.0)
        ),
        /// The month, from 1.
        month: i32 = 7 => Integer(ParameterInfo::new("month", "Month", "Of the date.", "1 to 12").within(1.0..=12.0)),
        /// The day, from 1.
        day: i32 = 10 => Integer(ParameterInfo::new("day", "Day", "Of the date.", "1 to 31").within(1.0..=31.0)),
        /// The hour of local time.
        hour: f32 = 15.0 => Number(
            ParameterInfo::new("hour", "Hour", "Local time.", "hours").within(TIME).in_units(" h")
        ),
        /// The minutes, which are added to the hour.
        minute: f32 = 0.0 => Number(
            ParameterInfo::new("minute", "Minute", "Local time.", "minutes").within(TIME).in_units(" min")
        ),
        /// The seconds, which are added to the minute.
        second: f32 = 0.0 => Number(
            ParameterInfo::new("second", "Second", "Local time.", "seconds").within(TIME).in_units(" s")
        ),
    }
}

/// The allowed range of a time, which may be outside of the day; larger ones are mistakes.
const TIME: RangeInclusive<f32> = -1e5..=1e5;

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

pub(crate) const SUN_DIRECTION: ParameterInfo = ParameterInfo::new(
    "sun_direction",
    "Towards sun",
    "Direction in which the sun stands, in the space of the light: z is up.",
    "a vector of any length",
);
