//! Materials in world space: textured parameters, two sides, blends, masks, normal and bump maps and nothing at all,
//! against the contract of `shading`, and against what the test makes of the plain models itself.

use crate::material_support;
use crate::material_support::{Case, Placed, all_cases, frame, random_direction, texel_uv, textured_models, world};
use crate::statistics::{assert_all_plausible, sphere_integral, sphere_p};
use glam::Vec3;
use sunroom::color::Rgb;
use sunroom::material::{Lobe, Material, MaterialId};
use sunroom::shading::Bsdf;

/// In the local frame: from overhead to grazing, and from behind.
fn viewers() -> [Vec3; 4] {
    [(15.0f32, 0.4f32), (70.0, 3.0), (115.0, 1.2), (160.0, 5.0)].map(|(theta, phi)| {
        let (sin, cos) = theta.to_radians().sin_cos();
        Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    })
}

/// Where a lobe is likely to have its peak, in the world.
fn peak(wo: Vec3) -> Vec3 {
    world(Vec3::new(-wo.x, -wo.y, wo.z))
}

/// Every case from every viewer.
fn for_each(mut check: impl FnMut(&Case, Vec3, &str)) {
    for case in all_cases() {
        for wo in viewers() {
            check(&case, wo, &format!("{} from {wo}", case.name));
        }
    }
}

#[test]
fn samples_follow_the_density() {
    let mut results = Vec::new();
    for_each(|case, wo, name| {
        let scattering = case.placed.scattering(wo);
        let smooth = |index| {
            let sample = case.placed.sample(&scattering, index);
            sample
                .filter(|sample| sample.lobe == Lobe::Smooth)
                .map(|sample| sample.wi)
        };
        let p = sphere_p(20_000, peak(wo), smooth, |wi| scattering.eval_and_pdf(wi).1);
        results.push((name.to_owned(), p));
    });
    assert_all_plausible(&results);
}

#[test]
fn weights_are_value_over_density() {
    for_each(|case, wo, name| {
        let scattering = case.placed.scattering(wo);
        for sample in (0..300).filter_map(|index| case.placed.sample(&scattering, index)) {
            let (value, pdf) = scattering.eval_and_pdf(sample.wi);
            if sample.lobe != Lobe::Smooth {
                assert!(sample.pdf <= 1.0 + 1e-6, "{name}: {sample:?}");
                continue;
            }
            // The half vectors of lobes a tenth wide carry relative errors of 1e-5, rotated into the world and back.
            assert!((pdf / sample.pdf - 1.0).abs() < 2e-3, "{name}: {sample:?} {pdf}");
            let error = (value / pdf - sample.weight).abs().max_element();
            assert!(error < 2e-3, "{name}: {sample:?} {value} {pdf}");
        }
    });
}

#[test]
fn mean_weight_is_the_integral_of_the_value() {
    for_each(|case, wo, name| {
        let scattering = case.placed.scattering(wo);
        let count = 20_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for index in 0..count {
            let sample = case.placed.sample(&scattering, index);
            let weight = sample.filter(|sample| sample.lobe == Lobe::Smooth);
            let weight = weight.map_or(0.0, |sample| f64::from(sample.weight.y));
            sum += weight;
            squares += weight * weight;
        }
        let mean = sum / f64::from(count);
        let variance = (squares / f64::from(count) - mean * mean).max(0.0);
        let deviation = (variance / f64::from(count)).sqrt();
        let integral = sphere_integral(peak(wo), |wi| scattering.eval_and_pdf(wi).0.y);
        // Five standard errors: 160 comparisons, a false alarm in 10,000. Plus that of the quadrature, which is poor
        // where bumps cut off.
        assert!(
            (mean - integral).abs() < 5.0 * deviation + 1e-3,
            "{name}: {mean}, {integral}"
        );
    });
}

#[test]
fn what_passes_straight_through_is_what_shadow_rays_find() {
    for_each(|case, wo, name| {
        let scattering = case.placed.scattering(wo);
        let count = 10_000;
        let mut passed = Rgb::ZERO;
        for sample in (0..count).filter_map(|index| case.placed.sample(&scattering, index)) {
            if sample.lobe == Lobe::Null {
                assert!((sample.wi + world(wo)).length() < 1e-5, "{name}: {sample:?}");
                passed += sample.weight / count as f32;
            }
        }
        let expected = (case.passing)(wo);
        assert!(
            (scattering.transmittance() - expected).abs().max_element() < 1e-5,
            "{name}: {} {expected}",
            scattering.transmittance()
        );
        // Five standard errors of a share, and the rounding of the sum.
        let variance = (expected * (Rgb::ONE - expected)).max(Rgb::ZERO).max_element();
        let tolerance = 5.0 * (variance / count as f32).sqrt() + 2e-4;
        let error = (passed - expected).abs().max_element();
        assert!(error <= tolerance, "{name}: {passed} {expected}");
    });
}

#[test]
fn no_energy_is_made() {
    for_each(|case, wo, name| {
        let scattering = case.placed.scattering(wo);
        let count = 20_000;
        let samples = (0..count).filter_map(|index| case.placed.sample(&scattering, index));
        let total = samples
            .map(|sample| sample.weight * (sample.eta * sample.eta))
            .sum::<Rgb>()
            / count as f32;
        // Weights of mixtures exceed 1 here and there: three standard errors of at most 0.6 / sqrt(count) each.
        assert!(total.max_element() < 1.0 + 0.013, "{name}: {total}");
        if case.is_white {
            assert!(total.min_element() > 1.0 - 0.013, "{name}: {total}");
        }
    });
}

#[test]
fn values_are_those_of_the_parts() {
    for_each(|case, wo, name| {
        let scattering = case.placed.scattering(wo);
        for index in 0..200 {
            let wi = random_direction(index);
            let (value, _) = scattering.eval_and_pdf(world(wi));
            let expected = (case.value)(wo, wi);
            // Into the world and back: lobes a tenth wide change by 1e-4 in that many roundings.
            let error = (value - expected).abs().max_element();
            assert!(
                error <= 2e-4 * expected.max_element() + 1e-6,
                "{name} to {wi}: {value} {expected}"
            );
        }
    });
}

/// Light on its way back loses as much. Radiance is compressed by the squared index; a normal map is reciprocal about
/// its own normal, once the shadowing, which depends on the light's side only, is taken out.
#[test]
fn light_takes_the_way_back() {
    let mut compared = 0;
    for case in all_cases() {
        let Some(about) = &case.reciprocal_about else { continue };
        for index in 0..400 {
            let (a, b) = (random_direction(2 * index), random_direction(2 * index + 1));
            let normal = about.normal;
            let sides_agree = |v: Vec3| v.z * v.dot(normal) > 0.0;
            // Seen from where the two normals disagree there is no way back.
            if !(sides_agree(a) && sides_agree(b)) {
                continue;
            }
            let value = |wo: Vec3, wi: Vec3| {
                let (value, _) = case.placed.scattering(wo).eval_and_pdf(world(wi));
                let index = if wi.z > 0.0 { 1.0 } else { about.eta };
                value * (index * index) / (wi.dot(normal).abs() * about.shadowing(wi))
            };
            let (forth, back) = (value(a, b), value(b, a));
            let error = (forth - back).abs().max_element();
            assert!(
                error <= 2e-3 * forth.max_element() + 1e-6,
                "{} {a} {b}: {forth} {back}",
                case.name
            );
            compared += usize::from(forth.max_element() > 1e-3);
        }
    }
    assert!(compared > 3000, "{compared}");
}

#[test]
fn the_half_space_holds_all_that_is_seen() {
    for_each(|case, wo, name| {
        let scattering = case.placed.scattering(wo);
        let Some(normal) = scattering.one_sided_normal() else {
            return;
        };
        for index in 0..400 {
            let wi = world(random_direction(index));
            let (value, pdf) = scattering.eval_and_pdf(wi);
            assert!(wi.dot(normal) > 0.0 || (value, pdf) == (Rgb::ZERO, 0.0), "{name} {wi}");
        }
    });
}

/// Values out of range in the pictures are brought into it.
#[test]
fn textured_models_are_the_plain_ones_of_the_values_there() {
    for (x, y) in [(0, 0), (1, 0), (2, 1), (3, 2), (1, 3), (2, 3)] {
        for (textured, plain) in textured_models(x, y) {
            let name = format!("{plain:?} at {x} {y}");
            let [textured, plain] = [Material::Textured(textured), Material::Plain(plain)].map(|material| {
                let mut placed = Placed::new(vec![material]);
                placed.uv = texel_uv(x, y);
                placed
            });
            for wo in viewers() {
                let [found, expected] = [&textured, &plain].map(|placed| placed.scattering(wo));
                assert_eq!(found.albedo(), expected.albedo(), "{name}");
                assert_eq!(found.transmittance(), expected.transmittance(), "{name}");
                for index in 0..20 {
                    let wi = world(random_direction(index));
                    assert_eq!(found.eval_and_pdf(wi), expected.eval_and_pdf(wi), "{name}");
                    let samples = [(&textured, &found), (&plain, &expected)].map(|(placed, s)| placed.sample(s, index));
                    assert_eq!(samples[0], samples[1], "{name}");
                }
            }
        }
    }
}

#[test]
fn the_frame_is_the_surfaces_own() {
    // What the other tests take for granted: z is the shading normal, x goes along dp_du.
    let point = Placed::new(vec![Material::Null]).surface();
    let frame = frame();
    assert_eq!(frame.n, point.shading_normal);
    assert!(frame.s.dot(point.dp_du) > 0.0 && frame.t.dot(point.dp_du).abs() < 1e-6);
    assert!((frame.s.cross(frame.t) - frame.n).length() < 1e-6);
}

#[test]
fn materials_that_cannot_be_are_refused() {
    use sunroom::material::{BumpOptions, MaterialTable, NestingProblem};
    use sunroom::texture::Parameter;
    let id = MaterialId;
    let mask = |nested| Material::Mask {
        nested,
        opacity: Parameter::Constant(0.5),
    };
    let blend = |first, second| Material::Blend {
        first,
        second,
        weight: Parameter::Constant(0.5),
    };
    let problem = |materials| MaterialTable::new(materials).unwrap_err().problem;
    assert_eq!(problem(vec![mask(id(0))]), NestingProblem::TooDeep);
    assert_eq!(problem(vec![mask(id(1)), mask(id(0))]), NestingProblem::TooDeep);
    assert_eq!(
        problem(vec![Material::Null, mask(id(2))]),
        NestingProblem::OutOfRange(2, 2)
    );
    let diffuse = material_support::diffuse(Rgb::ONE);
    let mixes = |doublings: u32| {
        let mut list = vec![Material::Plain(diffuse)];
        list.extend((0..doublings).map(|i| blend(id(i), id(i))));
        list
    };
    assert!(MaterialTable::new(mixes(3)).is_ok());
    let has_table = |bsdf: &Bsdf| match bsdf {
        Bsdf::RoughPlastic(_) => true,
        Bsdf::RoughConductor(rough) => rough.multiple_scattering.table().is_some(),
        _ => false,
    };
    let models = textured_models(0, 0).into_iter();
    for (textured, plain) in models.filter(|(_, plain)| has_table(plain)) {
        for material in [Material::Textured(textured), Material::Plain(plain)] {
            assert_eq!(problem(vec![material.clone()]), NestingProblem::NoTable);
            assert!(MaterialTable::with_tables(vec![material], material_support::tables()).is_ok());
        }
    }
    assert_eq!(problem(mixes(4)), NestingProblem::TooManyParts);
    let maps = |count: u32, flip_invalid_normals: bool| {
        let mut list = vec![Material::Plain(diffuse)];
        list.extend((0..count).map(|i| Material::NormalMap {
            nested: id(i),
            normals: Parameter::Constant(Rgb::new(0.6, 0.5, 0.9)),
            gltf_tangents: false,
            options: BumpOptions {
                flip_invalid_normals,
                use_shadowing_function: true,
            },
        }));
        list
    };
    assert!(MaterialTable::new(maps(8, true)).is_ok() && MaterialTable::new(maps(20, false)).is_ok());
    assert_eq!(problem(maps(9, true)), NestingProblem::TooManyMaps);
}
