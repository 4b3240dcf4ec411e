//! Sampling emitted rays, with which light paths start (Veach 1997, section 10.2; PBR 4th ed., section 16.1).

use glam::{Vec2, Vec3};

use super::{LightId, SurfaceHit};
use crate::color::Rgb;
use crate::math::{Aabb, Frame};
use crate::sampling::warp;

/// A ray of light that leaves an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmittedRay {
    /// The light that it comes from.
    pub light: LightId,
    /// The start of the ray, off the surface if there is one; before the scene for lights at infinity.
    pub origin: Vec3,
    /// Unit vector in which the light travels.
    pub dir: Vec3,
    /// The power of the ray: the emitted radiance times the cosine at the emitter, over the densities.
    pub power: Rgb,
    /// The densities by which the ray was sampled.
    pub pdf: EmissionPdf,
    /// The point on the emitter.
    pub start: Start,
}

/// The densities of a ray in the measures of its emitter, which depend on its kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionPdf {
    /// Density of the start, with the probability of the light: per area on surfaces; per solid angle of the light's
    /// direction for lights at infinity. For point lights and lights of one direction, it is the probability of the
    /// light.
    pub start: f32,
    /// Density of the direction per solid angle; for lights at infinity, of the origin per area perpendicular to the
    /// ray.
    pub next: f32,
}

/// The first vertex of a path from a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// A point of a surface.
    Surface(SurfaceHit),
    /// A point light.
    Point(Vec3),
    /// Infinitely far away.
    Infinity {
        /// Whether the light comes from this direction alone.
        is_delta: bool,
    },
}

impl Start {
    /// Whether no path from the camera can hit the start by chance.
    pub fn is_delta(&self) -> bool {
        match *self {
            Self::Surface(_) => false,
            Self::Point(_) => true,
            Self::Infinity { is_delta } => is_delta,
        }
    }

    /// A density per solid angle of directions from `reference` to the start, in the measure of [`EmissionPdf::start`].
    pub fn density(&self, reference: Vec3, pdf_solid_angle: f32) -> f32 {
        match self {
            Self::Surface(hit) => {
                let way = hit.position - reference;
                let distance_squared = way.length_squared();
                pdf_solid_angle * (way.dot(hit.normal) / distance_squared.sqrt()).abs() / distance_squared
            }
            Self::Point(_) | Self::Infinity { .. } => pdf_solid_angle,
        }
    }
}

/// A direction in which a point light shines.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    /// Unit vector.
    pub dir: Vec3,
    /// Radiant intensity in W/sr.
    pub intensity: Rgb,
    pub pdf_solid_angle: f32,
}

/// The region that light from the lights can reach.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reach {
    /// A sphere around all shapes.
    pub everything: SceneSphere,
    /// A sphere around all shapes but lamps that are farther from the others than twice its radius.
    pub lit: SceneSphere,
}

/// A bounding sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneSphere {
    /// The centre in world space.
    pub center: Vec3,
    /// The radius, above zero.
    pub radius: f32,
}

impl Default for SceneSphere {
    fn default() -> Self {
        Self {
            center: Vec3::ZERO,
            radius: 1.0,
        }
    }
}

impl SceneSphere {
    /// The sphere around a box, a little larger for rounding.
    pub fn around(bounds: &Aabb) -> Self {
        if !bounds.min.cmple(bounds.max).all() {
            return Self::default();
        }
        let radius = 0.5 * bounds.extent().length() * (1.0 + 1e-4);
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        Self {
            center: bounds.center(),
            radius: radius.max(1e-6 * reach).max(f32::MIN_POSITIVE.sqrt()),
        }
    }

    /// The area of the sphere's projection.
    pub(super) fn cross_section(&self) -> f32 {
        std::f32::consts::PI * self.radius * self.radius
    }
}

/// The cone of directions from a distant point to a sphere. Lamps send most of their rays into it, as with projection
/// maps (Jensen, Realistic Image Synthesis Using Photon Mapping, 2001): otherwise only one ray in thousands of a small
/// sun would meet a scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    /// Unit vector of the cone's axis.
    axis: Vec3,
    /// The squared sine of the cone's angle, and one minus its cosine.
    sin_squared: f32,
    one_minus_cos: f32,
}

/// The range of the squared sine of the cone's angle: nearer points do not aim, and narrower cones would be lost to
/// rounding.
const SINES_SQUARED: [f32; 2] = [1e-6, 0.25];

impl Aim {
    /// The share of the rays that are aimed. The others leave in any direction in which the lamp shines.
    pub const SHARE: f32 = 0.875;

    /// The cone from the point `from`; None if it is not distant.
    pub fn at(sphere: &SceneSphere, from: Vec3) -> Option<Self> {
        let [least, most] = SINES_SQUARED;
        let way = sphere.center - from;
        let axis = way.try_normalize()?;
        let sin_squared = (sphere.radius / way.length()).powi(2);
        (sin_squared <= most).then(|| {
            let sin_squared = sin_squared.max(least);
            Self {
                axis,
                sin_squared,
                one_minus_cos: sin_squared / (1.0 + (1.0 - sin_squared).sqrt()),
            }
        })
    }

    /// Whether a surface side with this normal shines in any of the directions.
    pub fn is_before(&self, normal: Vec3) -> bool {
        normal.dot(self.axis) > -self.sin_squared.sqrt()
    }

    /// A direction, uniform over the cone.
    pub fn sample(&self, u: Vec2) -> Vec3 {
        let local = warp::uniform_cone(u.to_array(), self.one_minus_cos);
        Frame::from_normal(self.axis).to_world(local).normalize()
    }

    /// Density per solid angle of [`Self::sample`].
    pub fn pdf(&self, dir: Vec3) -> f32 {
        // A sampled direction is inside even after rounding; the edge of the sphere is empty.
        let most = 1.00001 * self.sin_squared + 1e-9;
        let is_inside = dir.dot(self.axis) > 0.0 && dir.cross(self.axis).length_squared() <= most;
        if is_inside {
            warp::uniform_cone_pdf(self.one_minus_cos)
        } else {
            0.0
        }
    }

    /// Whether `u` chooses an aimed ray, and `u` stretched again to [0, 1) to sample the ray.
    pub fn choose(u: Vec2) -> (bool, Vec2) {
        match u.x < Self::SHARE {
            true => (true, Vec2::new(u.x / Self::SHARE, u.y)),
            false => (false, Vec2::new((u.x - Self::SHARE) / (1.0 - Self::SHARE), u.y)),
        }
    }

    /// The density of the mixture of aimed rays and other rays, whose density is `pdf`.
    pub fn mixed(aim: Option<&Self>, pdf: f32, dir: Vec3) -> f32 {
        aim.map_or(pdf, |aim| Self::SHARE * aim.pdf(dir) + (1.0 - Self::SHARE) * pdf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Sampler, SequenceKind};
    use glam::UVec2;

    #[test]
    fn sampled_directions_lie_in_the_cone() {
        let sphere = SceneSphere {
            center: Vec3::new(0.3, -0.2, 0.5),
            radius: 1.5,
        };
        for distance in [3.2, 40.0, 1500.0, 1e5] {
            let from = sphere.center + distance * Vec3::new(0.48, 0.6, 0.64);
            let aim = Aim::at(&sphere, from).expect("it is far away");
            for index in 0..20_000 {
                let sampler = Sampler::new(SequenceKind::Independent, UVec2::new(3, 1), index, 2);
                let dir = aim.sample(sampler.at_2d(0));
                assert!(aim.pdf(dir) > 0.0, "{distance}: {dir}");
            }
            assert_eq!(aim.pdf(from - sphere.center), 0.0);
        }
    }

    #[test]
    fn near_and_impossible_places_have_no_aim() {
        let sphere = SceneSphere {
            center: Vec3::ZERO,
            radius: 1.0,
        };
        for from in [0.0, 0.5, 1.9, 1e30, f32::INFINITY, f32::NAN] {
            assert!(Aim::at(&sphere, Vec3::splat(from) * Vec3::X).is_none(), "{from}");
        }
    }
}
