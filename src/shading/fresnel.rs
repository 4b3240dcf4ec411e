//! Fresnel reflectance of smooth interfaces for unpolarised light.

use crate::color::Rgb;

/// Reflection and refraction of light at the interface of two dielectrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricFresnel {
    /// The reflected fraction of the power, in [0, 1]; 1 under total internal reflection.
    pub reflectance: f32,
    /// Cosine of the refracted direction, with the opposite sign of the incident one; 0 under total internal reflection.
    pub cos_t: f32,
    /// Refractive index of the far side over that of the near side, as the path sees it.
    pub eta_it: f32,
    /// The reciprocal of `eta_it`, by which Snell's law scales the tangential components.
    pub eta_ti: f32,
}

/// The law by which a dielectric's reflectance depends on the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DielectricModel {
    /// Fresnel's equations.
    #[default]
    Exact,
    /// Schlick's polynomial, in the angle on the thinner side: it meets total internal reflection without a jump and is the same both
    /// ways.
    Schlick,
}

/// Reflectance and refraction at `cos_i` (either sign; positive is outside), where `eta` is the inner over the outer index.
pub fn dielectric(cos_i: f32, eta: f32, model: DielectricModel) -> DielectricFresnel {
    let (eta_it, eta_ti) = if cos_i >= 0.0 {
        (eta, eta.recip())
    } else {
        (eta.recip(), eta)
    };
    let cos_i_abs = cos_i.abs();
    // Snell: sin_t = eta_ti sin_i.
    let cos_t_squared = 1.0 - eta_ti * eta_ti * (1.0 - cos_i * cos_i).max(0.0);
    let cos_t_abs = cos_t_squared.max(0.0).sqrt();
    let reflectance = if eta == 1.0 {
        0.0
    } else if cos_t_squared <= 0.0 || cos_i_abs == 0.0 {
        1.0
    } else {
        match model {
            DielectricModel::Exact => {
                let s = (cos_i_abs - eta_it * cos_t_abs) / (cos_i_abs + eta_it * cos_t_abs);
                let p = (eta_it * cos_i_abs - cos_t_abs) / (eta_it * cos_i_abs + cos_t_abs);
                0.5 * (s * s + p * p)
            }
            DielectricModel::Schlick => {
                let r = (1.0 - eta) / (1.0 + eta);
                let thinner = if eta_it > 1.0 { cos_i_abs } else { cos_t_abs };
                r * r + (1.0 - r * r) * (1.0 - thinner).powi(5)
            }
        }
    };
    DielectricFresnel {
        reflectance,
        cos_t: if cos_i >= 0.0 { -cos_t_abs } else { cos_t_abs },
        eta_it,
        eta_ti,
    }
}

/// Reflectance of a conductor with the complex index `eta + i k` relative to the outside, per channel, at `cos_i` in [0, 1].
///
/// The intensity form of Fresnel's equations: with a^2 - b^2 = eta^2 - k^2 - sin^2 and a^2 + b^2 its modulus with 4 eta^2 k^2
/// (K. D. Moeller, Optics, 1988). Index 0 + i reflects everything.
pub fn conductor(cos_i: f32, eta: Rgb, k: Rgb) -> Rgb {
    let cos2 = cos_i * cos_i;
    let sin2 = (1.0 - cos2).max(0.0);
    let difference = eta * eta - k * k - Rgb::splat(sin2);
    let modulus = (difference * difference + 4.0 * eta * eta * k * k).map(f32::sqrt);
    let a = (0.5 * (modulus + difference)).map(|x| x.max(0.0).sqrt());
    let (even, odd) = (modulus + Rgb::splat(cos2), 2.0 * cos_i * a);
    let s = ratio(even - odd, even + odd);
    let (even, odd) = (modulus * cos2 + Rgb::splat(sin2 * sin2), odd * sin2);
    let p = s * ratio(even - odd, even + odd);
    0.5 * (s + p)
}

/// 0 / 0 happens at two limits only, index 0 head on and index 1 at grazing incidence: all is reflected there.
fn ratio(numerator: Rgb, denominator: Rgb) -> Rgb {
    Rgb::select(denominator.cmpgt(Rgb::ZERO), numerator / denominator, Rgb::ONE)
}

/// The reflectance of a dielectric with the index `eta`, inner over outer, for diffuse light from outside: the integral of
/// 2 F(mu) mu over the cosines. From inside it is that of `1 / eta`.
///
/// Duntley, The Optical Properties of Diffusing Materials, JOSA 1942, for eta > 1. Below, by conservation: with the solid angle
/// stretched by eta^2, as much gets through one way as the other, 1 - F(1 / n) = (1 - F(n)) / n^2.
pub fn diffuse_reflectance(eta: f32) -> f32 {
    let n = f64::from(eta.max(eta.recip()));
    let n2 = n * n;
    // The terms have a pole of second order at 1 and cancel: below this, the first one of the series has more digits left.
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
