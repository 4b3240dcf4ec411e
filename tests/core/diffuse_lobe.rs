//! The diffuse lobes of models: the numbers that choose them, and their part of the density.

use std::f32::consts::FRAC_1_PI;

use crate::bsdf_support::direction;
use crate::principled_cases::{PRINCIPLED, principled_cases};
use glam::{Vec2, Vec3};
use sunroom::color::Rgb;
use sunroom::sampling::warp::cosine_hemisphere;
use sunroom::shading::{
    Bsdf, CoatedBase, Conductor, ConductorSpecular, Diffuse, DiffuseLobe, MicrofacetKind, Plastic, Principled,
    RoughPlastic, ShadingTables, SmoothCoat, TransportMode,
};

const BASE: CoatedBase = CoatedBase {
    diffuse_reflectance: Rgb::new(0.7, 0.2, 0.1),
    nonlinear: true,
    specular_reflectance: Rgb::ONE,
};

fn viewers() -> [Vec3; 4] {
    [0.0, 30.0, 60.0, 85.0].map(|degrees| direction(degrees, 1.0 + degrees))
}

fn models(tables: &mut ShadingTables) -> Vec<Bsdf> {
    let coat = tables.uniform_coat(MicrofacetKind::Ggx, 1.5, 0.2);
    let mut models = vec![
        Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::splat(0.5),
        }),
        Bsdf::Plastic(Plastic {
            coat: SmoothCoat::new(1.5),
            base: BASE,
        }),
        Bsdf::RoughPlastic(RoughPlastic {
            coat,
            alpha: 0.2,
            base: BASE,
        }),
    ];
    models.extend(principled_cases().into_iter().map(|(_, model)| Bsdf::Principled(model)));
    models
}

#[test]
fn numbers_of_the_lobe_choose_directions_by_the_cosine() {
    let mut tables = ShadingTables::default();
    let (mut inside, mut outside) = (0, 0);
    for model in models(&mut tables) {
        for wo in viewers() {
            let lobe = model.diffuse_lobe(&tables, wo);
            for k in 0..64 {
                let u_lobe = (k as f32 + 0.5) / 64.0;
                let u = Vec2::new(
                    0.1 + 0.8 * (0.37 * k as f32).fract(),
                    0.2 + 0.7 * (0.71 * k as f32).fract(),
                );
                let sample = model.sample(&tables, wo, u_lobe, u, TransportMode::Radiance);
                let is_in = u_lobe >= lobe.start && u_lobe < lobe.start + lobe.share;
                let is_cosine = sample.is_some_and(|sample| sample.wi == cosine_hemisphere(u.to_array()));
                assert!(is_cosine || !is_in, "{model:?} {wo} {u_lobe} {lobe:?}");
                let is_glass = matches!(model, Bsdf::Principled(model) if model.spec_trans > 0.0);
                assert!(is_in || !is_cosine || is_glass, "{model:?} {wo} {u_lobe} {lobe:?}");
                *if is_in { &mut inside } else { &mut outside } += 1;
            }
        }
    }
    assert!(inside > 1000 && outside > 1000, "{inside} {outside}");
}

#[test]
fn densities_have_the_lobe_in_them() {
    let mut tables = ShadingTables::default();
    for model in models(&mut tables) {
        for wo in viewers() {
            let lobe = model.diffuse_lobe(&tables, wo);
            for k in 0..50 {
                let wi = direction(1.7 * k as f32, 2.3 * k as f32);
                let (_, pdf) = model.eval_and_pdf(&tables, wo, wi, TransportMode::Radiance);
                let own = lobe.share * wi.z * FRAC_1_PI;
                assert!(pdf >= own - 1e-6, "{model:?} {wo} {wi}: {pdf} {own}");
                // Nothing else of these has a density.
                if matches!(model, Bsdf::Diffuse(_) | Bsdf::Plastic(_)) {
                    assert!((pdf - own).abs() < 1e-6, "{model:?} {wo} {wi}: {pdf} {own}");
                }
            }
        }
    }
}

#[test]
fn what_has_no_diffuse_lobe_has_none() {
    let mut tables = ShadingTables::default();
    let below = direction(130.0, 2.0);
    for model in models(&mut tables) {
        let is_one_sided = !matches!(model, Bsdf::Diffuse(_));
        assert!(
            !is_one_sided || model.diffuse_lobe(&tables, below) == DiffuseLobe::NONE,
            "{model:?}"
        );
    }
    let glass = Bsdf::Principled(Principled {
        spec_trans: 0.5,
        ..PRINCIPLED
    });
    let mirror = Bsdf::Conductor(Conductor {
        specular: ConductorSpecular {
            eta: Rgb::splat(0.2),
            k: Rgb::splat(3.0),
            specular_reflectance: Rgb::ONE,
        },
    });
    let above = direction(40.0, 1.0);
    for model in [glass, mirror] {
        assert_eq!(model.diffuse_lobe(&tables, above), DiffuseLobe::NONE, "{model:?}");
    }
}
