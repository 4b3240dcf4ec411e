//! Checks of the contract of `shading` that every model with a density must pass, shared by the tables of models.
#![allow(dead_code, reason = "every test binary uses its own part")]

use std::sync::Arc;

use glam::{UVec2, Vec2, Vec3};
use sunroom::color::Rgb;
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, BsdfSample, ShadingTables, TransportMode};

use crate::statistics::{sphere_integral, sphere_p};

/// A model by its name, for radiance.
pub struct Single {
    pub name: String,
    pub bsdf: Bsdf,
    tables: Arc<ShadingTables>,
}

impl Single {
    pub fn new(name: &str, bsdf: Bsdf) -> Self {
        Self::with_tables(name, bsdf, &Arc::default())
    }

    pub fn with_tables(name: &str, bsdf: Bsdf, tables: &Arc<ShadingTables>) -> Self {
        Self {
            name: name.to_owned(),
            bsdf,
            tables: tables.clone(),
        }
    }

    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.bsdf.eval(&self.tables, wo, wi, TransportMode::Radiance)
    }

    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.bsdf.pdf(&self.tables, wo, wi)
    }

    /// A sample by these random numbers.
    pub fn sample_by(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        self.bsdf.sample(&self.tables, wo, u_lobe, u, TransportMode::Radiance)
    }

    /// Sample number `index`; also checks what holds of every sample.
    pub fn sample(&self, wo: Vec3, index: u32) -> Option<BsdfSample> {
        let sampler = sampler(index);
        let sample = self.sample_by(wo, sampler.at_1d(0), sampler.at_2d(1))?;
        let name = &self.name;
        assert!((sample.wi.length() - 1.0).abs() < 1e-5, "{name}: {:?}", sample.wi);
        assert!(
            sample.weight.is_finite() && sample.weight.min_element() >= 0.0,
            "{name}: {}",
            sample.weight
        );
        assert!(sample.pdf.is_finite() && sample.pdf > 0.0, "{name}: {}", sample.pdf);
        Some(sample)
    }
}

/// The random numbers of sample number `index`.
fn sampler(index: u32) -> Sampler {
    Sampler::new(SequenceKind::Independent, UVec2::new(3, 5), index, 8)
}

pub fn direction(theta_degrees: f32, phi: f32) -> Vec3 {
    let (sin, cos) = theta_degrees.to_radians().sin_cos();
    Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

pub fn mirror(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}

/// Samples against the density, for each viewer: named p values.
pub fn density_p_values(case: &Single, viewers: &[Vec3]) -> Vec<(String, f64)> {
    let p_value = |&wo: &Vec3| {
        let sampled = |i| case.sample(wo, i).map(|sample| sample.wi);
        let p = sphere_p(30_000, mirror(wo), sampled, |wi| case.pdf(wo, wi));
        (format!("{} from {wo}", case.name), p)
    };
    viewers.iter().map(p_value).collect()
}

/// Whether light leaves in `lobe`: 1 is reflection, -1 is transmission.
fn within(lobe: f32, wo: Vec3, wi: Vec3) -> bool {
    lobe * wo.z * wi.z > 0.0
}

/// Samples of one lobe, without those of delta lobes, against the density, which is finest resolved around `peak`.
pub fn lobe_p_value(case: &Single, wo: Vec3, lobe: f32, peak: Vec3) -> (String, f64) {
    let sampled = |i| {
        let smooth = case.sample(wo, i).filter(|sample| !sample.is_delta);
        smooth.map(|sample| sample.wi).filter(|&wi| within(lobe, wo, wi))
    };
    let density = |wi| if within(lobe, wo, wi) { case.pdf(wo, wi) } else { 0.0 };
    let p = sphere_p(30_000, peak, sampled, density);
    (format!("{} from {wo}, lobe {lobe}", case.name), p)
}

/// The mean of the weights of one lobe, without those of delta lobes, is the integral of the value.
pub fn assert_lobe_weight(case: &Single, wo: Vec3, lobe: f32, peak: Vec3) {
    let count = 20_000;
    let weight = |i| {
        case.sample(wo, i)
            .filter(|sample| !sample.is_delta && within(lobe, wo, sample.wi))
            .map_or(0.0, |sample| f64::from(sample.weight.x))
    };
    let weights: Vec<f64> = (0..count).map(weight).collect();
    let mean = weights.iter().sum::<f64>() / f64::from(count);
    let variance = weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / f64::from(count);
    let value = |wi| if within(lobe, wo, wi) { case.eval(wo, wi).x } else { 0.0 };
    let integral = sphere_integral(peak, value);
    // Five standard errors: 300 comparisons, a false alarm in 5,000. Plus that of the quadrature.
    let tolerance = 5.0 * (variance / f64::from(count)).sqrt() + 5e-4;
    let name = &case.name;
    assert!(
        (mean - integral).abs() < tolerance,
        "{name} {wo} {lobe}: {mean}, {integral}"
    );
}

/// What comes back from a white room, light that changes the medium counted as power: the mean of weight eta^2.
pub fn furnace(case: &Single, wo: Vec3, count: u32) -> Rgb {
    let sum: Rgb = (0..count)
        .filter_map(|i| case.sample(wo, i))
        .map(|sample| sample.weight * (sample.eta * sample.eta))
        .sum();
    sum / count as f32
}

/// Straight on, and grazing as far as floats go.
pub const EXTREME_COSINES: [f32; 11] = [
    0.0,
    -0.0,
    f32::MIN_POSITIVE,
    1e-40,
    -1e-30,
    1e-20,
    1e-7,
    1e-3,
    -1e-3,
    1.0,
    -1.0,
];

/// Every number stays finite for any direction and any random numbers.
pub fn assert_finite(case: &Single) {
    let last = 1.0f32.next_down();
    for z in EXTREME_COSINES {
        let wo = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
        for u in [[0.0, 0.0], [last, last], [0.5, 0.0], [0.0, last], [last, 0.0]].map(Vec2::from) {
            for u_lobe in [0.0, 0.3, 0.5, 0.6, 0.9, last] {
                let Some(sample) = case.sample_by(wo, u_lobe, u) else {
                    continue;
                };
                let name = &case.name;
                let finite = sample.wi.is_finite() && sample.weight.is_finite() && sample.pdf.is_finite();
                assert!(finite && sample.pdf > 0.0, "{name} {wo} {u}: {sample:?}");
                assert!((sample.wi.length() - 1.0).abs() < 1e-5, "{name} {wo} {u}: {sample:?}");
                let (value, pdf) = (case.eval(wo, sample.wi), case.pdf(wo, sample.wi));
                assert!(
                    value.is_finite() && pdf.is_finite(),
                    "{name} {wo} {u}: {sample:?} {value} {pdf}"
                );
            }
        }
    }
}

/// The value and the density for a pair of directions: `wo`, `wi`, value, pdf.
pub type Figure = (Vec3, Vec3, Rgb, f32);

/// The model gives a figure of another program to these fractions of value and density.
pub fn assert_figure(case: &Single, (wo, wi, value, pdf): Figure, value_tolerance: f32, pdf_tolerance: f32) {
    let value = (case.eval(wo, wi) / value - Rgb::ONE).abs().max_element();
    let pdf = (case.pdf(wo, wi) / pdf - 1.0).abs();
    let close = value < value_tolerance && pdf < pdf_tolerance;
    assert!(close, "{:?} {wo} {wi}: off by {value}, {pdf}", case.bsdf);
}

/// The density of a sample is that of its direction, and its weight is value over density, to a fraction `tolerance` of
/// the density.
pub fn assert_weights(case: &Single, viewers: &[Vec3], tolerance: f32) {
    for &wo in viewers {
        for sample in (0..500).filter_map(|i| case.sample(wo, i)) {
            let (value, pdf) = (case.eval(wo, sample.wi), case.pdf(wo, sample.wi));
            let transmitted = sample.wi.z * wo.z < 0.0;
            assert!(!sample.is_delta && (transmitted || sample.eta == 1.0));
            // The fuzzy metal's density ends like a square root: at the rim only the absolute error is small.
            let rim = 1e-3 * case.pdf(wo, mirror(wo)).min(1e3);
            assert!(
                (pdf - sample.pdf).abs() <= tolerance * pdf + rim * 1e-2,
                "{} {wo}: {pdf} {sample:?}",
                case.name
            );
            let difference = (value - sample.weight * pdf).abs().max_element();
            assert!(
                difference <= tolerance * pdf,
                "{} {wo}: {value} {pdf} {sample:?}",
                case.name
            );
        }
    }
}

/// The mean of the weights is the integral of the value.
pub fn assert_mean_weight(case: &Single, viewers: &[Vec3]) {
    for &wo in viewers {
        let count = 20_000;
        let weights: Vec<f64> = (0..count)
            .map(|i| f64::from(case.sample(wo, i).map_or(0.0, |sample| sample.weight.x)))
            .collect();
        let mean = weights.iter().sum::<f64>() / f64::from(count);
        let variance = weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / f64::from(count);
        let integral = sphere_integral(mirror(wo), |wi| case.eval(wo, wi).x);
        // Five standard errors: 100 comparisons, a false alarm in a million. Plus that of the quadrature.
        let tolerance = 5.0 * (variance / f64::from(count)).sqrt() + 5e-4;
        assert!(
            (mean - integral).abs() < tolerance,
            "{} {wo}: {mean}, {integral}",
            case.name
        );
    }
}

/// The weight of sampled importance is that of radiance without the factor eta^2, and the rest of the sample is the
/// same.
pub fn assert_unscaled(case: &Single, wo: Vec3, u_lobe: f32, u: Vec2) {
    let sample = |mode| {
        case.bsdf
            .sample(&case.tables, wo, u_lobe, u, mode)
            .expect("nothing is absorbed")
    };
    let [radiance, importance] = [TransportMode::Radiance, TransportMode::Importance].map(sample);
    let weight = radiance.weight * (radiance.eta * radiance.eta);
    let error = (importance.weight - weight).abs().max_element();
    let name = &case.name;
    assert!(
        error <= 1e-5 * weight.max_element(),
        "{name} {wo}: {radiance:?} {importance:?}"
    );
    let weight = radiance.weight;
    assert_eq!(BsdfSample { weight, ..importance }, radiance, "{name} {wo}");
}

/// What refracts scatters importance as the adjoint of radiance, f*(wo, wi) = f(wi, wo), to this fraction: seen from
/// `viewers`, as evaluated and as sampled.
pub fn assert_adjoint(case: &Single, viewers: &[Vec3], tolerance: f32) {
    let mut refracted = 0;
    for (&wo, i) in viewers.iter().flat_map(|wo| (0..200).map(move |i| (wo, i))) {
        let Some(sample) = case.sample(wo, i) else {
            continue;
        };
        let (name, wi) = (&case.name, sample.wi);
        let importance = case.bsdf.eval(&case.tables, wo, wi, TransportMode::Importance);
        if wo.z * wi.z > 0.0 {
            assert_eq!(
                importance,
                case.eval(wo, wi),
                "{name} {wo} {wi}: reflection has one form"
            );
            continue;
        }
        refracted += 1;
        let (forth, back) = (importance / wi.z.abs(), case.eval(wi, wo) / wo.z.abs());
        let error = (forth - back).abs().max_element();
        assert!(
            error <= tolerance * back.max_element(),
            "{name} {wo} {wi}: {forth} {back}"
        );
        let sampler = sampler(i);
        assert_unscaled(case, wo, sampler.at_1d(0), sampler.at_2d(1));
    }
    assert!(refracted > 20, "{}: {refracted}", case.name);
}

/// Light reflected from one direction above the surface into another loses as much on the way back.
pub fn assert_reciprocal(case: &Single) {
    assert_reciprocal_between(case, [1.0, 1.0], |_, _| true);
}

/// As [`assert_reciprocal`], between these sides of a surface that compresses no radiance: 1 is above, -1 below. For
/// pairs of directions that there `is` a way between.
pub fn assert_reciprocal_between(case: &Single, sides: [f32; 2], is: impl Fn(Vec3, Vec3) -> bool) {
    let mut seen = 0;
    for i in 0..500 {
        let sampler = Sampler::new(SequenceKind::Independent, UVec2::ZERO, i, 2);
        let draw = |side| {
            let above = direction(89.0 * sampler.at_1d(0), 6.3 * sampler.at_1d(1));
            above.with_z(side * above.z)
        };
        let (a, b) = (draw(sides[0]), draw(sides[1]));
        if !is(a, b) {
            continue;
        }
        let (forth, back) = (case.eval(a, b) / b.z.abs(), case.eval(b, a) / a.z.abs());
        let error = (forth - back).abs().max_element();
        assert!(error <= 1e-4 * forth.max_element(), "{}: {forth} {back}", case.name);
        seen += u32::from(forth.max_element() > 0.0);
    }
    assert!(seen > 0, "{}: nothing was compared", case.name);
}
