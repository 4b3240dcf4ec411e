//! Participating media: phase functions, and pictures whose radiance is known.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Affine3A, Quat, UVec3, Vec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::{Rgb, luminance};
use sunroom::light::LightSource;
use sunroom::material::Material;
use sunroom::medium::{
    BlendedPhase, GridVolume, MediumId, MediumInterface, MediumSource, Phase, TabulatedPhase, Volume, VolumeFilter,
    VolumeGrid, VolumeWrap, Voxels,
};
use sunroom::render::camera::Camera;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Shown, Strategy, View};
use sunroom::sampling::hash::pcg3d;
use sunroom::sampling::{SequenceKind, unit_float};
use sunroom::shading::{
    Bsdf, Dielectric, DielectricModel, Diffuse, Microfacet, MicrofacetKind, Principled, RoughDielectric,
};

use crate::principled_cases::PRINCIPLED;
use crate::statistics::{assert_all_plausible, sphere_integral, sphere_p};
use crate::support::{SceneBuilder, assert_close, camera, mean_luminance, render, view};

const STRATEGIES: [Strategy; 3] = [Strategy::Bsdf, Strategy::Light, Strategy::Mis];
const UNBOUNDED: u32 = u32::MAX;

fn hg(g: f32) -> Phase {
    Phase::HenyeyGreenstein { g }
}

fn blend(weight: f32, first: Phase, second: Phase) -> Phase {
    Phase::Blend(Box::new(BlendedPhase {
        weight: Volume::Constant(Rgb::splat(weight)),
        of: [first, second],
    }))
}

fn table(values: &[f32]) -> Phase {
    Phase::Tabulated(Arc::new(TabulatedPhase::new(values).expect("a table")))
}

fn phases() -> Vec<(&'static str, Phase)> {
    vec![
        ("isotropic", Phase::Isotropic),
        ("hg 0.9", hg(0.9)),
        ("hg 0.3", hg(0.3)),
        ("hg 0.0005", hg(5e-4)),
        ("hg -0.7", hg(-0.7)),
        ("rayleigh", Phase::Rayleigh),
        ("table", table(&[0.2, 0.0, 0.0, 0.5, 3.0])),
        ("table of two", table(&[1.0, 0.0])),
        ("blend", blend(0.3, hg(0.8), Phase::Rayleigh)),
        (
            "nested blend",
            blend(0.6, blend(0.5, hg(0.7), hg(-0.5)), Phase::Isotropic),
        ),
    ]
}

#[test]
fn phase_functions_integrate_to_one_and_are_sampled_by_their_values() {
    const COUNT: u32 = 100_000;
    let dir = Vec3::new(0.3, -0.5, 0.8).normalize();
    let mut results = Vec::new();
    for (name, phase) in phases() {
        let pdf = |wi: Vec3| phase.pdf(Vec3::ZERO, dir, wi);
        let integral = sphere_integral(dir, pdf);
        assert!((integral - 1.0).abs() < 2e-3, "{name}: {integral}");
        let sample = |number| {
            let [a, b, c] = pcg3d([number, 5, 77]).map(unit_float);
            let (wi, density) = phase.sample(Vec3::ZERO, dir, a, Vec2::new(b, c));
            assert!(
                (density - pdf(wi)).abs() <= 1e-3 * density,
                "{name}: {density} {}",
                pdf(wi)
            );
            Some(wi)
        };
        results.push((name.to_owned(), sphere_p(COUNT, dir, sample, pdf)));
    }
    assert_all_plausible(&results);
}

#[test]
fn the_mean_cosine_of_henyey_and_greenstein_is_g() {
    for g in [0.9, 0.2, 5e-4, -0.6] {
        let mean = sphere_integral(Vec3::Z, |wi| hg(g).pdf(Vec3::ZERO, Vec3::Z, wi) * (wi.z + 1.0)) - 1.0;
        assert!((mean - f64::from(g)).abs() < 3e-3, "{g}: {mean}");
    }
}

#[test]
fn tables_without_a_distribution_are_none() {
    for values in [&[1.0][..], &[0.0, 0.0], &[1.0, -1.0], &[1.0, f32::NAN]] {
        assert_eq!(TabulatedPhase::new(values), None);
    }
}

fn medium(sigma_t: impl Into<Rgb>, albedo: impl Into<Rgb>, phase: Phase) -> MediumSource {
    MediumSource {
        sigma_t: Volume::Constant(sigma_t.into()),
        scale: 1.0,
        albedo: Volume::Constant(albedo.into()),
        emission: Volume::ZERO,
        phase,
    }
}

/// The same medium as a grid of equal voxels around the origin, so that it is traced by null collisions. Its majorants
/// are too large if `is_loose`.
fn as_grid(source: &MediumSource, is_loose: bool) -> MediumSource {
    let Volume::Constant(sigma_t) = source.sigma_t else {
        return source.clone();
    };
    let size = UVec3::splat(24);
    let peak = if is_loose { 4.0 } else { 1.0 };
    let voxels = (0..size.element_product()).flat_map(|voxel| {
        // One voxel outside of what is seen decides on the majorant of all that are near.
        let is_peak = voxel % 24 == 0;
        (sigma_t * if is_peak { peak } else { 1.0 }).to_array()
    });
    let grid = VolumeGrid::new(size, 3, Voxels::F32(voxels.collect())).expect("a grid");
    let placed = Affine3A::from_translation(Vec3::splat(-8.0)) * Affine3A::from_scale(Vec3::splat(16.0));
    MediumSource {
        sigma_t: Volume::Grid(GridVolume::new(
            Arc::new(grid),
            placed,
            VolumeFilter::Trilinear,
            VolumeWrap::Clamp,
        )),
        ..source.clone()
    }
}

fn filled(interior: u32) -> MediumInterface {
    MediumInterface {
        interior: Some(MediumId(interior)),
        exterior: None,
    }
}

fn placed(scale: f32, translation: Vec3) -> Affine3A {
    Affine3A::from_scale_rotation_translation(Vec3::splat(scale), Quat::IDENTITY, translation)
}

/// A narrow look along -z through the origin.
fn look(max_depth: u32, strategy: Strategy) -> View {
    with_media(view(
        camera(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 0.1),
        4,
        max_depth,
        strategy,
    ))
}

fn with_media(mut view: View) -> View {
    let settings = view.integrator.settings_mut();
    settings.media = true;
    view.sequence = SequenceKind::Sobol;
    view
}

/// A ball of the medium 0 behind a boundary that light does not notice.
fn ball(media: Vec<MediumSource>) -> SceneBuilder {
    let mut scene = SceneBuilder::with_media(media);
    scene.add(Primitive::Sphere, Affine3A::IDENTITY, Material::Null, None);
    scene.between(filled(0));
    scene
}

fn sky(radiance: f32) -> LightSource {
    LightSource::Constant {
        radiance: Rgb::splat(radiance),
    }
}

fn check(what: &str, scene: &RenderScene, view: &View, samples: u32, expected: f32) {
    assert_close(what, mean_luminance(&render(scene, view, samples)), expected);
}

#[test]
fn a_medium_that_absorbs_nothing_is_not_seen_in_an_even_sky() {
    for (name, phase) in phases() {
        let source = medium(Rgb::new(0.5, 2.0, 5.0), Rgb::ONE, phase);
        for (form, source) in [("uniform", source.clone()), ("tracked", as_grid(&source, true))] {
            let mut scene = ball(vec![source]);
            scene.light(sky(1.0));
            let scene = scene.build();
            for strategy in STRATEGIES {
                let what = format!("{name}, {form}, {strategy:?}");
                check(&what, &scene, &look(UNBOUNDED, strategy), 1500, 1.0);
            }
        }
    }
}

/// To a thousandth, which the errors of the test above do not reach.
#[test]
fn the_furnace_is_exact_to_a_thousandth() {
    let mut scene = ball(vec![medium(Rgb::splat(1.5), Rgb::ONE, hg(0.5))]);
    scene.light(sky(1.0));
    let film = render(&scene.build(), &look(UNBOUNDED, Strategy::Mis), 260_000);
    let (mean, error) = mean_luminance(&film);
    assert!(error < 3.3e-4, "{error}");
    assert!((mean - 1.0).abs() < 1e-3, "{mean} +- {error}");
}

#[test]
fn light_that_is_absorbed_follows_beer() {
    let sigma_t = 0.8;
    // Without scattering no number is drawn at all, and the picture has no noise.
    for albedo in [0.0, 0.6] {
        let source = medium(Rgb::splat(sigma_t), Rgb::splat(albedo), Phase::Isotropic);
        for source in [source.clone(), as_grid(&source, false), as_grid(&source, true)] {
            let mut scene = ball(vec![source]);
            scene.light(sky(1.0));
            // One segment: what is scattered is lost.
            let film = render(&scene.build(), &look(1, Strategy::Mis), 4000);
            assert_close("one ball", mean_luminance(&film), (-2.0 * sigma_t).exp());
        }
    }
}

#[test]
fn the_camera_can_be_within_a_medium() {
    let sigma_t = 0.3;
    let mut scene = SceneBuilder::with_media(vec![medium(Rgb::splat(sigma_t), Rgb::splat(0.5), Phase::Isotropic)]);
    let white = Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO });
    scene.add(Primitive::Rectangle, placed(2.0, Vec3::ZERO), white, Some(Rgb::ONE));
    let mut view = look(1, Strategy::Mis);
    view.medium = Some(MediumId(0));
    check("a lamp in fog", &scene.build(), &view, 4000, (-4.0 * sigma_t).exp());
}

/// A slab of fog under parallel light, scattered once: the integral has a closed form.
#[test]
fn a_slab_scatters_parallel_light_once_as_the_integral_says() {
    let (thickness, sigma_t, albedo) = (1.4f32, 0.9f32, 0.7f32);
    for (name, phase) in phases() {
        for angle in [0.0f32, 0.9] {
            let to_slab = Vec3::new(angle.sin(), 0.0, -angle.cos());
            let depth = sigma_t * (1.0 + 1.0 / angle.cos());
            let scattered = phase.pdf(Vec3::ZERO, -Vec3::Z, -to_slab);
            let expected = 2.0 * albedo * sigma_t * scattered * (1.0 - (-depth * thickness).exp()) / depth;
            let source = medium(Rgb::splat(sigma_t), Rgb::splat(albedo), phase.clone());
            for (form, source) in [("uniform", source.clone()), ("tracked", as_grid(&source, true))] {
                let mut scene = SceneBuilder::with_media(vec![source]);
                for z in [0.0, -thickness] {
                    let turned = if z < 0.0 { PI } else { 0.0 };
                    let side = Affine3A::from_translation(Vec3::Z * z) * Affine3A::from_rotation_y(turned);
                    scene.add(
                        Primitive::Rectangle,
                        side * Affine3A::from_scale(Vec3::splat(6.0)),
                        Material::Null,
                        None,
                    );
                    scene.between(filled(0));
                }
                scene.light(LightSource::Directional {
                    direction: to_slab,
                    irradiance: Rgb::splat(2.0),
                });
                let what = format!("{name}, {form}, {angle}");
                check(&what, &scene.build(), &look(2, Strategy::Mis), 4000, expected);
            }
        }
    }
}

/// A ball that a lamp lights, and a point light: the integral over the camera ray by the rule of Simpson.
#[test]
fn a_ball_scatters_a_point_light_once_as_the_integral_says() {
    let (sigma_t, albedo, phase) = (0.9f32, 0.8f32, hg(0.4));
    let lamp = Vec3::new(0.0, 1.7, 0.3);
    // The distance from a point within the unit ball to its surface.
    let to_surface = |point: Vec3, dir: Vec3| {
        let along = point.dot(dir);
        -along + (along * along + 1.0 - point.length_squared()).sqrt()
    };
    let integrand = |t: f32| {
        let point = Vec3::Z * (1.0 - t);
        let to_lamp = (lamp - point).normalize();
        let way = t + to_surface(point, to_lamp);
        let scattered = phase.pdf(point, -Vec3::Z, to_lamp);
        sigma_t * albedo * scattered * (-sigma_t * way).exp() / (lamp - point).length_squared()
    };
    let steps = 200;
    let sum: f32 = (0..=steps)
        .map(|step| {
            let weight = [2.0, 4.0][step % 2] - if step == 0 || step == steps { 1.0 } else { 0.0 };
            weight * integrand(2.0 * step as f32 / steps as f32)
        })
        .sum();
    let expected = 5.0 * sum * (2.0 / steps as f32) / 3.0;
    let source = medium(Rgb::splat(sigma_t), Rgb::splat(albedo), phase);
    for (form, source) in [("uniform", source.clone()), ("tracked", as_grid(&source, true))] {
        let mut scene = ball(vec![source]);
        scene.light(LightSource::Point {
            position: lamp,
            intensity: Rgb::splat(5.0),
        });
        check(form, &scene.build(), &look(2, Strategy::Mis), 20_000, expected);
    }
}

/// A room full of coloured fog with a lamp, some way off: three strategies and two forms, one radiance.
#[test]
fn all_estimators_agree() {
    let source = medium(Rgb::new(0.2, 0.5, 0.9), Rgb::new(0.9, 0.7, 0.5), hg(0.3));
    let room = |source: MediumSource| {
        let mut scene = SceneBuilder::with_media(vec![source]);
        let grey = Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::splat(0.5),
        });
        scene
            .add(Primitive::Sphere, placed(4.0, Vec3::ZERO), grey, None)
            .flip_normals = true;
        scene.between(MediumInterface {
            interior: None,
            exterior: Some(MediumId(0)),
        });
        let down = Affine3A::from_translation(Vec3::Y * 2.0) * Affine3A::from_rotation_x(FRAC_PI_2);
        scene.add(Primitive::Rectangle, down, grey, Some(Rgb::splat(3.0)));
        scene.build()
    };
    let wide = |strategy, max_depth| {
        let mut view = with_media(view(
            camera(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 60.0),
            8,
            max_depth,
            strategy,
        ));
        view.medium = Some(MediumId(0));
        view
    };
    for max_depth in [3, UNBOUNDED] {
        let uniform = room(source.clone());
        let (expected, error) = mean_luminance(&render(&uniform, &wide(Strategy::Mis, max_depth), 8000));
        for (form, source) in [("uniform", source.clone()), ("tracked", as_grid(&source, true))] {
            let scene = room(source);
            for strategy in STRATEGIES {
                let (mean, own) = mean_luminance(&render(&scene, &wide(strategy, max_depth), 3000));
                let error = error.hypot(own);
                let what = format!("{form}, {strategy:?}, depth {max_depth}");
                assert_close(&what, (mean, error), expected);
            }
        }
    }
}

/// A space that shines and scatters: the radiance of an isothermal ball with albedo 0 is (1 - exp(-tau)) times emission
/// over extinction.
#[test]
fn a_glowing_ball_shines_as_its_optical_depth_says() {
    let (sigma_t, emission) = (0.7f32, 0.5f32);
    let mut source = medium(Rgb::splat(sigma_t), Rgb::ZERO, Phase::Isotropic);
    source.emission = Volume::Constant(Rgb::splat(emission));
    let expected = emission / sigma_t * (1.0 - (-2.0 * sigma_t).exp());
    for (form, source) in [("uniform", source.clone()), ("tracked", as_grid(&source, false))] {
        check(
            form,
            &ball(vec![source]).build(),
            &look(UNBOUNDED, Strategy::Mis),
            20_000,
            expected,
        );
    }
    // With scattering, an even sky of the equilibrium's radiance hides the ball.
    let albedo = 0.6;
    let mut source = medium(Rgb::splat(sigma_t), Rgb::splat(albedo), hg(0.5));
    source.emission = Volume::Constant(Rgb::splat(sigma_t * (1.0 - albedo)));
    for source in [source.clone(), as_grid(&source, true)] {
        let mut scene = ball(vec![source]);
        scene.light(sky(1.0));
        check(
            "equilibrium",
            &scene.build(),
            &look(UNBOUNDED, Strategy::Mis),
            20_000,
            1.0,
        );
    }
}

/// Fire without smoke: emission alone is a grid, in space that absorbs nothing.
#[test]
fn a_grid_of_emission_alone_shines_through_its_depth() {
    let grid = VolumeGrid::new(UVec3::new(5, 4, 3), 1, Voxels::U8(vec![255; 60])).expect("a grid");
    let cube = Affine3A::from_translation(Vec3::splat(-0.5));
    let mut source = medium(Rgb::ZERO, Rgb::ZERO, Phase::Isotropic);
    source.emission = Volume::Grid(GridVolume::new(
        Arc::new(grid),
        cube,
        VolumeFilter::Trilinear,
        VolumeWrap::Clamp,
    ));
    check(
        "fire",
        &ball(vec![source.clone()]).build(),
        &look(UNBOUNDED, Strategy::Mis),
        20_000,
        1.0,
    );
    // Smoke around it does not shine.
    let sigma_t = 0.8f32;
    source.sigma_t = Volume::Constant(Rgb::splat(sigma_t));
    let (before, within) = ((-0.5 * sigma_t).exp(), (1.0 - (-sigma_t).exp()) / sigma_t);
    check(
        "fire in smoke",
        &ball(vec![source]).build(),
        &look(UNBOUNDED, Strategy::Mis),
        20_000,
        before * within,
    );
}

/// Albedo one in glass: what goes in comes out again, whatever the boundary does.
#[test]
fn milk_in_glass_in_an_even_sky_is_not_seen() {
    let glass = Bsdf::Dielectric(Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    });
    let mut scene = SceneBuilder::with_media(vec![medium(Rgb::splat(4.0), Rgb::ONE, hg(0.6))]);
    scene.add(Primitive::Sphere, Affine3A::IDENTITY, glass, None);
    scene.between(filled(0));
    scene.light(sky(1.0));
    check("milk", &scene.build(), &look(UNBOUNDED, Strategy::Mis), 6000, 1.0);
}

/// What is seen of a filled ball in an even sky, with its error.
fn filled_ball(boundary: Bsdf, source: MediumSource, samples: u32) -> (f32, f32) {
    let mut scene = SceneBuilder::with_media(vec![source]);
    scene.add(Primitive::Sphere, Affine3A::IDENTITY, boundary, None);
    scene.between(filled(0));
    scene.light(sky(1.0));
    mean_luminance(&render(&scene.build(), &look(UNBOUNDED, Strategy::Mis), samples))
}

/// White glass of the principled model of this roughness.
fn principled_glass(roughness: f32, eta: f32) -> Bsdf {
    Bsdf::Principled(Principled {
        base_color: Rgb::ONE,
        roughness,
        spec_trans: 1.0,
        eta,
        ..PRINCIPLED
    })
}

/// The facets of this roughness, whose width is a thousandth, pass nearly nothing from one to another.
#[test]
fn milk_in_principled_glass_in_an_even_sky_is_not_seen() {
    let milk = medium(Rgb::splat(4.0), Rgb::ONE, hg(0.6));
    assert_close("milk", filled_ball(principled_glass(0.0, 1.33), milk, 6000), 1.0);
}

/// Rougher glass loses what single scattering by facets loses: as much as the rough dielectric with the same facets.
#[test]
fn milk_in_rough_principled_glass_is_milk_in_a_rough_dielectric() {
    for (roughness, eta) in [(0.5, 1.5), (0.7, 1.33)] {
        let milk = medium(Rgb::new(3.0, 4.0, 6.0), Rgb::new(1.0, 0.99, 0.9), hg(0.3));
        let alpha = roughness * roughness;
        let rough = Bsdf::RoughDielectric(RoughDielectric {
            eta,
            model: DielectricModel::Exact,
            distribution: Microfacet::new(MicrofacetKind::Ggx, alpha, alpha),
            specular_reflectance: Rgb::ONE,
            specular_transmittance: Rgb::ONE,
        });
        let principled = filled_ball(principled_glass(roughness, eta), milk.clone(), 20_000);
        let rough = filled_ball(rough, milk, 20_000);
        assert!(rough.0 > 0.4 && rough.0 < 0.97, "{rough:?}");
        let what = format!("roughness {roughness}");
        assert_close(&what, (principled.0, principled.1.hypot(rough.1)), rough.0);
    }
}

/// Lights are seldom sought from behind glass; those that are there count for more.
#[test]
fn a_lamp_in_milk_in_glass_is_as_bright_as_paths_find_it() {
    let glass = Bsdf::Dielectric(Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    });
    let milk = medium(Rgb::new(1.0, 1.5, 2.0), Rgb::splat(0.8), hg(0.3));
    for (form, source) in [("uniform", milk.clone()), ("tracked", as_grid(&milk, false))] {
        let mut scene = SceneBuilder::with_media(vec![source]);
        scene.add(Primitive::Sphere, Affine3A::IDENTITY, glass, None);
        scene.between(filled(0));
        let dark = Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO });
        let lamp = placed(0.2, Vec3::new(0.5, 0.1, 0.0));
        scene.add(Primitive::Sphere, lamp, dark, Some(Rgb::splat(5.0)));
        scene.between(MediumInterface {
            interior: None,
            exterior: Some(MediumId(0)),
        });
        let scene = scene.build();
        let (expected, error) = mean_luminance(&render(&scene, &look(UNBOUNDED, Strategy::Bsdf), 20_000));
        for strategy in [Strategy::Light, Strategy::Mis] {
            let (mean, own) = mean_luminance(&render(&scene, &look(UNBOUNDED, strategy), 20_000));
            assert_close(&format!("{form}, {strategy:?}"), (mean, error.hypot(own)), expected);
        }
    }
}

/// Surfaces that let light pass straight count for no segment: a lamp behind ten of them is seen directly, and lights
/// what is in front of them.
#[test]
fn boundaries_count_for_no_segment() {
    let mut scene = SceneBuilder::with_media(vec![medium(Rgb::ZERO, Rgb::ZERO, Phase::Isotropic)]);
    for number in 0..10 {
        let side = placed(3.0, Vec3::Z * (0.1 * number as f32));
        scene.add(Primitive::Rectangle, side, Material::Null, None);
        scene.between(filled(0));
    }
    let black = Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO });
    scene.add(
        Primitive::Rectangle,
        placed(3.0, Vec3::Z * -1.0),
        black,
        Some(Rgb::splat(0.5)),
    );
    let scene = scene.build();
    check("seen", &scene, &look(1, Strategy::Mis), 4, 0.5);
}

#[test]
fn nothing_of_media_is_there_unless_asked_for() {
    let mut scene = ball(vec![medium(Rgb::splat(5.0), Rgb::ZERO, Phase::Isotropic)]);
    scene.light(sky(1.0));
    let mut view = look(4, Strategy::Mis);
    let settings = view.integrator.settings_mut();
    settings.media = false;
    check("empty", &scene.build(), &view, 16, 1.0);
}

#[test]
fn a_camera_far_away_sees_the_same() {
    let mut scene = ball(vec![medium(Rgb::splat(0.5), Rgb::splat(0.9), hg(0.2))]);
    scene.light(sky(1.0));
    let scene = scene.build();
    let near = mean_luminance(&render(&scene, &look(UNBOUNDED, Strategy::Mis), 4000));
    let mut view = look(UNBOUNDED, Strategy::Mis);
    let pose = Affine3A::from_translation(Vec3::Z * 400.0) * Affine3A::from_rotation_y(PI);
    view.camera = Camera::new(pose, 0.001, 1.0, 1e-3, 1e6, None);
    let far = mean_luminance(&render(&scene, &view, 4000));
    assert_close("far", (far.0, far.1.hypot(near.1)), near.0);
}

#[test]
fn the_optical_depth_counts_all_media_up_to_the_first_surface() {
    let shown = |scene: SceneBuilder, medium: Option<MediumId>| {
        let mut view = look(8, Strategy::Mis);
        (view.shown, view.medium) = (Shown::OpticalDepth, medium);
        mean_luminance(&render(&scene.build(), &view, 4)).0
    };
    let sigma_t = Rgb::new(0.8, 0.4, 0.2);
    let source = medium(sigma_t, Rgb::splat(0.9), Phase::Isotropic);
    for source in [source.clone(), as_grid(&source, false), as_grid(&source, true)] {
        let (depth, expected) = (shown(ball(vec![source]), None), luminance(2.0 * sigma_t));
        assert!((depth / expected - 1.0).abs() < 0.01, "{depth}, not {expected}");
    }
    // The camera is 4 before a wall.
    let wall = || {
        let mut scene = SceneBuilder::with_media(vec![medium(sigma_t, Rgb::splat(0.5), Phase::Isotropic)]);
        let black = Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO });
        scene.add(Primitive::Rectangle, placed(2.0, Vec3::ZERO), black, None);
        scene
    };
    let (depth, expected) = (shown(wall(), Some(MediumId(0))), luminance(4.0 * sigma_t));
    assert!((depth / expected - 1.0).abs() < 0.01, "{depth}, not {expected}");
    assert_eq!(shown(wall(), None), 0.0);
}
