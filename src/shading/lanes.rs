//! The commonest models for sixteen surfaces at once: diffuse, smooth and rough (GGX) metal, glass.
//!
//! Every lane has a model of its own with its own parameters; all are evaluated, and each lane keeps its own. Contracts are those of
//! [`super`], whose models the tests hold these to.

use std::f32::consts::{FRAC_1_PI, TAU};

use super::fresnel::DielectricModel;
use super::{Bsdf, ConductorSpecular, Microfacet, TransportMode};
use crate::math::lanes::{Lanes, Vec3Lanes, copy_sign, lanes_of};
use crate::sampling::lanes::cosine_hemisphere;

/// A model per lane.
#[derive(Clone, Debug)]
pub(crate) struct BsdfLanes {
    diffuse: u32,
    conductor: u32,
    rough: u32,
    dielectric: u32,
    /// Reflectance of a diffuse surface; eta of a metal; specular reflectance of glass.
    reflectance_or_eta: Vec3Lanes,
    /// The k of a metal; the specular transmittance of glass.
    transmittance_or_k: Vec3Lanes,
    /// The specular reflectance of a metal.
    metal_reflectance: Vec3Lanes,
    /// Roughness of a rough metal; index of glass.
    alpha_or_index: Lanes,
}

/// A continuation per lane, as [`super::BsdfSample`].
#[derive(Clone, Copy, Debug)]
pub struct BsdfSampleLanes {
    /// The directions as [`super::BsdfSample::wi`].
    pub wi: Vec3Lanes,
    /// The weights as [`super::BsdfSample::weight`].
    pub weight: Vec3Lanes,
    /// The densities as [`super::BsdfSample::pdf`].
    pub pdf: Lanes,
    /// The relative indices as [`super::BsdfSample::eta`].
    pub eta: Lanes,
    /// The lanes whose light is not absorbed.
    pub returned: Lanes,
}

impl BsdfLanes {
    /// Lanes without a model.
    pub fn new() -> Self {
        Self {
            diffuse: 0,
            conductor: 0,
            rough: 0,
            dielectric: 0,
            reflectance_or_eta: Vec3Lanes::ZERO,
            transmittance_or_k: Vec3Lanes::ZERO,
            metal_reflectance: Vec3Lanes::ZERO,
            alpha_or_index: Lanes::ONE,
        }
    }

    /// Removes the models of all lanes.
    pub fn clear(&mut self) {
        (self.diffuse, self.conductor, self.rough, self.dielectric) = (0, 0, 0, 0);
    }

    /// Whether [`Self::set`] knows the model.
    pub fn knows(bsdf: &Bsdf) -> bool {
        match bsdf {
            Bsdf::Diffuse(_) | Bsdf::Conductor(_) => true,
            Bsdf::RoughConductor(rough) => {
                rough.multiple_scattering.is_none()
                    && rough.distribution.is_isotropic()
                    && matches!(rough.distribution, Microfacet::Ggx(_))
            }
            Bsdf::Dielectric(dielectric) => dielectric.model == DielectricModel::Exact,
            _ => false,
        }
    }

    /// Gives lane `lane` a model that it [knows](Self::knows).
    #[inline(always)]
    pub fn set(&mut self, lane: usize, bsdf: &Bsdf) {
        let bit = 1 << lane;
        match bsdf {
            Bsdf::Diffuse(diffuse) => {
                self.diffuse |= bit;
                self.reflectance_or_eta.set(lane, diffuse.reflectance);
            }
            Bsdf::Conductor(conductor) => {
                self.conductor |= bit;
                self.set_metal(lane, &conductor.specular);
            }
            Bsdf::RoughConductor(rough) => {
                self.rough |= bit;
                self.set_metal(lane, &rough.specular);
                self.alpha_or_index.as_mut_array()[lane] = rough.distribution.mean_alpha();
            }
            Bsdf::Dielectric(dielectric) => {
                self.dielectric |= bit;
                self.reflectance_or_eta.set(lane, dielectric.specular_reflectance);
                self.transmittance_or_k.set(lane, dielectric.specular_transmittance);
                self.alpha_or_index.as_mut_array()[lane] = dielectric.eta;
            }
            other => debug_assert!(false, "no model of lanes: {other:?}"),
        }
    }

    fn set_metal(&mut self, lane: usize, specular: &ConductorSpecular) {
        self.reflectance_or_eta.set(lane, specular.eta);
        self.transmittance_or_k.set(lane, specular.k);
        self.metal_reflectance.set(lane, specular.specular_reflectance);
    }

    /// The lanes with [`Bsdf::has_smooth_lobe`], a bit each.
    pub fn smooth(&self) -> u32 {
        self.diffuse | self.rough
    }

    /// The lanes whose directions are worth guiding.
    pub fn guided(&self) -> u32 {
        self.diffuse
    }

    /// The lanes with [`Bsdf::transmits`], a bit each.
    pub fn transmitting(&self) -> u32 {
        self.dielectric
    }

    /// Evaluates as [`Bsdf::eval_and_pdf`].
    #[inline(always)]
    pub fn eval_and_pdf(&self, wo: Vec3Lanes, wi: Vec3Lanes) -> (Vec3Lanes, Lanes) {
        let above = wo.z.simd_gt(Lanes::ZERO) & wi.z.simd_gt(Lanes::ZERO);
        let cosine = (wi.z * Lanes::splat(FRAC_1_PI)) & above & lanes_of(self.diffuse);
        let (mut value, mut pdf) = (self.reflectance_or_eta * cosine, cosine);
        if self.rough != 0 {
            let m = (wo + wi).normalize();
            let alpha = self.alpha_or_index;
            let seen = density(alpha, m) * (Lanes::splat(0.5) / reach(alpha, wo));
            let here = above & lanes_of(self.rough);
            let masking = (wi.z + wi.z) / reach(alpha, wi);
            value = Vec3Lanes::select(here, self.reflectance(wo.dot(m)) * (seen * masking), value);
            pdf = here.select(seen, pdf);
        }
        (value, pdf)
    }

    /// Samples as [`Bsdf::sample`].
    #[inline(always)]
    pub fn sample(&self, wo: Vec3Lanes, u_lobe: Lanes, u: [Lanes; 2], mode: TransportMode) -> BsdfSampleLanes {
        let zero = Lanes::ZERO;
        let facing = wo.z.simd_gt(zero);
        let mut sample = BsdfSampleLanes {
            wi: Vec3Lanes::ZERO,
            weight: self.reflectance_or_eta,
            pdf: zero,
            eta: Lanes::ONE,
            returned: zero,
        };
        if self.diffuse != 0 {
            sample.wi = cosine_hemisphere(u);
            sample.pdf = sample.wi.z * Lanes::splat(FRAC_1_PI);
            sample.returned = facing & sample.wi.z.simd_gt(zero) & lanes_of(self.diffuse);
        }
        if self.rough != 0 {
            sample.choose(lanes_of(self.rough), self.sample_rough(wo, u));
        }
        if self.conductor != 0 {
            let mirrored = BsdfSampleLanes {
                wi: Vec3Lanes::of(-wo.x, -wo.y, wo.z),
                weight: self.reflectance(wo.z),
                pdf: Lanes::ONE,
                eta: Lanes::ONE,
                returned: facing,
            };
            sample.choose(lanes_of(self.conductor), mirrored);
        }
        if self.dielectric != 0 {
            sample.choose(lanes_of(self.dielectric), self.sample_dielectric(wo, u_lobe, mode));
        }
        sample
    }

    /// Samples as [`super::Ggx::sample_visible`], and reflects.
    #[inline(always)]
    fn sample_rough(&self, wo: Vec3Lanes, [u, v]: [Lanes; 2]) -> BsdfSampleLanes {
        let (zero, one) = (Lanes::ZERO, Lanes::ONE);
        let alpha = self.alpha_or_index;
        let stretch = |v: Vec3Lanes| Vec3Lanes::of(alpha * v.x, alpha * v.y, v.z);
        let view = stretch(wo).normalize();
        let z = v.mul_neg_add(one + view.z, one);
        let radius = z.mul_neg_add(z, one).fast_max(zero).sqrt();
        let (sin, cos) = (Lanes::splat(TAU) * u).sin_cos();
        let half = stretch(Vec3Lanes::of(
            radius.mul_add(cos, view.x),
            radius.mul_add(sin, view.y),
            (z + view.z).fast_max(zero),
        ));
        let length_squared = half.length_squared();
        let m = Vec3Lanes::select(
            length_squared.simd_gt(zero),
            half * (one / length_squared.sqrt()),
            Vec3Lanes::of(zero, zero, one),
        );
        let cos = wo.dot(m);
        let wi = (-wo).plus_scaled(cos + cos, m);
        let pdf = density(alpha, m) * (Lanes::splat(0.5) / reach(alpha, wo));
        let masking = (wi.z + wi.z) / reach(alpha, wi);
        BsdfSampleLanes {
            wi,
            weight: self.reflectance(cos) * masking,
            pdf,
            eta: one,
            returned: wo.z.simd_gt(zero) & wi.z.simd_gt(zero) & cos.simd_gt(zero) & pdf.simd_gt(zero),
        }
    }

    /// Samples as [`super::Dielectric`].
    #[inline(always)]
    fn sample_dielectric(&self, wo: Vec3Lanes, u_lobe: Lanes, mode: TransportMode) -> BsdfSampleLanes {
        let (zero, one) = (Lanes::ZERO, Lanes::ONE);
        let eta = self.alpha_or_index;
        let outside = wo.z.simd_ge(zero);
        let inverse = one / eta;
        let (eta_it, eta_ti) = (outside.select(eta, inverse), outside.select(inverse, eta));
        let cos_i = wo.z.abs();
        let sin2_i = cos_i.mul_neg_add(cos_i, one).fast_max(zero);
        let cos2_t = (eta_ti * eta_ti).mul_neg_add(sin2_i, one);
        let cos_t = cos2_t.fast_max(zero).sqrt();
        let s = (cos_i - eta_it * cos_t) / (cos_i + eta_it * cos_t);
        let p = (eta_it * cos_i - cos_t) / (eta_it * cos_i + cos_t);
        let fresnel = Lanes::splat(0.5) * s.mul_add(s, p * p);
        let total = cos2_t.simd_le(zero) | cos_i.simd_eq(zero);
        let reflectance = total.select(one, fresnel) & eta.simd_ne(one);
        let reflected = u_lobe.simd_lt(reflectance);
        let mirrored = Vec3Lanes::of(-wo.x, -wo.y, wo.z);
        let refracted = Vec3Lanes::of(-eta_ti * wo.x, -eta_ti * wo.y, copy_sign(cos_t, -wo.z));
        BsdfSampleLanes {
            wi: Vec3Lanes::select(reflected, mirrored, refracted),
            weight: Vec3Lanes::select(
                reflected,
                self.reflectance_or_eta,
                self.transmittance_or_k * mode.refraction_factor(eta_ti),
            ),
            pdf: reflected.select(reflectance, one - reflectance),
            eta: reflected.select(one, eta_it),
            returned: wo.z.simd_ne(zero),
        }
    }

    /// The reflectance as [`ConductorSpecular::reflectance`].
    #[inline(always)]
    fn reflectance(&self, cos: Lanes) -> Vec3Lanes {
        let zero = Lanes::ZERO;
        let cos2 = cos * cos;
        let sin2 = (Lanes::ONE - cos2).fast_max(zero);
        let channel = |eta: Lanes, k: Lanes| {
            let ratio = |even: Lanes, odd: Lanes| {
                let sum = even + odd;
                sum.simd_gt(zero).select((even - odd) / sum, Lanes::ONE)
            };
            let (eta2, k2) = (eta * eta, k * k);
            let difference = eta2 - k2 - sin2;
            let modulus = difference.mul_add(difference, Lanes::splat(4.0) * eta2 * k2).sqrt();
            let a = (Lanes::splat(0.5) * (modulus + difference)).fast_max(zero).sqrt();
            let odd = (cos + cos) * a;
            let s = ratio(modulus + cos2, odd);
            let p = s * ratio(modulus.mul_add(cos2, sin2 * sin2), odd * sin2);
            Lanes::splat(0.5) * (s + p)
        };
        let (eta, k) = (self.reflectance_or_eta, self.transmittance_or_k);
        self.metal_reflectance * Vec3Lanes::of(channel(eta.x, k.x), channel(eta.y, k.y), channel(eta.z, k.z))
    }
}

impl Default for BsdfLanes {
    fn default() -> Self {
        Self::new()
    }
}

impl BsdfSampleLanes {
    /// The sample of `other` where `condition` holds.
    #[inline(always)]
    pub(crate) fn choose(&mut self, condition: Lanes, other: Self) {
        self.wi = Vec3Lanes::select(condition, other.wi, self.wi);
        self.weight = Vec3Lanes::select(condition, other.weight, self.weight);
        self.pdf = condition.select(other.pdf, self.pdf);
        self.eta = condition.select(other.eta, self.eta);
        self.returned |= other.returned & condition;
    }
}

/// The density as [`super::Ggx::density`], equally rough along both tangents.
#[inline(always)]
fn density(alpha: Lanes, m: Vec3Lanes) -> Lanes {
    let alpha2 = alpha * alpha;
    let across = m.x.mul_add(m.x, m.y * m.y) / alpha2;
    let stretched = m.z.mul_add(m.z, across);
    Lanes::splat(FRAC_1_PI) / (alpha2 * stretched * stretched)
}

/// The divisor of masking in [`super::Ggx`].
#[inline(always)]
fn reach(alpha: Lanes, v: Vec3Lanes) -> Lanes {
    let (x, y) = (alpha * v.x, alpha * v.y);
    v.z.abs() + x.mul_add(x, y.mul_add(y, v.z * v.z)).sqrt()
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;
    use crate::math::lanes::LANES;
    use crate::shading::{Conductor, Dielectric, Diffuse, Ggx, Metal, RoughConductor, ShadingTables};

    fn number(k: u32, factor: f32) -> f32 {
        (k as f32 * factor).fract()
    }

    fn model(k: u32) -> Bsdf {
        let color = |shift: f32| {
            Vec3::new(
                number(k, 0.618_034 + shift),
                number(k, 0.414_214 + shift),
                number(k, 0.732_051 + shift),
            )
        };
        let specular = ConductorSpecular {
            // With a k of nearly zero the reflectance would be a difference of large numbers.
            eta: 2.0 * color(0.1) + Vec3::splat(0.05),
            k: 4.0 * color(0.2) + Vec3::splat(0.5),
            specular_reflectance: color(0.3),
        };
        match k % 4 {
            0 => Bsdf::Diffuse(Diffuse {
                reflectance: color(0.0),
            }),
            1 => Bsdf::Conductor(Conductor { specular }),
            2 => {
                let alpha = 0.02 + number(k, 0.236_068);
                Bsdf::RoughConductor(RoughConductor {
                    specular,
                    distribution: Microfacet::Ggx(Ggx::new(alpha, alpha)),
                    multiple_scattering: None,
                })
            }
            _ => Bsdf::Dielectric(Dielectric {
                eta: [1.5, 1.0, 0.7][(k / 4 % 3) as usize],
                model: DielectricModel::Exact,
                specular_reflectance: color(0.1),
                specular_transmittance: color(0.2),
            }),
        }
    }

    fn direction(k: u32) -> Vec3 {
        let part = |factor: f32| number(k, factor) * 2.0 - 1.0;
        Vec3::new(part(0.754_878), part(0.569_84), part(0.311_7)).normalize()
    }

    /// Relative to the larger one.
    fn is_near(a: Vec3, b: Vec3) -> bool {
        a.abs_diff_eq(b, 2e-4 * a.abs().max(b.abs()).max_element().max(1e-3))
    }

    #[test]
    fn models_are_those_of_one() {
        let tables = ShadingTables::default();
        let (mut returned, mut transmitted) = (0, 0);
        for start in (0..20_000).step_by(LANES) {
            let models: [Bsdf; LANES] = std::array::from_fn(|lane| model(start + lane as u32));
            let mut lanes = BsdfLanes::new();
            let (mut wo, mut wi) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
            let mut u = [[0.0; LANES]; 3];
            for (lane, bsdf) in models.iter().enumerate() {
                let k = start + lane as u32;
                assert!(BsdfLanes::knows(bsdf));
                lanes.set(lane, bsdf);
                wo.set(lane, direction(3 * k));
                wi.set(lane, direction(5 * k + 1));
                (u[0][lane], u[1][lane], u[2][lane]) = (number(k, 0.29), number(k, 0.47), number(k, 0.83));
            }
            let (value, pdf) = lanes.eval_and_pdf(wo, wi);
            let batch = start as usize / LANES;
            let mode = [TransportMode::Radiance, TransportMode::Importance][batch % 2];
            let sample = lanes.sample(wo, u[0].into(), [u[1].into(), u[2].into()], mode);
            for (lane, bsdf) in models.iter().enumerate() {
                assert_eq!(lanes.smooth() >> lane & 1 == 1, bsdf.has_smooth_lobe());
                assert_eq!(lanes.transmitting() >> lane & 1 == 1, bsdf.transmits());
                let (wo, wi) = (wo.get(lane), wi.get(lane));
                let expected = bsdf.eval_and_pdf(&tables, wo, wi, mode);
                assert!(
                    is_near(value.get(lane), expected.0),
                    "{bsdf:?} {} {expected:?}",
                    value.get(lane)
                );
                assert!(is_near(Vec3::splat(pdf.as_array()[lane]), Vec3::splat(expected.1)));
                let expected = bsdf.sample(&tables, wo, u[0][lane], Vec2::new(u[1][lane], u[2][lane]), mode);
                assert_eq!(
                    sample.returned.to_bitmask() >> lane & 1 == 1,
                    expected.is_some(),
                    "{bsdf:?}"
                );
                let Some(expected) = expected else {
                    continue;
                };
                returned += 1;
                transmitted += u32::from(expected.eta != 1.0);
                assert!(is_near(sample.wi.get(lane), expected.wi));
                assert!(
                    is_near(sample.weight.get(lane), expected.weight),
                    "{bsdf:?} {wo} {} {expected:?}",
                    sample.weight.get(lane)
                );
                let pdf = sample.pdf.as_array()[lane];
                // A cosine near the horizon is the root of a difference that rounding decides.
                let rim = if expected.wi.z.abs() < 0.05 { 2e-4 } else { 0.0 };
                assert!(
                    (pdf - expected.pdf).abs() <= 2e-4 * expected.pdf.max(1e-3) + rim,
                    "{bsdf:?} {wo} {pdf} {expected:?}"
                );
                assert!((sample.eta.as_array()[lane] - expected.eta).abs() < 1e-6);
            }
        }
        assert!(returned > 8000 && transmitted > 1000, "{returned} {transmitted}");
    }

    #[test]
    fn other_models_are_not_known() {
        let metal = Bsdf::Metal(Metal {
            color: Vec3::ONE,
            fuzz: 0.1,
        });
        assert!(!BsdfLanes::knows(&metal));
        let stretched = Bsdf::RoughConductor(RoughConductor {
            specular: ConductorSpecular {
                eta: Vec3::ZERO,
                k: Vec3::ONE,
                specular_reflectance: Vec3::ONE,
            },
            distribution: Microfacet::Ggx(Ggx::new(0.1, 0.2)),
            multiple_scattering: None,
        });
        assert!(!BsdfLanes::knows(&stretched));
    }
}
