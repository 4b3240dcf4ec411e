//! Guided paths: they have less noise, the same mean, and the same bits on any number of threads.

use std::sync::atomic::AtomicBool;

use crate::bidirectional::{assert_pictures, diffuse, glass, lit_room, look, placed};
use crate::principled_cases::PRINCIPLED;
use crate::support::{SceneBuilder, camera, render};
use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::{Rgb, luminance};
use sunroom::material::{BumpOptions, Material};
use sunroom::render::film::Film;
use sunroom::render::guide::Guide;
use sunroom::render::scene::RenderScene;
use sunroom::render::shutter::Shutter;
use sunroom::render::tile::{Tile, TileSamples, render_tile, tiles};
use sunroom::render::view::{Strategy, View};
use sunroom::shading::{Bsdf, CoatedBase, MicrofacetKind, Plastic, Principled, RoughPlastic, SmoothCoat};
use sunroom::texture::Parameter;

pub fn guided(view: &View) -> View {
    View {
        guide: Some(Guide::default()),
        ..view.clone()
    }
}

/// A room whose lamp shines at the ceiling from behind a board.
pub fn cove() -> RenderScene {
    cove_of(0.0, |_, _| diffuse(0.7).into())
}

/// The same room, whose walls have the materials that `wall` makes for their numbers: floor, ceiling, back, left and
/// right. They are turned by `spin` about their normals.
fn cove_of(spin: f32, wall: impl Fn(&mut SceneBuilder, usize) -> Material) -> RenderScene {
    let mut scene = SceneBuilder::default();
    let turn = |x: f32, y: f32| Quat::from_rotation_y(y) * Quat::from_rotation_x(x);
    let quarter = std::f32::consts::FRAC_PI_2;
    for (number, (turn, place)) in [
        (turn(-quarter, 0.0), Vec3::new(0.0, -1.0, 0.0)),
        (turn(quarter, 0.0), Vec3::new(0.0, 1.0, 0.0)),
        (turn(0.0, 0.0), Vec3::new(0.0, 0.0, -1.0)),
        (turn(0.0, quarter), Vec3::new(-1.0, 0.0, 0.0)),
        (turn(0.0, -quarter), Vec3::new(1.0, 0.0, 0.0)),
    ]
    .into_iter()
    .enumerate()
    {
        let material = wall(&mut scene, number);
        let turn = turn * Quat::from_rotation_z(spin);
        scene.add(Primitive::Rectangle, placed(Vec3::ONE, turn, place), material, None);
    }
    let ball = Affine3A::from_scale_rotation_translation(Vec3::splat(0.3), Quat::IDENTITY, Vec3::new(0.4, -0.7, -0.2));
    scene.add(Primitive::Sphere, ball, glass(), None);
    let up = turn(-quarter, 0.0);
    let board = placed(Vec3::new(0.9, 0.2, 1.0), turn(quarter, 0.0), Vec3::new(0.0, 0.78, -0.8));
    scene.add(Primitive::Rectangle, board, diffuse(0.5), None);
    let edge = placed(Vec3::new(0.9, 0.07, 1.0), turn(0.0, 0.0), Vec3::new(0.0, 0.85, -0.6));
    scene.add(Primitive::Rectangle, edge, diffuse(0.5), None);
    let lamp = placed(Vec3::new(0.8, 0.03, 1.0), up, Vec3::new(0.0, 0.8, -0.8));
    scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::splat(100.0)));
    scene.build()
}

/// The room with a floor, a back and a wall whose normals lean so far that much of what they scatter would go below
/// their surfaces. The walls are turned, so that the tangents of their materials are not those that lanes have for the
/// same normals.
fn ridged_cove() -> RenderScene {
    cove_of(std::f32::consts::PI, |scene, number| {
        let normal = match number {
            0 => Vec3::new(0.8, 0.3, 0.5),
            2 => Vec3::new(-0.3, 0.85, 0.4),
            4 => Vec3::new(0.6, -0.6, 0.5),
            _ => return diffuse(0.7).into(),
        };
        Material::NormalMap {
            nested: scene.material(diffuse(0.7)),
            normals: Parameter::Constant(0.5 * (normal.normalize() + 1.0)),
            gltf_tangents: false,
            options: BumpOptions {
                flip_invalid_normals: true,
                use_shadowing_function: false,
            },
        }
    })
}

/// The room with walls of coated diffuse materials, one of which has normals that lean.
fn coated_cove() -> RenderScene {
    let base = CoatedBase {
        diffuse_reflectance: Rgb::splat(0.7),
        nonlinear: false,
        specular_reflectance: Rgb::ONE,
    };
    let rough = move |scene: &mut SceneBuilder, alpha: f32| {
        let coat = scene.tables.uniform_coat(MicrofacetKind::Ggx, 1.5, alpha);
        Material::from(Bsdf::RoughPlastic(RoughPlastic { coat, alpha, base }))
    };
    cove_of(std::f32::consts::PI, move |scene, number| match number {
        0 => rough(scene, 0.3),
        1 => Bsdf::Principled(Principled {
            base_color: Rgb::splat(0.7),
            clearcoat: 0.5,
            ..PRINCIPLED
        })
        .into(),
        2 => Bsdf::Plastic(Plastic {
            coat: SmoothCoat::new(1.5),
            base,
        })
        .into(),
        3 => {
            let nested = rough(scene, 0.1);
            Material::NormalMap {
                nested: scene.material(nested),
                normals: Parameter::Constant(0.5 * (Vec3::new(0.5, 0.3, 0.8).normalize() + 1.0)),
                gltf_tangents: false,
                options: BumpOptions {
                    flip_invalid_normals: true,
                    use_shadowing_function: true,
                },
            }
        }
        _ => diffuse(0.7).into(),
    })
}

/// The mean variance of pixels in relation to their light.
fn relative_variance(film: &Film) -> f32 {
    let pixels = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    let of_pixel = |(x, y)| {
        let light = luminance(film.pixel(x, y).expect("samples").radiance);
        (film.standard_error(x, y).expect("samples") / light).powi(2)
    };
    pixels.map(of_pixel).sum::<f32>() / (film.width() * film.height()) as f32
}

#[test]
fn guided_paths_find_the_same_light_with_less_noise() {
    for depth in [3, 8] {
        let (scene, free) = (cove(), look(depth));
        let [plain, led] = [&free, &guided(&free)].map(|view| render(&scene, view, 4096));
        assert_pictures(&format!("a cove, depth {depth}"), &plain, &led);
        // Paths of three segments bring the light of the ceiling, which is found in any case.
        let [noise, less] = [&plain, &led].map(relative_variance);
        assert!(depth == 3 || less < 0.6 * noise, "depth {depth}: {less} and {noise}");
    }
    let (scene, free) = (lit_room(), look(6));
    let [plain, led] = [&free, &guided(&free)].map(|view| render(&scene, view, 2048));
    assert!(plain.radiance() != led.radiance(), "nothing is guided");
    assert_pictures("a room of many materials", &plain, &led);
}

#[test]
fn what_cannot_be_guided_is_as_without_a_guide() {
    let direct = look(2);
    let mut by_bsdf = look(6);
    by_bsdf.integrator.settings_mut().strategy = Strategy::Bsdf;
    for view in [direct, by_bsdf] {
        assert!(render(&cove(), &view, 4).radiance() == render(&cove(), &guided(&view), 4).radiance());
    }
    // No light comes from another surface.
    let mut scene = SceneBuilder::default();
    let floor = placed(Vec3::ONE, Quat::IDENTITY, Vec3::ZERO);
    scene.add(Primitive::Rectangle, floor, diffuse(0.5), Some(Rgb::ONE));
    let scene = scene.build();
    assert!(render(&scene, &look(6), 4).radiance() == render(&scene, &guided(&look(6)), 4).radiance());
}

#[test]
fn glass_and_metal_of_principled_models_are_not_guided() {
    let (glass, metal) = (
        Principled {
            spec_trans: 1.0,
            ..PRINCIPLED
        },
        Principled {
            metallic: 1.0,
            ..PRINCIPLED
        },
    );
    for model in [glass, metal] {
        let mut scene = SceneBuilder::default();
        let floor = placed(
            Vec3::ONE,
            Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2),
            Vec3::NEG_Y,
        );
        scene.add(Primitive::Rectangle, floor, Bsdf::Principled(model), None);
        let ball = placed(Vec3::splat(0.4), Quat::IDENTITY, Vec3::new(0.0, -0.5, 0.0));
        scene.add(Primitive::Sphere, ball, Bsdf::Principled(model), None);
        let lamp = placed(
            Vec3::splat(0.3),
            Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
            Vec3::new(0.0, 0.9, 0.0),
        );
        scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::splat(8.0)));
        let scene = scene.build();
        let pictures = [&look(8), &guided(&look(8))].map(|view| render(&scene, view, 16));
        assert!(pictures[0].radiance() == pictures[1].radiance(), "{model:?}");
    }
}

#[test]
fn what_is_below_coats_is_guided() {
    let (scene, free) = (coated_cove(), look(6));
    let [plain, led] = [&free, &guided(&free)].map(|view| render(&scene, view, 8192));
    assert_pictures("coated walls", &plain, &led);
    let [noise, less] = [&plain, &led].map(relative_variance);
    assert!(less < 0.7 * noise, "{less} and {noise}");
}

#[test]
fn normals_that_lean_are_guided_without_bias() {
    let (scene, free) = (ridged_cove(), look(6));
    let [plain, led] = [&free, &guided(&free)].map(|view| render(&scene, view, 8192));
    assert!(plain.radiance() != led.radiance(), "nothing is guided");
    assert_pictures("leaning normals", &plain, &led);
}

/// Whatever else is traced beside it, a guided sample is the same.
#[test]
fn guided_samples_do_not_depend_on_their_neighbours() {
    let view = guided(&View {
        width: 24,
        height: 24,
        ..look(6)
    });
    let go = AtomicBool::new(false);
    for scene in [cove(), ridged_cove(), coated_cove()] {
        let tile = tiles(24, 24)[0];
        for sample in 0..4 {
            let whole = render_tile(&scene, &view, tile, sample..sample + 1, &go).expect("not cancelled");
            for (number, expected) in whole.pixels.iter().enumerate() {
                let alone = Tile {
                    x: number as u32 % 24,
                    y: number as u32 / 24,
                    width: 1,
                    height: 1,
                };
                let alone = render_tile(&scene, &view, alone, sample..sample + 1, &go).expect("not cancelled");
                assert_eq!(alone.pixels[0], *expected, "pixel {number}, sample {sample}");
            }
        }
    }
}

#[test]
fn moments_of_one_scene_share_its_guide() {
    let (scene, other) = (cove(), lit_room());
    let moment = |scene: &RenderScene, shift: f32| {
        let mut view = look(6);
        view.camera = camera(Vec3::new(shift, 0.0, 3.4), Vec3::ZERO, 36.0);
        (scene.clone(), view)
    };
    let moments = [
        moment(&other, 0.0),
        moment(&scene, 0.1),
        moment(&other, 0.2),
        moment(&scene, 0.3),
    ];
    let guide = Guide::default();
    let shutter = Shutter::new(&moments, (&scene, &guide)).expect("four moments");
    let (known, others): (Vec<&Guide>, Vec<&Guide>) = shutter.guides().partition(|own| own.is_same(&guide));
    assert_eq!((known.len(), others.len()), (2, 2));
    assert!(others[0].is_same(others[1]), "the other scene has two guides");
}

fn traced(scene: &RenderScene, view: &View, tile: usize) -> TileSamples {
    let tile = tiles(view.width, view.height)[tile];
    render_tile(scene, view, tile, 3..7, &AtomicBool::new(false)).expect("not cancelled")
}

#[test]
fn a_guide_is_the_same_whoever_learns_it() {
    let scene = cove();
    let free = View {
        width: 96,
        height: 64,
        ..look(6)
    };
    let alone: Vec<TileSamples> = (0..6).map(|tile| traced(&scene, &guided(&free), tile)).collect();
    let together = guided(&free);
    // What is cancelled leaves the guide to the others.
    let cancelled = AtomicBool::new(true);
    assert!(render_tile(&scene, &together, tiles(96, 64)[0], 3..7, &cancelled).is_none());
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..6)
            .map(|tile| {
                scope.spawn({
                    let (scene, together) = (&scene, &together);
                    move || traced(scene, together, tile)
                })
            })
            .collect();
        for (worker, expected) in workers.into_iter().zip(&alone) {
            assert!(worker.join().expect("no panic") == *expected);
        }
    });
    // Another scene has a guide of its own, and so have paths of another length.
    assert!(traced(&lit_room(), &together, 1) == traced(&lit_room(), &guided(&free), 1));
    let mut longer = together.clone();
    longer.integrator.settings_mut().max_depth = 9;
    assert!(traced(&scene, &longer, 1) == traced(&scene, &guided(&longer), 1));
}
