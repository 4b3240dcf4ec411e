//! Mirrors, smooth glass and panes: models whose every lobe is one direction. Lobes are chosen as often as they say, no
//! energy is made, light loses as much on its way back.

use crate::bsdf_support::{Single, assert_unscaled, direction, mirror};
use crate::statistics::{assert_all_plausible, chi_squared_p};
use glam::{Vec2, Vec3};
use sunroom::color::Rgb;
use sunroom::shading::{
    Bsdf, BsdfSample, CoatedBase, Conductor, ConductorSpecular, Dielectric, DielectricModel, Metal, Onward, Plastic,
    SmoothCoat, ThinDielectric, fresnel, ior,
};

const PALE: Rgb = Rgb::new(1.0, 0.8, 0.5);
const GREEN: Rgb = Rgb::new(0.2, 0.9, 0.4);

/// At least five settings each.
fn cases() -> Vec<Single> {
    let mut cases = Vec::new();
    let mut add = |name: String, bsdf| cases.push(Single::new(&name, bsdf));
    for (material, specular_reflectance) in [
        ("none", Rgb::ONE),
        ("Au", Rgb::ONE),
        ("Cu", GREEN),
        ("Al", PALE),
        ("a-C", Rgb::ZERO),
    ] {
        let (eta, k) = ior::conductor_ior(material).expect("a known material");
        let specular = ConductorSpecular {
            eta,
            k,
            specular_reflectance,
        };
        add(format!("conductor {material}"), Bsdf::Conductor(Conductor { specular }));
    }
    for (color, fuzz) in [
        (Rgb::ONE, 0.0),
        (PALE, 0.0),
        (GREEN, 1e-5),
        (Rgb::X, 0.0),
        (Rgb::ZERO, 0.0),
    ] {
        add(format!("metal {color} {fuzz}"), Bsdf::Metal(Metal { color, fuzz }));
    }
    for (eta, model, specular_reflectance, specular_transmittance) in [
        (1.5046, DielectricModel::Exact, Rgb::ONE, Rgb::ONE),
        (1.333, DielectricModel::Exact, PALE, GREEN),
        (2.419, DielectricModel::Schlick, GREEN, Rgb::ONE),
        (0.7, DielectricModel::Exact, Rgb::ONE, PALE),
        (1.000_277, DielectricModel::Exact, Rgb::ZERO, PALE),
        (0.9, DielectricModel::Schlick, Rgb::ONE, Rgb::ONE),
    ] {
        let name = format!("{eta} {model:?} {specular_reflectance} {specular_transmittance}");
        let solid = Dielectric {
            eta,
            model,
            specular_reflectance,
            specular_transmittance,
        };
        add(format!("dielectric {name}"), Bsdf::Dielectric(solid));
        let thin = ThinDielectric {
            eta,
            model,
            specular_reflectance,
            specular_transmittance,
        };
        add(format!("thindielectric {name}"), Bsdf::ThinDielectric(thin));
    }
    cases
}

/// The relative index that light meets which goes to `wo`.
fn eta(case: &Single) -> f32 {
    match case.bsdf {
        Bsdf::Dielectric(glass) => glass.eta,
        _ => 1.0,
    }
}

fn viewers() -> Vec<Vec3> {
    [2.0, 35.0, 62.0, 80.0, 98.0, 125.0, 170.0]
        .map(|degrees| direction(degrees, 0.3 * degrees))
        .to_vec()
}

/// Every lobe there is: the first of all numbers, and the last of all.
fn lobes(case: &Single, wo: Vec3) -> Vec<BsdfSample> {
    let mut lobes: Vec<BsdfSample> = Vec::new();
    for u_lobe in [0.0, 1.0f32.next_down()] {
        let sample = case.sample_by(wo, u_lobe, Vec2::splat(0.5));
        lobes.extend(sample.filter(|sample| !lobes.contains(sample)));
    }
    lobes
}

/// What a lobe brings of the light that arrives from its direction.
fn share(lobe: &BsdfSample) -> Rgb {
    lobe.weight * lobe.pdf
}

#[test]
fn lobes_are_chosen_as_often_as_they_say() {
    let count = 20_000;
    let mut results = Vec::new();
    for case in cases() {
        for wo in viewers() {
            let lobes = lobes(&case, wo);
            if let Bsdf::Dielectric(glass) = case.bsdf {
                let reflectance = fresnel::dielectric(wo.z, glass.eta, glass.model).reflectance;
                assert!((lobes[0].pdf - reflectance).abs() < 1e-6, "{} {wo}", case.name);
            }
            let mut counted = vec![0.0; lobes.len() + 1];
            for index in 0..count {
                let sample = case.sample(wo, index);
                let lobe = sample.and_then(|sample| lobes.iter().position(|&lobe| lobe == sample));
                assert_eq!(sample.is_some(), lobe.is_some(), "{}: a lobe of its own", case.name);
                counted[lobe.unwrap_or(lobes.len())] += 1.0;
            }
            let mut expected: Vec<f64> = lobes.iter().map(|lobe| f64::from(lobe.pdf)).collect();
            expected.push((1.0 - expected.iter().sum::<f64>()).max(0.0));
            expected.iter_mut().for_each(|share| *share *= f64::from(count));
            results.push((format!("{} from {wo}", case.name), chi_squared_p(&counted, &expected)));
        }
    }
    assert_all_plausible(&results);
}

/// A view that knows neither roughness nor refraction goes on only where paths do: the backs of metals are black.
#[test]
fn views_go_on_where_paths_do() {
    let mut backs = 0;
    for case in cases() {
        for wo in viewers().into_iter().flat_map(|wo| [wo, -wo]) {
            let is_black = (0..64).all(|index| case.sample(wo, index).is_none_or(|lobe| lobe.weight == Rgb::ZERO));
            let onward = case.bsdf.onward(wo);
            if is_black {
                let is_dark = matches!(onward, None | Some(Onward::Mirrored(Rgb::ZERO)));
                assert!(is_dark, "{} from {wo}: {onward:?}", case.name);
                backs += u32::from(wo.z < 0.0);
            } else if let Bsdf::Conductor(_) | Bsdf::Metal(_) = case.bsdf {
                assert!(matches!(onward, Some(Onward::Mirrored(_))), "{} from {wo}", case.name);
            }
        }
    }
    assert!(backs > 20, "{backs}");
}

#[test]
fn importance_is_not_scaled_by_refraction() {
    for case in cases() {
        for wo in viewers() {
            for u_lobe in [0.0, 1.0f32.next_down()] {
                if case.sample_by(wo, u_lobe, Vec2::splat(0.5)).is_some() {
                    assert_unscaled(&case, wo, u_lobe, Vec2::splat(0.5));
                }
            }
        }
    }
}

#[test]
fn lobes_have_no_density() {
    for case in cases() {
        assert!(!case.bsdf.has_smooth_lobe(), "{}", case.name);
        for wo in viewers() {
            for lobe in lobes(&case, wo) {
                assert!(lobe.is_delta, "{}", case.name);
                assert_eq!((case.eval(wo, lobe.wi), case.pdf(wo, lobe.wi)), (Rgb::ZERO, 0.0));
            }
        }
    }
}

#[test]
fn no_energy_is_made_nor_lost() {
    for case in cases() {
        for wo in viewers() {
            let lobes = lobes(&case, wo);
            let power: Rgb = lobes.iter().map(|lobe| share(lobe) * (lobe.eta * lobe.eta)).sum();
            assert!(power.max_element() <= 1.0 + 1e-5, "{} {wo}: {power}", case.name);
            // Without a tint nothing is lost but what metals absorb.
            let (reflectance, transmittance) = match case.bsdf {
                Bsdf::Dielectric(glass) => (glass.specular_reflectance, glass.specular_transmittance),
                Bsdf::ThinDielectric(pane) => (pane.specular_reflectance, pane.specular_transmittance),
                _ => continue,
            };
            let reflected: f32 = lobes
                .iter()
                .filter(|lobe| lobe.wi == mirror(wo))
                .map(|lobe| lobe.pdf)
                .sum();
            let expected = reflected * reflectance + (1.0 - reflected) * transmittance;
            assert!(
                (power - expected).abs().max_element() < 1e-5,
                "{} {wo}: {power} {expected}",
                case.name
            );
        }
    }
}

/// Of two ends of a path each sees the other by the same share of power; radiance is compressed by the squared index.
#[test]
fn light_takes_the_way_back() {
    for case in cases() {
        for wo in viewers() {
            for lobe in lobes(&case, wo) {
                let back = lobes(&case, lobe.wi)
                    .into_iter()
                    .find(|back| (back.wi - wo).length() < 2e-3)
                    .unwrap_or_else(|| panic!("{} {wo}: no way back from {}", case.name, lobe.wi));
                assert!((lobe.eta * back.eta - 1.0).abs() < 1e-5, "{}", case.name);
                let [forth, back] = [lobe, back].map(|lobe| share(&lobe) * (lobe.eta * lobe.eta));
                // The way back takes the cosine from the sine again: at 80 degrees three digits are left of the
                // transmittance at grazing.
                assert!(
                    (forth - back).abs().max_element() < 1e-3,
                    "{} {wo}: {forth} {back}",
                    case.name
                );
            }
        }
    }
}

#[test]
fn directions_are_mirrored_refracted_or_straight_on() {
    for case in cases() {
        for wo in viewers() {
            let lobes = lobes(&case, wo);
            let is_opaque = matches!(case.bsdf, Bsdf::Conductor(_) | Bsdf::Metal(_));
            assert_eq!(lobes.is_empty(), is_opaque && wo.z < 0.0, "{} {wo}", case.name);
            for lobe in lobes {
                if lobe.wi.z * wo.z > 0.0 {
                    assert_eq!((lobe.wi, lobe.eta), (mirror(wo), 1.0), "{}", case.name);
                    continue;
                }
                // Snell: the tangential parts go with the indices. A pane bends light back again.
                let relative = if wo.z > 0.0 { eta(&case) } else { eta(&case).recip() };
                let snell = wo.truncate() + relative * lobe.wi.truncate();
                assert!(
                    snell.length() < 1e-5 && (lobe.eta - relative).abs() < 1e-5,
                    "{} {wo}",
                    case.name
                );
            }
        }
    }
}

/// The mirror on a coat keeps the same laws, beside a base that scatters.
#[test]
fn mirrors_of_coats_are_reciprocal_and_tinted() {
    for (eta, specular_reflectance) in [(1.49, Rgb::ONE), (1.9, PALE), (1.33, GREEN), (0.8, PALE), (2.4, Rgb::Y)] {
        let base = |specular_reflectance| CoatedBase {
            diffuse_reflectance: Rgb::splat(0.4),
            nonlinear: true,
            specular_reflectance,
        };
        let [tinted, plain] = [specular_reflectance, Rgb::ONE].map(|specular_reflectance| {
            let coat = SmoothCoat::new(eta);
            Single::new(
                "plastic",
                Bsdf::Plastic(Plastic {
                    coat,
                    base: base(specular_reflectance),
                }),
            )
        });
        for wo in viewers().into_iter().filter(|wo| wo.z > 0.0) {
            let mirrored = |case: &Single, wo| {
                let lobe = case
                    .sample_by(wo, 0.0, Vec2::splat(0.5))
                    .filter(|sample| sample.is_delta);
                lobe.map_or(Rgb::ZERO, |lobe| share(&lobe))
            };
            let (forth, back) = (mirrored(&tinted, wo), mirrored(&tinted, mirror(wo)));
            assert!((forth - back).abs().max_element() < 1e-6, "{eta} {wo}");
            let expected = specular_reflectance * mirrored(&plain, wo);
            assert!(
                (forth - expected).abs().max_element() < 1e-5,
                "{eta} {wo}: {forth} {expected}"
            );
        }
    }
}
