//! Light that comes from a lamp is scattered as paths from the camera scatter it the other way: what a viewer sees
//! decides, whichever end a path starts at.

use crate::bidirectional::{assert_pictures, by, diffuse, glass, look, placed};
use crate::material_support::{Case, all_cases, frame, pictures, random_direction, world};
use crate::statistics::{assert_all_plausible, sphere_integral, sphere_p};
use crate::support::{SceneBuilder, render};
use glam::{Quat, UVec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::material::{BumpOptions, Lobe, Material};
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Integrator, PathSettings, PhotonSettings};
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, Conductor, ConductorSpecular, TransportMode};
use sunroom::texture::{Parameter, TextureId};

/// Directions to a lamp, in the local frame: overhead, oblique, grazing, from behind.
fn lamps() -> [Vec3; 4] {
    [(20.0f32, 1.0f32), (50.0, 2.5), (78.0, 0.3), (140.0, 4.0)].map(|(theta, phi)| {
        let (sin, cos) = theta.to_radians().sin_cos();
        Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    })
}

/// Where a lobe is likely to have its peak, in the world.
fn peak(lamp: Vec3) -> Vec3 {
    world(Vec3::new(-lamp.x, -lamp.y, lamp.z))
}

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() <= 2e-3 * a.abs().max(b.abs()) + 1e-5
}

#[test]
fn a_lamp_lights_what_its_viewer_sees() {
    let mut compared = 0;
    for case in all_cases() {
        for index in 0..300 {
            let (lamp, viewer) = (random_direction(2 * index), random_direction(2 * index + 1));
            let from_lamp = case.placed.scattering_of(lamp, TransportMode::Importance);
            let found = from_lamp.eval_adjoint(world(viewer), frame().n);
            let expected = (case.value)(viewer, lamp) * (viewer.z / lamp.z).abs();
            let error = (found - expected).abs().max_element();
            assert!(
                error <= 2e-3 * expected.max_element() + 1e-5,
                "{} from {lamp} to {viewer}: {found} {expected}",
                case.name
            );
            compared += usize::from(expected.max_element() > 1e-3);
        }
    }
    assert!(compared > 5000, "{compared}");
}

/// Else the weights of the ways of finding a path do not add up to 1.
#[test]
fn both_ends_of_a_path_know_the_same_densities() {
    let mut compared = 0;
    for case in all_cases() {
        for index in 0..300 {
            let (lamp, viewer) = (random_direction(2 * index), random_direction(2 * index + 1));
            // Without light there is no path.
            if (case.value)(viewer, lamp) == Rgb::ZERO {
                continue;
            }
            let from_lamp = case.placed.scattering_of(lamp, TransportMode::Importance);
            let from_viewer = case.placed.scattering(viewer);
            let pairs = [
                (
                    from_lamp.eval_and_pdf(world(viewer)).1,
                    from_viewer.reverse_pdf(world(lamp)),
                ),
                (
                    from_viewer.eval_and_pdf(world(lamp)).1,
                    from_lamp.reverse_pdf(world(viewer)),
                ),
            ];
            for (forth, back) in pairs {
                assert!(close(forth, back), "{} {lamp} {viewer}: {forth} {back}", case.name);
            }
            let [a, b] = [&from_lamp, &from_viewer].map(|scattering| scattering.one_sided_normal_both_ways());
            let is_same = match (a, b) {
                (Some(a), Some(b)) => a.abs_diff_eq(b, 1e-6),
                (None, None) => true,
                _ => false,
            };
            assert!(is_same, "{} {lamp} {viewer}: {a:?} {b:?}", case.name);
            compared += 1;
        }
    }
    assert!(compared > 5000, "{compared}");
}

fn for_each_lamp(mut check: impl FnMut(&Case, Vec3, &str)) {
    for case in all_cases() {
        for lamp in lamps() {
            check(&case, lamp, &format!("{} lit from {lamp}", case.name));
        }
    }
}

#[test]
fn light_from_lamps_is_sent_on_by_its_density() {
    let mut results = Vec::new();
    for_each_lamp(|case, lamp, name| {
        let scattering = case.placed.scattering_of(lamp, TransportMode::Importance);
        let sample = |index: u32| {
            let sampler = Sampler::new(SequenceKind::Independent, UVec2::new(5, 3), index, 7);
            scattering.sample_adjoint(sampler.at_1d(0), sampler.at_2d(1), frame().n)
        };
        let smooth = |index| sample(index).filter(|sample| sample.lobe == Lobe::Smooth);
        let p = sphere_p(
            20_000,
            peak(lamp),
            |index| Some(smooth(index)?.wi),
            |wi| scattering.eval_and_pdf(wi).1,
        );
        results.push((name.to_owned(), p));
        let count = 20_000;
        let weights = (0..count).filter_map(smooth).map(|sample| f64::from(sample.weight.y));
        let (sum, squares) = weights.fold((0.0, 0.0), |(sum, squares), weight| {
            (sum + weight, squares + weight * weight)
        });
        let mean = sum / f64::from(count);
        let variance = (squares / f64::from(count) - mean * mean).max(0.0);
        let deviation = (variance / f64::from(count)).sqrt();
        let integral = sphere_integral(peak(lamp), |wi| scattering.eval_adjoint(wi, frame().n).y);
        // Five standard errors, and that of the quadrature, which is poor where bumps cut off.
        let tolerance = 5.0 * deviation + 2e-3 * (1.0 + integral);
        assert!((mean - integral).abs() < tolerance, "{name}: {mean}, {integral}");
    });
    assert_all_plausible(&results);
}

/// A smooth picture among [`pictures`].
const HEIGHTS: TextureId = TextureId(2);

type Around = fn(&mut SceneBuilder, Material, Vec3) -> Material;

/// A room whose normals lean so far that viewers see other ones than lamps would. `around` makes a material of the one
/// inside and the normal. A ball of glass makes photons.
fn leaning_room(around: Around, has_ball: bool) -> RenderScene {
    let mut scene = SceneBuilder::with_textures(pictures());
    let quarter = std::f32::consts::FRAC_PI_2;
    let walls = [
        (
            Quat::from_rotation_x(-quarter),
            Vec3::new(0.0, -1.0, 0.0),
            Vec3::new(0.8, 0.3, 0.5),
        ),
        (Quat::IDENTITY, Vec3::new(0.0, 0.0, -1.0), Vec3::new(-0.3, 0.85, 0.4)),
        (
            Quat::from_rotation_y(quarter),
            Vec3::new(-1.0, 0.0, 0.0),
            Vec3::new(0.6, -0.6, 0.5),
        ),
    ];
    for (turn, place, normal) in walls {
        let material = around(&mut scene, diffuse(0.7).into(), normal.normalize());
        scene.add(Primitive::Rectangle, placed(Vec3::ONE, turn, place), material, None);
    }
    let ball = placed(Vec3::splat(0.3), Quat::IDENTITY, Vec3::new(0.4, -0.7, 0.2));
    let of_ball = if has_ball { glass() } else { diffuse(0.6) };
    scene.add(Primitive::Sphere, ball, of_ball, None);
    let lamp = placed(
        Vec3::splat(0.3),
        Quat::from_rotation_x(quarter),
        Vec3::new(0.2, 0.9, 0.0),
    );
    scene.add(Primitive::Rectangle, lamp, diffuse(0.3), Some(Rgb::splat(8.0)));
    scene.build()
}

fn normal_map(scene: &mut SceneBuilder, nested: Material, normal: Vec3) -> Material {
    Material::NormalMap {
        nested: scene.material(nested),
        normals: Parameter::Constant(0.5 * (normal + 1.0)),
        gltf_tangents: false,
        options: BumpOptions {
            flip_invalid_normals: true,
            use_shadowing_function: true,
        },
    }
}

/// Mirrors have a normal for each viewer, too.
fn blend_with_mirror(scene: &mut SceneBuilder, nested: Material, normal: Vec3) -> Material {
    let mirror = Bsdf::Conductor(Conductor {
        specular: ConductorSpecular {
            eta: Rgb::splat(0.2),
            k: Rgb::splat(3.0),
            specular_reflectance: Rgb::ONE,
        },
    });
    let blend = Material::Blend {
        first: scene.material(nested),
        second: scene.material(mirror),
        weight: Parameter::Constant(0.3),
    };
    normal_map(scene, blend, normal)
}

fn map_in_map(scene: &mut SceneBuilder, nested: Material, normal: Vec3) -> Material {
    let inner = normal_map(scene, nested, Vec3::new(0.3, -0.2, 0.9).normalize());
    normal_map(scene, inner, normal)
}

/// One picture moves all walls, some of which lean away from their viewers.
fn bump_map(scene: &mut SceneBuilder, nested: Material, _: Vec3) -> Material {
    Material::BumpMap {
        nested: scene.material(nested),
        height: Parameter::Texture(HEIGHTS),
        scale: 0.3,
        options: BumpOptions {
            flip_invalid_normals: true,
            use_shadowing_function: true,
        },
    }
}

/// Photons within small places, so that these blur little, and few: each sample has its own.
fn merging(settings: PathSettings) -> Integrator {
    let photons = PhotonSettings {
        paths: Some(128),
        radius: 1.0,
    };
    Integrator::Merging(settings, photons)
}

#[test]
fn all_integrators_see_normals_that_are_turned_for_their_viewer() {
    let kinds: [(&str, Around, bool); 4] = [
        ("normal map", normal_map, true),
        ("bump map", bump_map, true),
        ("with a mirror", blend_with_mirror, false),
        ("map in map", map_in_map, true),
    ];
    let view = look(4);
    for (name, around, is_diffuse) in kinds {
        let scene = leaning_room(around, true);
        let path = render(&scene, &view, 3000);
        for (how, integrator) in [
            ("bdpt", Integrator::Bidirectional as fn(PathSettings) -> Integrator),
            ("vcm", merging),
        ] {
            let film = render(&scene, &by(integrator, &view), 1500);
            assert_pictures(&format!("{name}, {how}"), &path, &film);
        }
        if is_diffuse {
            let scene = leaning_room(around, false);
            let [path, film] = [&view, &by(Integrator::LightTracing, &view)].map(|view| render(&scene, view, 3000));
            assert_pictures(&format!("{name}, ptracer"), &path, &film);
        }
    }
}
