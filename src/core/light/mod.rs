//! Emitters, and the table that chooses among them.
//!
//! The contract: [`LightTable::sample`] gives a direction from a reference point towards a light with the radiance that
//! would arrive unoccluded, and its density per solid angle *including the probability of having chosen this light*;
//! [`LightTable::pdf_of_hit`] and [`LightTable::radiance_and_pdf_from`] give that same density for a direction found by
//! other means. Directions here are in world space.
//!
//! Emitters (`finite.rs`, `infinite.rs` and one file per kind) implement sampling and radiance; `choice.rs` and the
//! tree choose the emitter of a sample.

mod bounds;
mod choice;
mod constant;
mod cylinder;
mod directional;
pub mod emission;
mod emission_choice;
mod environment;
mod finite;
pub mod gain;
mod hit;
mod hosek_wilkie;
mod infinite;
mod luminaire;
mod moved;
mod output;
mod plain;
mod point;
mod portal;
mod projector;
mod rectangle;
mod reference;
mod sphere;
mod spot;
mod sun_position;
mod sun_sky;
mod surface;
mod table;
mod texture_density;
mod tree;
mod triangle;

use std::sync::Arc;

use glam::{Mat3, Vec3};

use crate::color::Rgb;
use crate::math::{Real, Vector};
use crate::texture::Parameter;

pub use environment::EnvironmentMap;
pub use hit::SurfaceHit;
pub use hosek_wilkie::Atmosphere;
pub use luminaire::Luminaire;
pub use output::PictureLight;
pub use portal::Portal;
pub use projector::Projector;
pub use reference::{LightReference, ReferenceLanes};
pub use spot::Spot;
pub use sun_position::PlaceAndTime;
pub use table::LightTable;
pub(crate) use table::{Alike, SoleLight};

/// Index of a light in its [`LightTable`], the order of the sources it was built from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u32);

/// The source that a light is made from.
#[derive(Clone, Debug, PartialEq)]
pub enum LightSource {
    /// The triangles of material slot `slot` of an instance (all of an analytic shape), emitting `radiance` (W/(m^2
    /// sr)) from the front, the side of the shading normal.
    Surface {
        /// Index into [`crate::accel::Tlas::instances`].
        instance: u32,
        /// The number of the slot among those of the instance.
        slot: u32,
        /// The radiance. Negative values of a texture count as no light.
        radiance: Parameter<Rgb>,
        /// Whether the back emits as the front does.
        is_two_sided: bool,
    },
    /// A point light of radiant intensity in W/sr.
    Point {
        /// The position in world space.
        position: Vec3,
        /// The intensity, the same in all directions.
        intensity: Rgb,
    },
    /// Parallel light. `direction` is the unit vector in which the light travels; `irradiance` (W/m^2) is for a surface
    /// that faces it.
    Directional {
        /// The direction in world space.
        direction: Vec3,
        /// The irradiance, the same everywhere.
        irradiance: Rgb,
    },
    /// A cone of light from a point, with an optional texture.
    Spot(Spot),
    /// A point with the measured intensities of a lamp.
    Luminaire(Luminaire),
    /// An image projected from a point.
    Projector(Projector),
    /// The same radiance from all directions.
    Constant {
        /// The radiance in W/(m^2 sr).
        radiance: Rgb,
    },
    /// An image of all directions, times `scale`; `world_from_local` is orthonormal.
    Environment {
        /// The image with its sampling density.
        map: Arc<EnvironmentMap>,
        /// The map from the frame of the picture.
        world_from_local: Mat3,
        /// The factor on the picture, not negative.
        scale: f32,
    },
    /// Sun and sky; `world_from_local` is orthonormal.
    SunSky {
        /// The look of sky and sun.
        atmosphere: Atmosphere,
        /// The map from the frame in which z points up.
        world_from_local: Mat3,
    },
}

impl LightSource {
    /// Whether its look depends on a texture.
    pub fn is_textured(&self) -> bool {
        let parameter = match self {
            Self::Surface { radiance, .. } => radiance,
            Self::Spot(spot) => &spot.texture,
            Self::Projector(projector) => &projector.irradiance,
            _ => return false,
        };
        matches!(parameter, Parameter::Texture(_))
    }
}

/// A source and its share of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedSource {
    /// The light itself.
    pub source: LightSource,
    /// The factor on the probability of being chosen, not negative. Paths find a source of weight 0 only by hitting it.
    pub sampling_weight: f32,
}

impl From<LightSource> for WeightedSource {
    fn from(source: LightSource) -> Self {
        Self {
            source,
            sampling_weight: 1.0,
        }
    }
}

/// A direction towards a light, or one per lane towards the same light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample<R: Real = f32> {
    /// Unit vector towards the light.
    pub wi: R::Vec3,
    /// The end of the shadow ray.
    pub target: Target<R>,
    /// Radiance arriving along `-wi` if unoccluded; for delta lights the coefficient of the delta function.
    pub radiance: R::Vec3,
    /// Density per solid angle times the probability of the light; for delta lights only that probability. Zero where
    /// no light comes from there; the other fields are then meaningless.
    pub pdf: R,
    /// Whether no other technique can find this light (a point, a single direction).
    pub is_delta: bool,
}

impl LightSample {
    /// The sample, or None where no light comes from there.
    fn if_lit(self) -> Option<Self> {
        (self.pdf > 0.0).then_some(self)
    }
}

impl<R: Real> LightSample<R> {
    /// The light of a point with this radiant intensity towards the reference. None at the point itself.
    #[inline(always)]
    fn of_point(position: Vec3, reference: R::Vec3, intensity: R::Vec3) -> Self {
        let to_light = R::Vec3::same(position) - reference;
        let distance_squared = to_light.length_squared();
        let is_apart = R::is_above(distance_squared, 0.0) & distance_squared.is_less(R::splat(f32::INFINITY));
        Self {
            wi: to_light.normalize(),
            target: Target::Point(R::Vec3::same(position)),
            radiance: intensity / distance_squared,
            pdf: R::ONE.only(is_apart),
            is_delta: true,
        }
    }
}

/// The end of a shadow ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target<R: Real = f32> {
    /// A point just in front of the emitting surface.
    Point(R::Vec3),
    /// The light is infinitely far away, and so is the end of the ray.
    Infinity,
}
