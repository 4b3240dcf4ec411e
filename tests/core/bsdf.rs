//! Every scattering model against the contract of `shading`: samples follow the density, weights are f cos / pdf, no
//! energy is made, reciprocity where it holds; Fresnel and Snell against known figures; and figures of another
//! renderer.

use crate::bsdf_support::{
    Single, assert_finite, assert_mean_weight, assert_reciprocal, assert_weights, density_p_values, direction, mirror,
};
use crate::statistics::{assert_all_plausible, sphere_integral};
use glam::{Vec2, Vec3};
use sunroom::color::Rgb;
use sunroom::shading::{
    Bsdf, Compensation, Conductor, ConductorSpecular, Dielectric, DielectricModel, Diffuse, Metal, Microfacet,
    MicrofacetKind, RoughConductor, fresnel, ior,
};

fn specular(material: &str) -> ConductorSpecular {
    let (eta, k) = ior::conductor_ior(material).expect("a known material");
    ConductorSpecular {
        eta,
        k,
        specular_reflectance: Rgb::ONE,
    }
}

fn rough(material: &str, alpha_x: f32, alpha_y: f32) -> Bsdf {
    Bsdf::RoughConductor(RoughConductor {
        specular: specular(material),
        distribution: Microfacet::new(MicrofacetKind::Ggx, alpha_x, alpha_y),
        multiple_scattering: Compensation::NONE,
    })
}

fn dielectric(eta: f32, model: DielectricModel) -> Bsdf {
    Bsdf::Dielectric(Dielectric {
        eta,
        model,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    })
}

fn metal(fuzz: f32) -> Bsdf {
    Bsdf::Metal(Metal {
        color: Rgb::new(1.0, 0.8, 0.5),
        fuzz,
    })
}

fn diffuse(reflectance: Rgb) -> Bsdf {
    Bsdf::Diffuse(Diffuse { reflectance })
}

/// Models with a density, at least five settings each.
fn smooth_cases() -> Vec<Single> {
    let mut cases = Vec::new();
    for reflectance in [
        Rgb::ONE,
        Rgb::splat(0.5),
        Rgb::new(0.9, 0.1, 0.0),
        Rgb::splat(1e-3),
        Rgb::new(0.0, 0.0, 1.0),
    ] {
        cases.push(Single::new(&format!("diffuse {reflectance}"), diffuse(reflectance)));
    }
    for (material, alpha_x, alpha_y) in [
        ("none", 0.03, 0.03),
        ("Au", 0.1, 0.1),
        ("Cu", 0.3, 0.3),
        ("Al", 0.6, 0.6),
        ("none", 1.0, 1.0),
        ("Cr", 0.1, 0.4),
    ] {
        cases.push(Single::new(
            &format!("roughconductor {material} {alpha_x} {alpha_y}"),
            rough(material, alpha_x, alpha_y),
        ));
    }
    for fuzz in [0.02, 0.1, 0.3, 0.7, 1.0] {
        cases.push(Single::new(&format!("metal {fuzz}"), metal(fuzz)));
    }
    cases
}

/// Viewers from overhead to grazing.
const VIEWERS: [(f32, f32); 4] = [(0.0, 0.0), (30.0, 1.0), (60.0, 4.0), (85.0, 2.5)];

fn viewers() -> Vec<Vec3> {
    VIEWERS.iter().map(|&(theta, phi)| direction(theta, phi)).collect()
}

#[test]
fn samples_follow_the_density() {
    let results: Vec<_> = smooth_cases()
        .iter()
        .flat_map(|case| density_p_values(case, &viewers()))
        .collect();
    assert_all_plausible(&results);
}

/// The rounding of half vector and chord: relative to the lobe's width. A lobe of width w takes relative errors of 1e-7
/// / w^2 at most.
fn relative_rounding(case: &Single) -> f32 {
    if case.name.contains("0.02") || case.name.contains("0.03") {
        5e-3
    } else {
        1e-3
    }
}

#[test]
fn weights_are_value_over_density() {
    for case in smooth_cases() {
        assert_weights(&case, &viewers(), relative_rounding(&case));
    }
}

#[test]
fn mean_weight_is_the_integral_of_the_value() {
    for case in smooth_cases() {
        assert_mean_weight(&case, &viewers());
    }
}

#[test]
fn no_energy_is_made() {
    for case in smooth_cases() {
        for wo in viewers() {
            for sample in (0..2000).filter_map(|i| case.sample(wo, i)) {
                assert!(
                    sample.weight.max_element() <= 1.0 + 1e-5,
                    "{} {wo}: {}",
                    case.name,
                    sample.weight
                );
            }
            assert!(
                sphere_integral(mirror(wo), |wi| case.pdf(wo, wi)) < 1.0 + 1e-3,
                "{}",
                case.name
            );
        }
    }
    // White in a white furnace: what goes in comes out, sample by sample.
    let white = [
        Single::new("diffuse", diffuse(Rgb::ONE)),
        Single::new(
            "conductor",
            Bsdf::Conductor(Conductor {
                specular: specular("none"),
            }),
        ),
        Single::new("dielectric", dielectric(1.5, DielectricModel::Exact)),
    ];
    for case in white {
        for (i, wo) in [direction(5.0, 0.0), direction(40.0, 1.0), direction(80.0, 2.0)]
            .into_iter()
            .enumerate()
        {
            let sample = case.sample(wo, i as u32).expect("nothing is absorbed");
            let power = sample.weight * sample.eta * sample.eta;
            assert!((power - Rgb::ONE).abs().max_element() < 1e-6, "{}: {power}", case.name);
        }
    }
    // A rough mirror loses only what its second bounce would bring: nothing head on, little when smooth.
    let smooth = Single::new("", rough("none", 0.05, 0.05));
    let lost = 1.0 - sphere_integral(Vec3::Z, |wi| smooth.eval(Vec3::Z, wi).x);
    assert!((0.0..0.01).contains(&lost), "{lost}");
}

#[test]
fn value_is_reciprocal() {
    for case in &smooth_cases() {
        let Bsdf::Metal(_) = case.bsdf else {
            assert_reciprocal(case);
            continue;
        };
        // The fuzzy metal is a process, not a physical reflectance. Its density depends on the angle to the mirror
        // image alone, which is the same both ways: f |cos wi| is symmetric in place of f.
        for wo in viewers() {
            for sample in (0..200).filter_map(|i| case.sample(wo, i)) {
                let (forth, back) = (case.eval(wo, sample.wi), case.eval(sample.wi, wo));
                // At the rim of the lobe the root of a difference: half of the digits.
                let error = (forth - back).abs().max_element();
                assert!(
                    error <= 1e-3 * case.eval(wo, mirror(wo)).max_element(),
                    "{} {wo}: {forth} {back}",
                    case.name
                );
            }
        }
    }
}

#[test]
fn one_sided_models_are_black_from_behind() {
    let delta = Bsdf::Conductor(Conductor {
        specular: specular("Au"),
    });
    for bsdf in [diffuse(Rgb::ONE), rough("Au", 0.3, 0.3), metal(0.5), metal(0.0), delta] {
        let case = Single::new("", bsdf);
        let (above, below) = (direction(40.0, 1.0), direction(130.0, 2.0));
        for wo in [below, direction(90.0, 0.0).with_z(0.0)] {
            assert!((0..50).all(|i| case.sample(wo, i).is_none()));
            assert_eq!((case.eval(wo, above), case.pdf(wo, above)), (Rgb::ZERO, 0.0));
        }
        assert_eq!((case.eval(above, below), case.pdf(above, below)), (Rgb::ZERO, 0.0));
    }
}

#[test]
fn grazing_and_extreme_input_gives_numbers() {
    let bsdfs = [
        rough("Au", 0.0, 0.0),
        rough("Au", 1e-3, 1.0),
        rough("none", 1.0, 1.0),
        metal(1e-4),
        metal(1.0),
        metal(7.0),
        dielectric(1.0, DielectricModel::Exact),
        dielectric(1e-3, DielectricModel::Exact),
        dielectric(1.5, DielectricModel::Schlick),
        dielectric(1.0 + f32::EPSILON, DielectricModel::Exact),
    ];
    for bsdf in bsdfs {
        assert_finite(&Single::new(&format!("{bsdf:?}"), bsdf));
    }
}

#[test]
fn dielectric_reflectance_has_the_known_figures() {
    let reflectance = |cos, eta| fresnel::dielectric(cos, eta, DielectricModel::Exact).reflectance;
    let close = |a: f32, b: f32| (a - b).abs() < 1e-6;
    assert!(close(reflectance(1.0, 1.5), 0.04));
    assert!(close(reflectance(-1.0, 1.5), 0.04));
    assert!(close(reflectance(1.0, 1.333), (0.333f32 / 2.333).powi(2)));
    // Brewster's angle, tan = eta: no p wave, and the s amplitude is cos(2 Brewster).
    let brewster = 1.5f32.atan();
    assert!(close(
        reflectance(brewster.cos(), 1.5),
        0.5 * (2.0 * brewster).cos().powi(2)
    ));
    assert_eq!(reflectance(0.0, 1.5), 1.0);
    assert_eq!(reflectance(0.3, 1.0), 0.0);
    // Total internal reflection sets in where sin = 1 / eta: 41.8103 degrees for 1.5.
    let inside = |degrees: f32| reflectance(-degrees.to_radians().cos(), 1.5);
    assert_eq!(inside(41.9), 1.0);
    assert_eq!(inside(80.0), 1.0);
    assert!(inside(41.7) < 0.9);
    // Both ways alike.
    for degrees in [10.0f32, 30.0, 50.0, 70.0, 85.0] {
        for model in [DielectricModel::Exact, DielectricModel::Schlick] {
            let outside = fresnel::dielectric(degrees.to_radians().cos(), 1.5, model);
            let back = fresnel::dielectric(outside.cos_t, 1.5, model);
            assert!(
                (outside.reflectance - back.reflectance).abs() < 2e-5,
                "{model:?} {degrees}"
            );
            let exact = fresnel::dielectric(degrees.to_radians().cos(), 1.5, DielectricModel::Exact);
            // Schlick's approximation is within a few percent of full scale for glass.
            assert!(
                (outside.reflectance - exact.reflectance).abs() < 0.06,
                "{model:?} {degrees}"
            );
        }
    }
}

#[test]
fn refraction_follows_snell_and_keeps_reciprocity() {
    let last = 1.0f32.next_down();
    for eta in [1.333, 1.5046, 2.419, 0.7, 1.000_277] {
        for model in [DielectricModel::Exact, DielectricModel::Schlick] {
            let case = Single::new("dielectric", dielectric(eta, model));
            let sample = |wo, u_lobe| {
                case.sample_by(wo, u_lobe, Vec2::splat(0.5))
                    .expect("glass absorbs nothing")
            };
            for degrees in [1.0, 20.0, 45.0, 70.0, 89.0, 100.0, 140.0, 175.0] {
                let wo = direction(degrees, 0.8);
                let relative = if wo.z > 0.0 { eta } else { 1.0 / eta };
                let reflected = sample(wo, 0.0);
                assert_eq!(
                    (reflected.wi, reflected.eta, reflected.weight),
                    (mirror(wo), 1.0, Rgb::ONE)
                );
                let refracted = sample(wo, last);
                if wo.truncate().length() > relative {
                    assert_eq!(refracted, reflected, "total internal reflection");
                    assert_eq!(reflected.pdf, 1.0);
                    continue;
                }
                assert!(refracted.wi.z * wo.z < 0.0, "{eta} {degrees}");
                assert!((refracted.pdf + reflected.pdf - 1.0).abs() < 1e-6);
                assert!((refracted.eta - relative).abs() < 1e-6);
                assert!(
                    (wo.truncate() + relative * refracted.wi.truncate()).length() < 1e-6,
                    "not Snell"
                );
                assert!((refracted.weight * relative * relative - Rgb::ONE).abs().max_element() < 1e-5);
                // Back through the interface: the same transmittance, radiance scaled the other way round. The way back
                // squares the sine again: cosines of 0.017 keep three digits.
                let back = sample(refracted.wi, last);
                assert!((back.wi - wo).length() < 1e-3 && (back.pdf - refracted.pdf).abs() < 1e-3);
                assert!((back.weight * refracted.weight - Rgb::ONE).abs().max_element() < 1e-5);
                for delta in [reflected, refracted] {
                    assert!(delta.is_delta);
                    assert_eq!((case.eval(wo, delta.wi), case.pdf(wo, delta.wi)), (Rgb::ZERO, 0.0));
                }
            }
        }
    }
}

#[test]
fn mirrors_reflect_about_the_normal() {
    let conductor = Bsdf::Conductor(Conductor {
        specular: ConductorSpecular {
            specular_reflectance: Rgb::new(1.0, 0.5, 0.25),
            ..specular("none")
        },
    });
    for (bsdf, color) in [
        (conductor, Rgb::new(1.0, 0.5, 0.25)),
        (metal(0.0), Rgb::new(1.0, 0.8, 0.5)),
    ] {
        let case = Single::new("mirror", bsdf);
        let wo = direction(50.0, 1.0);
        let sample = case.sample(wo, 0).expect("seen from the front");
        assert_eq!((sample.wi, sample.is_delta, sample.pdf), (mirror(wo), true, 1.0));
        assert!((sample.weight - color).abs().max_element() < 1e-6);
        assert!((case.bsdf.albedo() - color).abs().max_element() < 1e-6);
        assert_eq!((case.eval(wo, sample.wi), case.pdf(wo, sample.wi)), (Rgb::ZERO, 0.0));
        assert!(!case.bsdf.has_smooth_lobe());
    }
}

#[test]
fn conductor_without_extinction_is_a_dielectric() {
    for cos in [0.01, 0.2, 0.5547, 0.8, 1.0] {
        let conductor = fresnel::conductor(cos, Rgb::new(1.5, 1.333, 2.4), Rgb::ZERO);
        for (channel, eta) in [1.5, 1.333, 2.4].into_iter().enumerate() {
            let dielectric = fresnel::dielectric(cos, eta, DielectricModel::Exact).reflectance;
            assert!(
                (conductor[channel] - dielectric).abs() < 2e-5,
                "{cos} {eta}: {conductor} {dielectric}"
            );
        }
    }
    for cos in [0.0, 0.3, 1.0] {
        assert_eq!(
            fresnel::conductor(cos, Rgb::ZERO, Rgb::ONE),
            Rgb::ONE,
            "the material none"
        );
        assert!(fresnel::conductor(cos, Rgb::ZERO, Rgb::ZERO).is_finite());
        assert!(fresnel::conductor(cos, Rgb::ONE, Rgb::ZERO).is_finite());
    }
}

#[test]
fn materials_are_found_by_name() {
    assert_eq!(ior::dielectric_ior("bk7"), Some(1.5046));
    assert_eq!(ior::dielectric_ior("Water"), Some(1.333));
    assert_eq!(ior::dielectric_ior("carbon dioxide"), Some(1.000_45));
    assert_eq!(ior::dielectric_ior("unobtainium"), None);
    assert_eq!(ior::conductor_ior("none"), Some((Rgb::ZERO, Rgb::ONE)));
    assert_eq!(ior::conductor_ior("Mo_palik"), ior::conductor_ior("Mo"));
    assert_ne!(ior::conductor_ior("Cu_palik"), ior::conductor_ior("Cu"));
    assert!(ior::conductor_ior("Na_palik").is_some());
    assert_eq!(ior::conductor_ior("Unobtainium"), None);
    assert_eq!(ior::conductor_ior("_palik"), None);
    for (name, eta, k) in ior::CONDUCTORS {
        let reflectance = fresnel::conductor(1.0, eta, k);
        assert!(
            reflectance.min_element() >= 0.0 && reflectance.max_element() <= 1.0,
            "{name}"
        );
    }
    // Gold is yellow, copper red, silver nearly white.
    let color = |name| {
        let (eta, k) = ior::conductor_ior(name).expect("a known material");
        fresnel::conductor(1.0, eta, k)
    };
    assert!(color("Au").x > 0.9 && color("Au").z < 0.5 && color("Cu").y < 0.7 && color("Ag").min_element() > 0.85);
}

/// Value and density as Mitsuba 3.9.1 (variant `scalar_rgb`) gives them at some directions; 2,700 such figures agreed
/// to 3e-6.
#[test]
fn figures_agree_with_mitsuba() {
    let figures = [
        (
            diffuse(Rgb::new(0.5, 0.2, 0.9)),
            Vec3::new(-0.8571855, -0.34070706, 0.38620168),
            Vec3::new(-0.47514448, -0.15556692, 0.86604655),
            Vec3::new(0.13783558, 0.055134237, 0.24810404),
            0.27567115,
        ),
        (
            rough("Au", 0.1, 0.1),
            Vec3::new(-0.77605027, -0.5881888, 0.22755192),
            Vec3::new(0.7970377, 0.5609681, 0.22370873),
            Vec3::new(12.465424, 11.067555, 6.8481507),
            13.573256,
        ),
        (
            rough("Cu", 0.3, 0.3),
            Vec3::new(0.024533523, -0.85263604, 0.52192897),
            Vec3::new(0.29785347, 0.9536045, 0.043838054),
            Vec3::new(0.028543647, 0.019831622, 0.01749116),
            0.11982237,
        ),
        (
            rough("none", 0.7, 0.7),
            Vec3::new(-0.9463649, -0.28055075, 0.1602647),
            Vec3::new(0.60936475, -0.30885974, 0.7302605),
            Vec3::new(0.1780151, 0.1780151, 0.1780151),
            0.19540197,
        ),
        (
            rough("W", 0.1, 0.4),
            Vec3::new(-0.31271133, -0.9412138, 0.12778176),
            Vec3::new(0.3157421, 0.91180956, 0.26250735),
            Vec3::new(2.6386752, 2.5558457, 2.522534),
            7.045844,
        ),
        (
            rough("Ag", 0.02, 0.02),
            Vec3::new(-0.09972554, -0.91383606, 0.3936477),
            Vec3::new(0.11636577, 0.90339553, 0.41271728),
            Vec3::new(79.34816, 78.13473, 74.94166),
            81.977356,
        ),
        (
            rough("Hg", 0.5, 0.05),
            Vec3::new(0.9876626, -0.14295779, 0.06391854),
            Vec3::new(0.005082679, 0.44799846, 0.8940199),
            Vec3::new(0.020566849, 0.019461002, 0.019318335),
            0.025496705,
        ),
    ];
    for (bsdf, wo, wi, value, pdf) in figures {
        let case = Single::new("", bsdf);
        let ratios = [case.eval(wo, wi) / value, Rgb::splat(case.pdf(wo, wi) / pdf)];
        let error = ratios.map(|ratio| (ratio - Rgb::ONE).abs().max_element());
        assert!(error[0].max(error[1]) < 1e-5, "{bsdf:?} {wo} {wi}: off by {error:?}");
    }
    let reflectances = [
        ("Au", 0.064486414, Vec3::new(0.9814122, 0.94562066, 0.80137527)),
        ("Cu", 0.12038062, Vec3::new(0.9576261, 0.79641116, 0.7555344)),
        ("Al", 0.44353938, Vec3::new(0.90845674, 0.8987272, 0.9032988)),
        ("TiO2", 0.20780244, Vec3::new(0.39929947, 0.39134842, 0.3926753)),
        ("a-C", 0.05984565, Vec3::new(0.69888914, 0.7306869, 0.7441374)),
    ];
    for (material, cos, reflectance) in reflectances {
        let ours = specular(material).reflectance(cos);
        assert!(
            (ours - reflectance).abs().max_element() < 1e-6,
            "{material} {cos}: {ours}"
        );
    }
}
