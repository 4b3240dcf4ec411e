//! Fresnel reflectance of smooth interfaces for unpolarised light.

use crate::math::{LanesOf, Real, Vector, real_struct};

real_struct! {
    /// Reflection and refraction of light at the interface of two dielectrics.
    pub struct DielectricFresnel<R> {
        /// The reflected fraction of the power, in [0, 1]; 1 under total internal reflection.
        pub reflectance: R,
        /// Cosine of the refracted direction, with the opposite sign of the incident one; 0 under total internal
        /// reflection.
        pub cos_t: R,
        /// Refractive index of the far side over that of the near side, as the path sees it.
        pub eta_it: R,
        /// The reciprocal of `eta_it`, by which Snell's law scales the tangential components.
        pub eta_ti: R,
    }
}

/// The law by which a dielectric's reflectance depends on the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DielectricModel {
    /// Fresnel's equations.
    #[default]
    Exact,
    /// Schlick's polynomial, in the angle on the thinner side: it is continuous at total internal reflection and equal
    /// in both directions.
    Schlick,
}

/// The model is the same in all lanes.
impl LanesOf<DielectricModel> for DielectricModel {
    fn splat(one: DielectricModel) -> Self {
        one
    }

    #[inline(always)]
    fn set_lane(&mut self, _: usize, one: DielectricModel) {
        debug_assert_eq!(*self, one, "a scene has one model of dielectrics");
    }
}

/// Reflectance and refraction at `cos_i` (either sign; positive is outside), where `eta` is the inner over the outer
/// index.
#[inline(always)]
pub fn dielectric<R: Real>(cos_i: R, eta: R, model: DielectricModel) -> DielectricFresnel<R> {
    let is_outside = !cos_i.is_less(R::ZERO);
    let inverse = R::ONE / eta;
    let eta_it = R::select(is_outside, eta, inverse);
    let eta_ti = R::select(is_outside, inverse, eta);
    let cos_i = cos_i.abs();
    // Snell: sin_t = eta_ti sin_i.
    let sin_i_squared = (-cos_i).mul_add(cos_i, R::ONE).max(R::ZERO);
    let cos_t_squared = (-(eta_ti * eta_ti)).mul_add(sin_i_squared, R::ONE);
    let cos_t = cos_t_squared.max(R::ZERO).sqrt();
    let partial = match model {
        DielectricModel::Exact => {
            let (near, far) = (eta_it * cos_i, eta_it * cos_t);
            let s = (cos_i - far) / (cos_i + far);
            let p = (near - cos_t) / (near + cos_t);
            R::HALF * s.mul_add(s, p * p)
        }
        DielectricModel::Schlick => {
            let head_on = ((R::ONE - eta) / (R::ONE + eta)).squared();
            let thinner = R::select(eta_it.is_more(R::ONE), cos_i, cos_t);
            let grazing = R::ONE - thinner;
            let fourth = grazing.squared().squared();
            head_on + (R::ONE - head_on) * (fourth * grazing)
        }
    };
    let is_total = cos_t_squared.is_at_most(R::ZERO) | cos_i.equals(R::ZERO);
    DielectricFresnel {
        reflectance: R::select(is_total, R::ONE, partial).only(!eta.equals(R::ONE)),
        cos_t: R::select(is_outside, -cos_t, cos_t),
        eta_it,
        eta_ti,
    }
}

/// Reflectance of a conductor with the complex index `eta + i k` relative to the outside, per channel, at `cos_i` in
/// [0, 1].
///
/// The intensity form of Fresnel's equations: with a^2 - b^2 = eta^2 - k^2 - sin^2 and a^2 + b^2 its modulus with 4
/// eta^2 k^2 (K. D. Moeller, Optics, 1988). Index 0 + i reflects everything.
#[inline(always)]
pub fn conductor<R: Real>(cos_i: R, eta: R::Vec3, k: R::Vec3) -> R::Vec3 {
    let cos2 = cos_i * cos_i;
    let sin2 = (R::ONE - cos2).max(R::ZERO);
    let channel = |eta: R, k: R| {
        let (eta2, k2) = (eta * eta, k * k);
        let difference = eta2 - k2 - sin2;
        let modulus = difference.mul_add(difference, R::splat(4.0) * eta2 * k2).sqrt();
        let a = (R::HALF * (modulus + difference)).max(R::ZERO).sqrt();
        let odd = (cos_i + cos_i) * a;
        let s = ratio(modulus + cos2, odd);
        let p = s * ratio(modulus.mul_add(cos2, sin2 * sin2), odd * sin2);
        R::HALF * (s + p)
    };
    R::Vec3::of(
        channel(eta.x(), k.x()),
        channel(eta.y(), k.y()),
        channel(eta.z(), k.z()),
    )
}

/// The difference over the sum. 0 / 0 occurs at two limits only, index 0 head on and index 1 at grazing incidence:
/// there the reflectance is 1.
#[inline(always)]
fn ratio<R: Real>(even: R, odd: R) -> R {
    let sum = even + odd;
    R::select(sum.is_more(R::ZERO), (even - odd) / sum, R::ONE)
}

/// The reflectance of a dielectric with the index `eta`, inner over outer, for diffuse light from outside: the integral
/// of 2 F(mu) mu over the cosines. From inside it is that of `1 / eta`.
///
/// Duntley, The Optical Properties of Diffusing Materials, JOSA 1942, for eta > 1. Below, by conservation: with the
/// solid angle stretched by eta^2, the same flux passes in both directions, 1 - F(1 / n) = (1 - F(n)) / n^2.
pub fn diffuse_reflectance(eta: f32) -> f32 {
    let n = f64::from(eta.max(eta.recip()));
    let n2 = n * n;
    // The terms have a pole of second order at 1 and cancel: below this, the first term of the series is more accurate.
    let outside = if n < 1.0 + 1e-4 {
        (n - 1.0) / 3.0
    } else {
        let (plus, minus) = (n2 + 1.0, n2 * n2 - 1.0);
        0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
            + n2 * (n2 - 1.0).powi(2) / plus.powi(3) * ((n - 1.0) / (n + 1.0)).ln()
            - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / (plus * minus)
            + 8.0 * n2 * n2 * (n2 * n2 + 1.0) / (plus * minus * minus) * n.ln()
    };
    let reflectance = if eta >= 1.0 {
        outside
    } else {
        1.0 - (1.0 - outside) / n2
    };
    reflectance as f32
}
