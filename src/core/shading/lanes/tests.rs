//! Compares models in lanes with the same models one by one.

use glam::{Vec2, Vec3};

use super::*;
use crate::color::Rgb;
use crate::math::lanes::LANES;
use crate::shading::*;

/// Numbers in [0, 1) that look random.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 += 1;
        let [word, ..] = crate::sampling::hash::pcg4d([self.0, 1, 2, 3]);
        (word >> 8) as f32 / (1 << 24) as f32
    }

    fn color(&mut self) -> Rgb {
        Rgb::new(self.next(), self.next(), self.next())
    }

    /// A number in [0, 1], often at an end of the range.
    fn share(&mut self) -> f32 {
        (1.5 * self.next() - 0.25).clamp(0.0, 1.0)
    }

    /// A direction, often near the horizon or straight up.
    fn direction(&mut self) -> Vec3 {
        let part = |x: f32| 2.0 * x - 1.0;
        let v = Vec3::new(part(self.next()), part(self.next()), part(self.next()));
        match self.0 % 7 {
            0 => Vec3::new(v.x, v.y, 1e-3 * v.z).normalize(),
            1 => Vec3::new(1e-4 * v.x, 1e-4 * v.y, v.z).normalize(),
            _ => v.normalize(),
        }
    }

    fn specular(&mut self) -> ConductorSpecular {
        ConductorSpecular {
            // With a k of nearly zero the reflectance would be a difference of large numbers.
            eta: 2.0 * self.color() + Vec3::splat(0.05),
            k: 4.0 * self.color() + Vec3::splat(0.5),
            specular_reflectance: self.color(),
        }
    }

    fn facets(&mut self) -> Microfacet {
        let kind = [MicrofacetKind::Ggx, MicrofacetKind::Beckmann][(self.0 / 3 % 2) as usize];
        Microfacet::new(kind, 0.03 + self.next(), 0.03 + self.next())
    }

    fn base(&mut self) -> CoatedBase {
        CoatedBase {
            diffuse_reflectance: self.color(),
            nonlinear: self.next() < 0.5,
            specular_reflectance: self.color(),
        }
    }

    fn eta(&mut self) -> f32 {
        [1.5, 1.33, 0.7, 2.4, 1.5][(self.next() * 5.0) as usize]
    }
}

const MODELS: usize = 10;

/// A model of the kind `kind`.
fn model(kind: usize, tables: &Tables, numbers: &mut Numbers) -> Bsdf {
    match kind {
        0 => Bsdf::Diffuse(Diffuse {
            reflectance: numbers.color(),
        }),
        1 => Bsdf::Conductor(Conductor {
            specular: numbers.specular(),
        }),
        2 => {
            let (specular, distribution) = (numbers.specular(), numbers.facets());
            let is_compensated = numbers.next() < 0.5;
            Bsdf::RoughConductor(RoughConductor {
                specular,
                distribution,
                multiple_scattering: match is_compensated {
                    true => Compensation::new(tables.microalbedo, &distribution, &specular),
                    false => Compensation::NONE,
                },
            })
        }
        3 => Bsdf::Dielectric(Dielectric {
            eta: numbers.eta(),
            model: tables.model,
            specular_reflectance: numbers.color(),
            specular_transmittance: numbers.color(),
        }),
        4 => Bsdf::Metal(Metal {
            color: numbers.color(),
            fuzz: numbers.share(),
        }),
        5 => Bsdf::Principled(Principled {
            base_color: numbers.color(),
            roughness: 0.1 + 0.9 * numbers.next(),
            anisotropic: numbers.share(),
            metallic: numbers.share(),
            spec_trans: numbers.share(),
            eta: numbers.eta(),
            spec_tint: numbers.share(),
            sheen: numbers.share(),
            sheen_tint: numbers.share(),
            flatness: numbers.share(),
            clearcoat: numbers.share(),
            clearcoat_gloss: numbers.share(),
            rates: SamplingRates::default(),
        }),
        6 => Bsdf::PrincipledThin(PrincipledThin {
            base_color: numbers.color(),
            roughness: 0.1 + 0.9 * numbers.next(),
            anisotropic: numbers.share(),
            spec_trans: numbers.share(),
            diff_trans: 2.0 * numbers.share(),
            eta: 1.1 + numbers.next(),
            spec_tint: numbers.share(),
            sheen: numbers.share(),
            sheen_tint: numbers.share(),
            flatness: numbers.share(),
            rates: ThinSamplingRates::default(),
        }),
        7 => Bsdf::RoughDielectric(RoughDielectric {
            eta: numbers.eta(),
            model: tables.model,
            distribution: numbers.facets(),
            specular_reflectance: numbers.color(),
            specular_transmittance: numbers.color(),
        }),
        8 => Bsdf::Plastic(Plastic {
            coat: SmoothCoat::new(1.1 + numbers.next()),
            base: numbers.base(),
        }),
        _ => Bsdf::RoughPlastic(RoughPlastic {
            coat: tables.coats[(numbers.next() * 2.0) as usize],
            alpha: 0.05 + 0.9 * numbers.next(),
            base: numbers.base(),
        }),
    }
}

struct Tables {
    tables: ShadingTables,
    /// The model of all dielectrics of a scene.
    model: DielectricModel,
    microalbedo: MicroalbedoId,
    coats: [CoatId; 2],
}

fn tables() -> Tables {
    let mut tables = ShadingTables::default();
    Tables {
        model: DielectricModel::Exact,
        microalbedo: tables.microalbedo_of(MicrofacetKind::Ggx),
        coats: [
            tables.varying_coat(MicrofacetKind::Beckmann, 1.5),
            tables.varying_coat(MicrofacetKind::Ggx, 1.3),
        ],
        tables,
    }
}

/// Whether both are near, relative to the larger one.
fn is_near(a: Vec3, b: Vec3, tolerance: f32) -> bool {
    a.abs_diff_eq(b, tolerance * a.abs().max(b.abs()).max_element().max(1e-3))
}

/// The tolerance of a kind, and whether a few values may differ. Formulas without differences of large numbers have a
/// strict one.
fn tolerance(kind: usize) -> (f32, bool) {
    match kind {
        0 | 1 | 3 => (2e-4, false),
        _ => (1e-3, true),
    }
}

/// Counts comparisons. A few may differ: where rounding decides on a choice, and where two large numbers cancel.
#[derive(Default)]
struct Comparisons {
    equal: u32,
    different: u32,
    example: String,
}

impl Comparisons {
    fn note(&mut self, is_equal: bool, example: impl FnOnce() -> String) {
        match is_equal {
            true => self.equal += 1,
            false => {
                self.different += 1;
                if self.different < 4 {
                    self.example += &example();
                }
            }
        }
    }

    fn check(&self, least: u32, may_differ: bool) {
        let Self {
            equal,
            different,
            example,
        } = self;
        assert!(may_differ || *different == 0, "{different} differ, such as {example}");
        assert!(*equal >= least, "only {equal} were compared");
        assert!(
            1000 * different <= equal + different,
            "{different} of {equal} differ, such as {example}"
        );
    }
}

/// 100,000 values, and as many samples, of every model, alone in all lanes and mixed with others.
#[test]
fn models_are_those_of_one() {
    let mut tables = tables();
    let mut numbers = Numbers(0);
    for (mixed, dielectrics) in (0..=MODELS)
        .map(|mixed| (mixed, DielectricModel::Exact))
        .chain([(3, DielectricModel::Schlick), (7, DielectricModel::Schlick)])
    {
        tables.model = dielectrics;
        let (near, may_differ) = tolerance(mixed);
        let (mut values, mut samples, mut directions) = <(Comparisons, Comparisons, Comparisons)>::default();
        for batch in 0..100_000 / LANES {
            let kind = |lane: usize| {
                if mixed == MODELS {
                    (batch + lane) % MODELS
                } else {
                    mixed
                }
            };
            let models: [Bsdf; LANES] = std::array::from_fn(|lane| model(kind(lane), &tables, &mut numbers));
            let mut lanes = BsdfLanes::new();
            let (mut wo, mut wi) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
            let mut u = [[0.0; LANES]; 3];
            for (lane, bsdf) in models.iter().enumerate() {
                assert!(BsdfLanes::knows(bsdf));
                lanes.set(lane, bsdf);
                wo.set(lane, numbers.direction());
                wi.set(lane, numbers.direction());
                u.iter_mut().for_each(|u| u[lane] = numbers.next());
            }
            let (value, pdf) = lanes.eval_and_pdf(&tables.tables, wo, wi);
            let mode = [TransportMode::Radiance, TransportMode::Importance][batch % 2];
            let sample = lanes.sample(&tables.tables, wo, u[0].into(), [u[1].into(), u[2].into()], mode);
            let lobes = lanes.diffuse_lobes(&tables.tables, wo);
            for (lane, bsdf) in models.iter().enumerate() {
                let (wo, wi) = (wo.get(lane), wi.get(lane));
                let expected = bsdf.eval_and_pdf(&tables.tables, wo, wi, TransportMode::Radiance);
                let found = (value.get(lane), pdf.as_array()[lane]);
                let is_equal =
                    is_near(found.0, expected.0, near) && is_near(Vec3::splat(found.1), Vec3::splat(expected.1), near);
                values.note(is_equal, || format!("{bsdf:?} {wo} {wi}: {found:?} {expected:?}"));
                let lobe = bsdf.diffuse_lobe(&tables.tables, wo);
                assert!(
                    (lobes.start.as_array()[lane] - lobe.start).abs() < 1e-4,
                    "{bsdf:?} {wo} {lobe:?}"
                );
                assert!(
                    (lobes.share.as_array()[lane] - lobe.share).abs() < 1e-4,
                    "{bsdf:?} {wo} {lobe:?}"
                );

                let expected = bsdf.sample(&tables.tables, wo, u[0][lane], Vec2::new(u[1][lane], u[2][lane]), mode);
                let is_returned = sample.is_returned.to_bitmask() >> lane & 1 == 1;
                samples.note(is_returned == expected.is_some(), || {
                    format!("{bsdf:?} {wo} {expected:?}")
                });
                let Some(expected) = expected.filter(|_| is_returned) else {
                    continue;
                };
                let pdf = sample.pdf.as_array()[lane];
                let is_equal = sample.wi.get(lane).abs_diff_eq(expected.wi, 1e-3)
                    && is_near(sample.weight.get(lane), expected.weight, near)
                    && (pdf - expected.pdf).abs() <= 10.0 * near * expected.pdf.max(1e-3)
                    && (sample.is_delta.to_bitmask() >> lane & 1 == 1) == expected.is_delta
                    && (sample.eta.as_array()[lane] - expected.eta).abs() < 1e-6;
                directions.note(is_equal, || {
                    format!("{bsdf:?} {wo} {} {pdf} {expected:?}", sample.wi.get(lane))
                });
            }
        }
        values.check(99_000, may_differ);
        samples.check(99_000, may_differ);
        directions.check(20_000, may_differ);
    }
}

#[test]
fn lanes_know_what_their_models_do() {
    let tables = tables();
    let mut numbers = Numbers(7);
    for kind in 0..MODELS {
        let mut lanes = BsdfLanes::new();
        let bsdf = model(kind, &tables, &mut numbers);
        lanes.set(3, &bsdf);
        let bit = |condition: bool| u32::from(condition) << 3;
        assert_eq!(lanes.smooth(), bit(bsdf.has_smooth_lobe()));
        assert_eq!(lanes.guided(), bit(bsdf.may_have_diffuse_lobe()));
        assert_eq!(lanes.transmitting(), bit(bsdf.transmits()));
        lanes.clear();
        assert_eq!(
            lanes.smooth() | lanes.guided() | lanes.transmitting() | lanes.choosing(),
            0
        );
    }
    let pane = Bsdf::ThinDielectric(ThinDielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    });
    assert!(!BsdfLanes::knows(&pane), "light passes straight through");
}
