//! Plastic and panes against the contract of `shading`, with figures of another renderer.

use crate::bsdf_support::{
    Single, assert_figure, assert_finite, assert_lobe_weight, assert_reciprocal, assert_weights, direction, furnace,
    lobe_p_value, mirror,
};
use crate::statistics::{assert_all_plausible, sphere_integral};
use std::sync::Arc;

use glam::{Vec2, Vec3};
use sunroom::color::Rgb;
use sunroom::shading::{
    Bsdf, CoatedBase, DielectricModel,
    MicrofacetKind::{self, Beckmann, Ggx},
    Plastic, RoughPlastic, ShadingTables, SmoothCoat, ThinDielectric, fresnel,
};

const COLOR: Rgb = Rgb::new(0.1, 0.27, 0.36);

fn base(diffuse_reflectance: Rgb, nonlinear: bool) -> CoatedBase {
    CoatedBase {
        diffuse_reflectance,
        nonlinear,
        specular_reflectance: Rgb::ONE,
    }
}

fn plastic(eta: f32, base: CoatedBase) -> Bsdf {
    Bsdf::Plastic(Plastic {
        coat: SmoothCoat::new(eta),
        base,
    })
}

fn rough_plastic(name: &str, eta: f32, kind: MicrofacetKind, alpha: f32, base: CoatedBase) -> Single {
    let mut tables = ShadingTables::default();
    let coat = tables.uniform_coat(kind, eta, alpha);
    let bsdf = Bsdf::RoughPlastic(RoughPlastic { coat, alpha, base });
    Single::with_tables(name, bsdf, &Arc::new(tables))
}

/// At least five settings each; smooth plastic has a mirror besides its density.
fn cases() -> Vec<Single> {
    let mut cases = Vec::new();
    for (eta, color, nonlinear) in [
        (1.49, Rgb::splat(0.5), false),
        (1.9, COLOR, true),
        (1.49, Rgb::ONE, true),
        (1.2, Rgb::ONE, false),
        (0.7, COLOR, true),
    ] {
        let base = base(color, nonlinear);
        let name = format!("plastic {eta} {color} {nonlinear}");
        cases.push(Single::new(&name, plastic(eta, base)));
        cases.extend([(Beckmann, 0.1), (Ggx, 0.1), (Ggx, 0.6)].map(|(kind, alpha)| {
            let name = format!("roughplastic {kind:?} {eta} {alpha} {color} {nonlinear}");
            rough_plastic(&name, eta, kind, alpha, base)
        }));
    }
    let tinted = CoatedBase {
        specular_reflectance: Rgb::new(0.3, 0.9, 0.0),
        ..base(COLOR, true)
    };
    cases.push(Single::new("plastic, tinted", plastic(1.6, tinted)));
    cases.push(rough_plastic("roughplastic, tinted", 1.6, Ggx, 0.2, tinted));
    cases
}

/// From overhead to grazing.
fn viewers() -> [Vec3; 4] {
    [0.0, 30.0, 60.0, 85.0].map(|degrees| direction(degrees, 1.0 + degrees))
}

#[test]
fn samples_follow_the_density() {
    let mut results = Vec::new();
    for case in cases() {
        results.extend(viewers().map(|wo| lobe_p_value(&case, wo, 1.0, mirror(wo))));
    }
    assert_all_plausible(&results);
}

#[test]
fn weights_are_value_over_density() {
    // Smooth plastic's delta lobe has another test.
    for case in cases().iter().filter(|case| case.name.starts_with("rough")) {
        assert_weights(case, &viewers(), 2e-3);
    }
}

#[test]
fn mean_weight_is_the_integral_of_the_value() {
    for case in cases() {
        for wo in viewers() {
            assert_lobe_weight(&case, wo, 1.0, mirror(wo));
        }
    }
}

#[test]
fn no_energy_is_made() {
    for case in cases() {
        for wo in viewers() {
            // Weights of mixtures and compensated lobes exceed 1 here and there: three standard errors of at most 0.6 /
            // sqrt(count) each.
            let total = furnace(&case, wo, 20_000);
            assert!(total.max_element() < 1.0 + 0.013, "{} {wo}: {total}", case.name);
        }
    }
}

#[test]
fn reflection_is_reciprocal() {
    cases().iter().for_each(assert_reciprocal);
}

#[test]
fn black_from_behind() {
    let (above, below) = (direction(40.0, 1.0), direction(130.0, 2.0));
    for case in cases() {
        for wo in [below, direction(90.0, 0.0).with_z(0.0)] {
            assert!((0..50).all(|i| case.sample(wo, i).is_none()));
            assert_eq!((case.eval(wo, above), case.pdf(wo, above)), (Rgb::ZERO, 0.0));
        }
        assert_eq!((case.eval(above, below), case.pdf(above, below)), (Rgb::ZERO, 0.0));
    }
}

/// Exact conservation: a white base below a smooth coat, where R_int and the coat's outer reflectance fit together.
#[test]
fn white_plastic_keeps_all_light() {
    for eta in [1.2, 1.49, 1.9, 2.4, 0.7] {
        for nonlinear in [false, true] {
            let case = Single::new("", plastic(eta, base(Rgb::ONE, nonlinear)));
            for degrees in [0.0f32, 40.0, 80.0] {
                let wo = direction(degrees, 1.0);
                let mirrored = fresnel::dielectric(wo.z, eta, DielectricModel::Exact).reflectance;
                let total = f64::from(mirrored) + sphere_integral(Vec3::Z, |wi| case.eval(wo, wi).x);
                // The quadrature over the kink of total reflection from outside, and single precision.
                assert!((total - 1.0).abs() < 1e-3, "{eta} {degrees}: {total}");
            }
        }
    }
}

#[test]
fn smooth_coats_mirror_what_fresnel_says() {
    let case = Single::new("", plastic(1.49, base(COLOR, false)));
    for wo in viewers() {
        let expected = fresnel::dielectric(wo.z, 1.49, DielectricModel::Exact).reflectance;
        let sample = case.sample_by(wo, 0.0, Vec2::splat(0.5)).expect("coats mirror");
        assert_eq!((sample.wi, sample.is_delta), (mirror(wo), true));
        assert!(
            (sample.weight * sample.pdf / expected - Rgb::ONE).abs().max_element() < 1e-5,
            "{wo}"
        );
    }
}

#[test]
fn diffuse_reflectance_has_the_known_figures() {
    // Integrals of 2 F mu by adaptive quadrature (scipy).
    for (eta, outside) in [
        (1.1, 0.025_157_357),
        (1.33, 0.065_930_85),
        (1.5, 0.091_777_96),
        (2.4, 0.210_181_3),
    ] {
        let inside = 1.0 - (1.0 - outside) / (eta * eta);
        assert!((fresnel::diffuse_reflectance(eta) - outside).abs() < 1e-6, "{eta}");
        assert!((fresnel::diffuse_reflectance(1.0 / eta) - inside).abs() < 1e-6, "{eta}");
    }
    assert_eq!(fresnel::diffuse_reflectance(1.0), 0.0);
    // Where the closed form gives way to its series.
    let around = [1.000_09, 1.000_11].map(|eta: f32| fresnel::diffuse_reflectance(eta) / (eta - 1.0));
    assert!((around[0] / around[1] - 1.0).abs() < 2e-3, "{around:?}");
}

#[test]
fn textured_roughness_is_that_of_uniform_coats() {
    let mut tables = ShadingTables::default();
    let varying = tables.varying_coat(Ggx, 1.49);
    let tables = Arc::new(tables);
    for alpha in [0.01, 0.05, 0.13, 0.3, 0.55, 0.97, 1.0] {
        let base = base(COLOR, true);
        let textured = Bsdf::RoughPlastic(RoughPlastic {
            coat: varying,
            alpha,
            base,
        });
        let table = Single::with_tables("", textured, &tables);
        let exact = rough_plastic("", 1.49, Ggx, alpha, base);
        for (a, b) in [(0.0, 30.0), (30.0, 70.0), (70.0, 10.0), (85.0, 40.0)] {
            let (wo, wi) = (direction(a, 0.3), direction(b, 2.0));
            let ratio = table.eval(wo, wi) / exact.eval(wo, wi);
            // The error of linear interpolation between 32 nodes.
            assert!(
                (ratio - Rgb::ONE).abs().max_element() < 2e-3,
                "{alpha} {a} {b}: {ratio}"
            );
        }
    }
}

#[test]
fn equal_coats_share_their_layers() {
    let fill = || {
        let mut tables = ShadingTables::default();
        let ids = [
            tables.uniform_coat(Ggx, 1.49, 0.1),
            tables.varying_coat(Ggx, 1.49),
            tables.uniform_coat(Ggx, 1.49, 0.2),
            tables.uniform_coat(Beckmann, 1.49, 0.1),
            tables.uniform_coat(Ggx, 1.49, 0.1),
            tables.varying_coat(Ggx, 1.49),
        ];
        (tables, ids.map(|id| id.0))
    };
    let ((a, ids), (b, _)) = (fill(), fill());
    assert_eq!(ids, [0, 1, 2, 3, 0, 1]);
    assert_eq!(a, b, "the same requests give the same tables");
    let mut other = a.clone();
    other.uniform_coat(Ggx, 1.5, 0.1);
    assert_ne!(a, other);
}

#[test]
fn a_pane_mirrors_or_lets_through() {
    for eta in [1.0f32, 1.2, 1.5, 2.4, 0.7] {
        let case = Single::new(
            "",
            Bsdf::ThinDielectric(ThinDielectric {
                eta,
                model: DielectricModel::Exact,
                specular_reflectance: Rgb::X,
                specular_transmittance: Rgb::Y,
            }),
        );
        for degrees in [0.0, 30.0, 70.0, 89.0, 100.0, 175.0] {
            let wo = direction(degrees, 2.0);
            // Reflections inside, one after another.
            let once = fresnel::dielectric(wo.z.abs(), eta, DielectricModel::Exact).reflectance;
            let series: f32 = (0..500)
                .map(|k| (1.0 - once) * (1.0 - once) * once * once.powi(2 * k))
                .sum();
            let expected = if once == 1.0 { 1.0 } else { once + series };
            let through = case
                .sample_by(wo, 1.0f32.next_down(), Vec2::ZERO)
                .expect("all light goes on");
            let mirrored = case.sample_by(wo, 0.0, Vec2::ZERO).expect("all light goes on");
            if expected > 0.0 {
                assert_eq!(
                    (mirrored.wi, mirrored.weight, mirrored.is_delta),
                    (mirror(wo), Rgb::X, true)
                );
                assert!(
                    (mirrored.pdf - expected).abs() < 1e-4,
                    "{eta} {degrees}: {} {expected}",
                    mirrored.pdf
                );
            }
            if expected < 1.0 {
                assert_eq!((through.wi, through.weight, through.eta), (-wo, Rgb::Y, 1.0));
                assert!((through.pdf - (1.0 - expected)).abs() < 1e-4);
            }
            assert_eq!((case.eval(wo, -wo), case.pdf(wo, -wo)), (Rgb::ZERO, 0.0));
        }
    }
}

#[test]
fn grazing_and_extreme_input_gives_numbers() {
    let black = CoatedBase {
        specular_reflectance: Rgb::ZERO,
        ..base(Rgb::ZERO, true)
    };
    let white = base(Rgb::ONE, true);
    let bsdfs = [
        plastic(1.0, base(COLOR, true)),
        plastic(1.49, black),
        plastic(100.0, white),
    ];
    for kind in [Beckmann, Ggx] {
        for alpha in [0.0, 1e-3, 1.0, 50.0] {
            for (eta, base) in [(1.49, black), (1.0, white)] {
                let name = format!("roughplastic {kind:?} {eta} {alpha}");
                assert_finite(&rough_plastic(&name, eta, kind, alpha, base));
            }
        }
    }
    for bsdf in bsdfs {
        assert_finite(&Single::new(&format!("{bsdf:?}"), bsdf));
    }
}

/// As Mitsuba 3.9.1 (variant `scalar_rgb`) has them at some directions. Of 6,300 such values above 1e-3 all agreed to
/// 1e-3, but for smooth plastic, where R_int is a fit there, 0.1 % off at this index. The density of Beckmann's visible
/// normals is 0.3 % off there.
#[test]
fn figures_agree_with_mitsuba() {
    let figures = [
        (
            rough_plastic("", 1.9, Ggx, 0.3, base(COLOR, false)),
            (
                Vec3::new(0.03368908, -0.2979369, 0.9539909),
                Vec3::new(-0.6430371, 0.213247, 0.7355467),
                Rgb::new(0.03070388, 0.05140449, 0.06236364),
                0.2209874,
            ),
        ),
        (
            rough_plastic("", 1.5, Ggx, 0.7, base(COLOR, false)),
            (
                Vec3::new(0.6232823, -0.7794209, 0.06342145),
                Vec3::new(-0.6546587, 0.6600813, 0.3683947),
                Rgb::new(0.07431331, 0.07793409, 0.07985096),
                0.3216716,
            ),
        ),
        (
            rough_plastic("", 1.49, Beckmann, 0.1, base(COLOR, false)),
            (
                Vec3::new(0.8710949, -0.1598017, 0.464389),
                Vec3::new(-0.6610184, 0.2378687, 0.7116693),
                Rgb::new(0.05131983, 0.0861591, 0.1046034),
                0.3095502,
            ),
        ),
        (
            rough_plastic("", 1.49, Beckmann, 0.1, base(COLOR, true)),
            (
                Vec3::new(-0.05618199, -0.04535269, 0.99739),
                Vec3::new(0.03836299, -0.04912139, 0.9980562),
                Rgb::new(0.260135, 0.2883671, 0.3061307),
                1.175446,
            ),
        ),
        (
            Single::new("", plastic(1.49, base(COLOR, false))),
            (
                Vec3::new(0.00508933, -0.03567382, 0.9993505),
                Vec3::new(0.7421247, 0.2039921, 0.6384655),
                Rgb::new(0.02027937, 0.0547543, 0.07300574),
                0.174363,
            ),
        ),
        (
            Single::new("", plastic(1.49, base(COLOR, true))),
            (
                Vec3::new(0.9429122, -0.2149617, 0.2543778),
                Vec3::new(-0.2367891, 0.3005393, 0.9239086),
                Rgb::new(0.01005472, 0.03039141, 0.04325817),
                0.1215634,
            ),
        ),
        (
            Single::new("", plastic(1.9, base(COLOR, false))),
            (
                Vec3::new(0.2399097, -0.3841617, 0.8915509),
                Vec3::new(-0.2399098, 0.3841617, 0.891551),
                Rgb::new(0.02709843, 0.07316577, 0.09755436),
                0.1965417,
            ),
        ),
        (
            Single::new("", plastic(1.33, base(COLOR, true))),
            (
                Vec3::new(-0.5070412, 0.1769346, 0.8435658),
                Vec3::new(-0.5670937, 0.2945749, 0.7691751),
                Rgb::new(0.01387277, 0.04090461, 0.05733371),
                0.2244942,
            ),
        ),
        (
            Single::new("", plastic(1.2, base(COLOR, false))),
            (
                Vec3::new(0.4808726, 0.3516064, 0.8032026),
                Vec3::new(0.6590333, -0.3718082, 0.6537842),
                Rgb::new(0.02122473, 0.05730677, 0.07640903),
                0.2000354,
            ),
        ),
    ];
    for (case, figure) in figures {
        assert_figure(&case, figure, 1.5e-3, 4e-3);
    }
}
