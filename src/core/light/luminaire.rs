//! A point that shines by the measured intensities of a lamp (IES LM-63, EULUMDAT).
//!
//! The intensities are a picture of all directions as [`crate::photometry::IntensityPicture`] describes it, which is
//! looked up and sampled as that of an environment.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};

use super::LightSample;
use super::bounds::{LightBounds, NormalCone};
use super::emission::Beam;
use super::environment::{EnvironmentLight, EnvironmentMap};
use super::reference::Reference;
use crate::color::{Rgb, luminance};
use crate::math::{Aabb, Real, Vector};

/// A lamp as a scene describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Luminaire {
    /// The position in world space.
    pub position: Vec3,
    /// The orthonormal map from the lamp's space, in which +z is the axis of the beam and +x the horizontal angle 0.
    pub world_from_local: Mat3,
    /// The radiant intensities in W/sr.
    pub map: Arc<EnvironmentMap>,
    /// The factor on them, by colour.
    pub scale: Rgb,
}

#[derive(Clone, Debug)]
pub(super) struct LuminaireLight {
    pub position: Vec3,
    axis: Vec3,
    scale: Rgb,
    /// The intensities as the radiance that would come from their directions.
    sphere: EnvironmentLight,
}

impl LuminaireLight {
    pub fn new(luminaire: &Luminaire) -> Self {
        let world_from_map = luminaire.world_from_local * local_from_map(luminaire.map.width());
        Self {
            position: luminaire.position,
            axis: luminaire.world_from_local.z_axis,
            scale: luminaire.scale,
            sphere: EnvironmentLight {
                map: luminaire.map.clone(),
                world_from_local: world_from_map,
                scale: 1.0,
            },
        }
    }

    pub fn sample<R: Real>(&self, from: &Reference<R>) -> LightSample<R> {
        let position = R::Vec3::same(self.position);
        let dir = (from.position - position).normalize();
        let [red, green, blue] = R::each(from.asked, [dir.x(), dir.y(), dir.z()], |dir| {
            self.intensity(dir.into()).to_array()
        });
        let sample = LightSample::<R>::of_point(self.position, from.position, R::Vec3::of(red, green, blue));
        let is_lit = R::is_above(red.max(green).max(blue), 0.0);
        LightSample {
            pdf: sample.pdf.only(is_lit),
            ..sample
        }
    }

    /// The radiant intensity in W/sr in a unit direction.
    fn intensity(&self, dir: Vec3) -> Rgb {
        self.scale * self.sphere.radiance(dir)
    }

    /// A direction in which it shines, sampled by its intensities; None if it is dark.
    pub fn sample_beam(&self, u: Vec2) -> Option<Beam> {
        let sample = self.sphere.sample::<f32>(true, u.to_array());
        (sample.pdf > 0.0).then(|| Beam {
            dir: sample.wi,
            intensity: self.scale * sample.radiance,
            pdf_solid_angle: sample.pdf,
        })
    }

    /// Density per solid angle of [`Self::sample_beam`].
    pub fn beam_pdf(&self, dir: Vec3) -> f32 {
        self.sphere.radiance_and_pdf::<f32>(true, dir).1
    }

    pub fn bounds(&self) -> LightBounds {
        let (peak, dark_rows) = self.sphere.map.peak_and_dark_rows();
        let rows = self.sphere.map.rows();
        // The light fades out in the row above the first lit one.
        let angle = PI * (1.0 - (dark_rows as f32 - 1.0) / (rows - 1) as f32);
        let is_half = angle <= FRAC_PI_2;
        LightBounds {
            bounds: Aabb::from_points([self.position]),
            cone: if is_half {
                NormalCone::single(self.axis)
            } else {
                NormalCone::ALL
            },
            cos_emission: if is_half {
                (angle.cos() - COSINE_MARGIN).max(0.0)
            } else {
                0.0
            },
            intensity: luminance(self.scale) * peak,
        }
    }
}

/// The margin that keeps rounding from leaving the rim of the beam without samples.
const COSINE_MARGIN: f32 = 1e-4;

/// The rotation from the frame of a picture with this many columns to that of its lamp: the first column's centre, half
/// a column inside, is at +x, and the bottom row at +z.
fn local_from_map(columns: u32) -> Mat3 {
    let (sin, cos) = (PI / columns as f32).sin_cos();
    let map_from_local = Mat3::from_cols(Vec3::new(sin, 0.0, -cos), Vec3::new(cos, 0.0, sin), Vec3::NEG_Y);
    map_from_local.transpose()
}
