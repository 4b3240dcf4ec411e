//! A diffuse base below a smooth dielectric coat, light between the two being reflected until it escapes; black from behind.
//!
//! The coat mirrors F(wo); the rest gets in, is scattered by the base, and of that the fraction R_int returns to the base each time:
//! f = albedo (1 - F(wo)) (1 - F(wi)) / (pi eta^2 (1 - a R_int)), a being the albedo. "Linear" plastic keeps the colour by leaving a out
//! of the denominator. (Weidlich and Wilkie, Arbitrarily Layered Micro-Facet Surfaces, 2007; Elias, Simonot and Menu, 2001.)

use super::{
    BsdfSample, DiffuseLobe,
    fresnel::{self, DielectricModel},
    mirrored,
};
use crate::{color::Rgb, sampling::warp};
use glam::{Vec2, Vec3};

/// The coat, with what follows from its index alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothCoat {
    eta: f32,
    internal_reflectance: f32,
}

impl SmoothCoat {
    /// A coat with this refractive index relative to the outside, above 0.
    pub fn new(eta: f32) -> Self {
        Self {
            eta,
            internal_reflectance: fresnel::diffuse_reflectance(eta.recip()),
        }
    }

    /// The reflected fraction at a cosine.
    fn reflectance(&self, cos: f32) -> f32 {
        fresnel::dielectric(cos, self.eta, DielectricModel::Exact).reflectance
    }
}

/// The base below a coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatedBase {
    /// The reflectance of the base, [0, 1].
    pub diffuse_reflectance: Rgb,
    /// Whether light that is scattered again takes up the base's colour each time.
    pub nonlinear: bool,
    /// Multiplies what the coat reflects; 1 is physical.
    pub specular_reflectance: Rgb,
}

impl CoatedBase {
    /// The share of the light inside that gets out, per squared transmittance: albedo / (eta^2 (1 - a R_int)).
    pub(super) fn escaping(&self, eta: f32, internal_reflectance: f32) -> Rgb {
        let again = if self.nonlinear {
            self.diffuse_reflectance * internal_reflectance
        } else {
            Rgb::splat(internal_reflectance)
        };
        self.diffuse_reflectance / ((Rgb::ONE - again) * (eta * eta))
    }

    /// The probability of sampling the coat, which reflects the fraction `reflected`.
    pub(super) fn coat_probability(&self, reflected: f32) -> f32 {
        let coat = reflected * self.specular_reflectance.element_sum();
        let base = (1.0 - reflected) * self.diffuse_reflectance.element_sum();
        // If both are black, either choice will do.
        if coat + base > 0.0 { coat / (coat + base) } else { 1.0 }
    }
}

/// Smooth plastic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    /// The interface on top.
    pub coat: SmoothCoat,
    /// The base below the coat.
    pub base: CoatedBase,
}

impl Plastic {
    pub(super) fn eval_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wo.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        self.of_base(self.coat.reflectance(wo.z), wi)
    }

    /// What the base scatters to a viewer for whom the coat reflects the fraction `reflected`, and the density of that.
    fn of_base(&self, reflected: f32, wi: Vec3) -> (Rgb, f32) {
        if wi.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let cosine = warp::cosine_hemisphere_pdf(wi.z);
        let through = (1.0 - reflected) * (1.0 - self.coat.reflectance(wi.z));
        let escaping = self.base.escaping(self.coat.eta, self.coat.internal_reflectance);
        let chance = 1.0 - self.base.coat_probability(reflected);
        (escaping * (through * cosine), chance * cosine)
    }

    pub(super) fn diffuse_lobe(&self, wo: Vec3) -> DiffuseLobe {
        match wo.z > 0.0 {
            true => DiffuseLobe::below(self.base.coat_probability(self.coat.reflectance(wo.z))),
            false => DiffuseLobe::NONE,
        }
    }

    pub(super) fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let reflected = self.coat.reflectance(wo.z);
        let probability = self.base.coat_probability(reflected);
        if u_lobe < probability {
            return Some(BsdfSample {
                wi: mirrored(wo),
                weight: self.base.specular_reflectance * (reflected / probability),
                pdf: probability,
                is_delta: true,
                eta: 1.0,
            });
        }
        let wi = warp::cosine_hemisphere(u);
        let (value, pdf) = self.of_base(reflected, wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: value / pdf,
            pdf,
            is_delta: false,
            eta: 1.0,
        })
    }
}
