//! Pictures whose radiance is known: furnaces, closed forms, and the agreement of the three strategies.

use std::f32::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::bsdf_support::Single;
use crate::statistics::sphere_integral;
use crate::support::{
    SceneBuilder, assert_close, camera, mean_luminance, render, square_mesh, square_of_three_triangles, view,
};
use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::{Blas, Primitive, SplitMethod};
use sunroom::color::{Rgb, luminance};
use sunroom::geometry::primitives::unit_cube;
use sunroom::light::LightSource;
use sunroom::material::{Material, MaterialId};
use sunroom::render::scene::RenderScene;
use sunroom::render::tile::{Tile, render_tile, tiles};
use sunroom::render::view::{LONGEST_PATH, Strategy, View};
use sunroom::sampling::SequenceKind;
use sunroom::shading::{
    Bsdf, Compensation, Conductor, ConductorSpecular, Dielectric, DielectricModel, Diffuse, Fiber, Hair, Metal,
    Microfacet, MicrofacetKind, RoughConductor,
};
use sunroom::texture::Parameter;

const STRATEGIES: [Strategy; 3] = [Strategy::Bsdf, Strategy::Light, Strategy::Mis];
const UNBOUNDED: u32 = u32::MAX;

fn diffuse(reflectance: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(reflectance),
    })
}

fn glass(eta: f32) -> Bsdf {
    Bsdf::Dielectric(Dielectric {
        eta,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    })
}

fn hair(sigma_a: Rgb) -> Bsdf {
    Bsdf::Hair(Hair {
        fiber: Fiber::new(1.55, 0.3, 0.3, 0.03),
        sigma_a,
    })
}

/// A mirror without loss.
fn perfect() -> ConductorSpecular {
    ConductorSpecular {
        eta: Rgb::ZERO,
        k: Rgb::ONE,
        specular_reflectance: Rgb::ONE,
    }
}

fn placed(scale: f32, translation: Vec3) -> Affine3A {
    Affine3A::from_scale_rotation_translation(Vec3::splat(scale), Quat::IDENTITY, translation)
}

/// Rotates a square that faces +z to face down, at height `y`.
fn facing_down(half_size: f32, y: f32) -> Affine3A {
    Affine3A::from_scale_rotation_translation(
        Vec3::splat(half_size),
        Quat::from_rotation_x(PI / 2.0),
        Vec3::new(0.0, y, 0.0),
    )
}

fn floor(material: impl Into<Material>) -> SceneBuilder {
    let mut scene = SceneBuilder::default();
    let up = Affine3A::from_rotation_x(-PI / 2.0) * Affine3A::from_scale(Vec3::splat(50.0));
    scene.add(Primitive::Rectangle, up, material, None);
    scene
}

/// A narrow look at the origin of the floor.
fn look_at_origin(max_depth: u32, strategy: Strategy) -> View {
    view(
        camera(Vec3::new(3.0, 0.6, 0.0), Vec3::ZERO, 0.05),
        4,
        max_depth,
        strategy,
    )
}

fn check(what: &str, scene: &RenderScene, view: &View, samples: u32, expected: f32) {
    assert_close(what, mean_luminance(&render(scene, view, samples)), expected);
}

#[test]
fn a_closed_furnace_shines_like_a_geometric_series() {
    for albedo in [0.2, 0.5, 0.8] {
        let mut scene = SceneBuilder::default();
        scene
            .add(Primitive::Sphere, Affine3A::IDENTITY, diffuse(albedo), Some(Rgb::ONE))
            .flip_normals = true;
        let scene = scene.build();
        for strategy in STRATEGIES {
            let view = view(camera(Vec3::new(0.2, 0.1, -0.3), Vec3::X, 90.0), 8, UNBOUNDED, strategy);
            check(
                &format!("albedo {albedo}, {strategy:?}"),
                &scene,
                &view,
                1024,
                1.0 / (1.0 - albedo),
            );
        }
    }
}

#[test]
fn nothing_lossless_is_seen_in_an_even_sky() {
    let bsdfs = [
        ("diffuse", diffuse(1.0)),
        ("mirror", Bsdf::Conductor(Conductor { specular: perfect() })),
        ("glass", glass(1.5)),
        (
            "metal",
            Bsdf::Metal(Metal {
                color: Rgb::ONE,
                fuzz: 0.0,
            }),
        ),
        ("hair", hair(Rgb::ZERO)),
    ];
    for (name, bsdf) in bsdfs {
        let mut scene = SceneBuilder::default();
        scene.add(Primitive::Sphere, Affine3A::IDENTITY, bsdf, None);
        scene.light(LightSource::Constant { radiance: Rgb::ONE });
        let scene = scene.build();
        for strategy in [Strategy::Bsdf, Strategy::Mis] {
            let view = view(
                camera(Vec3::new(0.0, 0.0, -4.0), Vec3::ZERO, 40.0),
                16,
                UNBOUNDED,
                strategy,
            );
            check(&format!("{name}, {strategy:?}"), &scene, &view, 256, 1.0);
        }
    }
}

/// Light that crosses a fibre meets its surface twice and is scattered once, however it is found.
#[test]
fn a_fiber_in_an_even_sky_shows_what_it_scatters() {
    let brown = hair(Rgb::new(0.4, 0.7, 1.4));
    let mut scene = SceneBuilder::default();
    scene.add(Primitive::Cylinder, Affine3A::IDENTITY, brown, None);
    scene.light(LightSource::Constant { radiance: Rgb::ONE });
    let scene = scene.build();
    // Seen from straight ahead.
    let single = Single::new("hair", brown);
    let expected = sphere_integral(Vec3::Z, |wi| luminance(single.eval(Vec3::Z, wi)));
    for strategy in STRATEGIES {
        let (eye, target) = (Vec3::new(4.0, 0.0, 0.5), Vec3::new(0.0, 0.0, 0.5));
        let view = view(camera(eye, target, 0.1), 8, UNBOUNDED, strategy);
        check(&format!("{strategy:?}"), &scene, &view, 256, expected as f32);
    }
}

#[test]
fn a_point_light_follows_the_inverse_square_and_the_cosine() {
    let mut scene = floor(diffuse(0.6));
    let position = Vec3::new(1.0, 2.0, 0.5);
    scene.light(LightSource::Point {
        position,
        intensity: Rgb::splat(7.0),
    });
    let scene = scene.build();
    let expected = 0.6 / PI * 7.0 * (position.y / position.length()) / position.length_squared();
    for strategy in STRATEGIES {
        check(
            &format!("{strategy:?}"),
            &scene,
            &look_at_origin(2, strategy),
            64,
            expected,
        );
    }
}

#[test]
fn a_directional_light_follows_the_cosine() {
    let mut scene = floor(diffuse(0.5));
    let direction = Vec3::new(1.0, -2.0, 0.3).normalize();
    scene.light(LightSource::Directional {
        direction,
        irradiance: Rgb::splat(3.0),
    });
    check(
        "sun",
        &scene.build(),
        &look_at_origin(2, Strategy::Mis),
        64,
        0.5 / PI * 3.0 * -direction.y,
    );
}

#[test]
fn a_sphere_light_gives_its_projected_solid_angle() {
    // Centre straight above: E = pi L (r / d)^2.
    let mut scene = floor(diffuse(0.5));
    scene.add(
        Primitive::Sphere,
        placed(0.5, Vec3::new(0.0, 2.0, 0.0)),
        diffuse(0.0),
        Some(Rgb::splat(4.0)),
    );
    let scene = scene.build();
    for strategy in STRATEGIES {
        let expected = 0.5 * 4.0 * (0.5f32 / 2.0).powi(2);
        check(
            &format!("{strategy:?}"),
            &scene,
            &look_at_origin(2, strategy),
            4096,
            expected,
        );
    }
}

#[test]
fn a_disk_light_gives_its_form_factor() {
    // Coaxial disk: E = pi L r^2 / (r^2 + d^2).
    let mut scene = floor(diffuse(0.5));
    scene.add(
        Primitive::Disk,
        facing_down(0.8, 1.5),
        diffuse(0.0),
        Some(Rgb::splat(2.0)),
    );
    let scene = scene.build();
    let expected = 0.5 * 2.0 * 0.64 / (0.64 + 2.25);
    for strategy in STRATEGIES {
        check(
            &format!("{strategy:?}"),
            &scene,
            &look_at_origin(2, strategy),
            4096,
            expected,
        );
    }
}

#[test]
fn a_square_light_gives_its_form_factor_as_rectangle_and_as_mesh() {
    // Four corner patches of a differential element to a parallel rectangle (Howell's catalogue, B-3), half size a at
    // distance d.
    let (a, d) = (0.9f32, 1.2f32);
    let x = a / d;
    let root = (1.0 + x * x).sqrt();
    let form_factor = 4.0 / (2.0 * PI) * 2.0 * x / root * (x / root).atan();
    for (name, primitive) in [
        ("rectangle", Primitive::Rectangle),
        ("two triangles", square_mesh()),
        ("three triangles", square_of_three_triangles()),
    ] {
        let mut scene = floor(diffuse(0.7));
        scene.add(primitive, facing_down(a, d), diffuse(0.0), Some(Rgb::splat(3.0)));
        let scene = scene.build();
        for strategy in STRATEGIES {
            check(
                &format!("{name}, {strategy:?}"),
                &scene,
                &look_at_origin(2, strategy),
                4096,
                0.7 * 3.0 * form_factor,
            );
        }
    }
}

#[test]
fn a_stretched_sphere_shines_the_same_however_it_is_found() {
    let mut scene = floor(diffuse(0.5));
    let to_world = Affine3A::from_scale_rotation_translation(
        Vec3::new(0.9, 0.2, -0.5),
        Quat::from_rotation_z(0.4),
        Vec3::new(0.3, 1.4, 0.2),
    );
    scene.add(Primitive::Sphere, to_world, diffuse(0.0), Some(Rgb::splat(5.0)));
    let scene = scene.build();
    let by = |strategy| mean_luminance(&render(&scene, &look_at_origin(2, strategy), 16384));
    let reference = by(Strategy::Bsdf);
    assert!(reference.0 > 0.1);
    for strategy in [Strategy::Light, Strategy::Mis] {
        let (mean, error) = by(strategy);
        assert_close(&format!("{strategy:?}"), (mean, error.hypot(reference.1)), reference.0);
    }
}

#[test]
fn light_comes_from_the_front_only() {
    let mut scene = floor(diffuse(0.5));
    let up = Affine3A::from_translation(Vec3::Y) * Affine3A::from_rotation_x(-PI / 2.0);
    scene.add(Primitive::Rectangle, up, diffuse(0.0), Some(Rgb::ONE));
    let scene = scene.build();
    for strategy in STRATEGIES {
        check(&format!("{strategy:?}"), &scene, &look_at_origin(2, strategy), 64, 0.0);
    }
}

/// A room with glossy, clear and diffuse things and lights of every kind that both techniques can find.
fn furnished_room() -> RenderScene {
    let mut scene = SceneBuilder::default();
    let walls = [
        (Vec3::X, -PI / 2.0),
        (Vec3::X, PI / 2.0),
        (Vec3::Y, PI / 2.0),
        (Vec3::Y, -PI / 2.0),
        (Vec3::X, 0.0),
    ];
    for (index, (axis, angle)) in walls.into_iter().enumerate() {
        let rotation = Affine3A::from_quat(Quat::from_axis_angle(axis, angle));
        let away = Affine3A::from_translation(-rotation.transform_vector3(Vec3::Z));
        scene.add(
            Primitive::Rectangle,
            away * rotation,
            diffuse(0.3 + 0.1 * index as f32),
            None,
        );
    }
    let gold = RoughConductor {
        specular: ConductorSpecular {
            eta: Rgb::new(0.14, 0.37, 1.44),
            k: Rgb::new(3.98, 2.39, 1.6),
            specular_reflectance: Rgb::ONE,
        },
        distribution: Microfacet::new(MicrofacetKind::Ggx, 0.2, 0.2),
        multiple_scattering: Compensation::NONE,
    };
    scene.add(
        Primitive::Sphere,
        placed(0.35, Vec3::new(-0.5, -0.65, 0.1)),
        Bsdf::RoughConductor(gold),
        None,
    );
    let brushed = Bsdf::Metal(Metal {
        color: Rgb::splat(0.8),
        fuzz: 0.3,
    });
    scene.add(Primitive::Sphere, placed(0.3, Vec3::new(0.5, -0.7, 0.3)), brushed, None);
    scene.add(
        Primitive::Rectangle,
        facing_down(0.3, 0.98),
        diffuse(0.0),
        Some(Rgb::splat(8.0)),
    );
    scene.add(
        Primitive::Sphere,
        placed(0.12, Vec3::new(0.6, 0.3, -0.4)),
        diffuse(0.5),
        Some(Rgb::splat(20.0)),
    );
    scene.add(
        square_of_three_triangles(),
        placed(0.2, Vec3::new(-0.4, 0.3, -0.9)),
        diffuse(0.2),
        Some(Rgb::splat(6.0)),
    );
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(0.3),
    });
    scene.build()
}

#[test]
fn the_strategies_converge_to_one_picture() {
    let scene = furnished_room();
    for max_depth in [2, 6] {
        let look = |strategy| {
            view(
                camera(Vec3::new(0.0, 0.0, 3.5), Vec3::ZERO, 40.0),
                24,
                max_depth,
                strategy,
            )
        };
        let by = |strategy| render(&scene, &look(strategy), 1500);
        let reference = by(Strategy::Mis);
        for strategy in [Strategy::Bsdf, Strategy::Light] {
            let other = by(strategy);
            let ((a, da), (b, db)) = (mean_luminance(&reference), mean_luminance(&other));
            assert_close(&format!("depth {max_depth}, {strategy:?}"), (b, da.hypot(db)), a);
        }
    }
}

#[test]
fn roulette_does_not_shift_the_picture() {
    let scene = furnished_room();
    let look = |rr_depth| {
        let mut view = view(
            camera(Vec3::new(0.0, 0.0, 3.5), Vec3::ZERO, 40.0),
            24,
            12,
            Strategy::Mis,
        );
        let settings = view.integrator.settings_mut();
        settings.rr_depth = rr_depth;
        mean_luminance(&render(&scene, &view, 1000))
    };
    let (with, without) = (look(1), look(100));
    assert_close(
        "roulette from the first bounce",
        (with.0, with.1.hypot(without.1)),
        without.0,
    );
}

#[test]
fn scrambled_points_and_independent_numbers_agree() {
    let scene = furnished_room();
    let look = |sequence| {
        let mut view = view(camera(Vec3::new(0.0, 0.0, 3.5), Vec3::ZERO, 40.0), 24, 6, Strategy::Mis);
        view.sequence = sequence;
        mean_luminance(&render(&scene, &view, 1024))
    };
    let (a, b) = (look(SequenceKind::Independent), look(SequenceKind::Sobol));
    assert_close("sobol", (b.0, a.1.hypot(b.1)), a.0);
}

#[test]
fn the_longest_path_is_respected() {
    let mut scene = floor(diffuse(0.5));
    scene.add(
        Primitive::Rectangle,
        facing_down(1.0, 1.0),
        diffuse(0.5),
        Some(Rgb::ONE),
    );
    let scene = scene.build();
    let at = |max_depth| mean_luminance(&render(&scene, &look_at_origin(max_depth, Strategy::Mis), 2048)).0;
    assert_eq!(at(1), 0.0, "the floor itself does not shine");
    assert!(at(2) > 0.0);
    assert!(at(4) > 1.02 * at(2), "light between floor and lamp adds up");
}

/// The rays of one sample of one pixel.
fn rays_of(scene: &RenderScene, view: &View, x: u32, y: u32, sample: u32) -> u64 {
    let pixel = Tile {
        x,
        y,
        width: 1,
        height: 1,
    };
    let result = render_tile(scene, view, pixel, sample..sample + 1, &AtomicBool::new(false));
    result.expect("not cancelled").rays
}

/// Shadow rays towards the cube end a rounding before its faces, and now and then meet these faces all the same.
fn an_emitter_that_lets_light_pass(material: Material) {
    let mut scene = floor(diffuse(0.5));
    let cube = Primitive::Mesh(Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah)));
    scene.add(cube, placed(1.0, Vec3::Y), material, Some(Rgb::splat(3.0)));
    let scene = scene.build();
    let look = |size, strategy| {
        let eye = camera(Vec3::new(2.0, 3.0, 4.0), Vec3::Y, 45.0);
        view(eye, size, UNBOUNDED, strategy)
    };
    let fine = look(32, Strategy::Mis);
    for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x, y))) {
        for sample in 0..8 {
            let rays = rays_of(&scene, &fine, x, y, sample);
            assert!(rays < 1000, "pixel {x}, {y}, sample {sample}: {rays} rays");
        }
    }
    let [by_bsdf, by_light, by_both] =
        STRATEGIES.map(|strategy| mean_luminance(&render(&scene, &look(8, strategy), 512)));
    assert_close("bsdf", (by_bsdf.0, by_bsdf.1.hypot(by_both.1)), by_both.0);
    assert_close("light", (by_light.0, by_light.1.hypot(by_both.1)), by_both.0);
}

#[test]
fn shadow_rays_to_an_emitter_without_a_surface_come_to_an_end() {
    an_emitter_that_lets_light_pass(Material::Null);
}

#[test]
fn shadow_rays_to_an_emitter_that_is_masked_away_come_to_an_end() {
    an_emitter_that_lets_light_pass(Material::Mask {
        nested: MaterialId(0),
        opacity: Parameter::Constant(0.0),
    });
}

#[test]
fn a_path_that_nothing_ends_is_cut() {
    let mut scene = SceneBuilder::default();
    scene
        .add(Primitive::Sphere, Affine3A::IDENTITY, diffuse(1.0), None)
        .flip_normals = true;
    let scene = scene.build();
    let mut view = view(camera(Vec3::ZERO, Vec3::X, 90.0), 1, UNBOUNDED, Strategy::Mis);
    let settings = view.integrator.settings_mut();
    settings.rr_depth = u32::MAX;
    assert_eq!(rays_of(&scene, &view, 0, 0, 0), u64::from(LONGEST_PATH));
}

/// Two lamps above a floor, one facing down and one up, seen from above. The floor is 0.5 x 0.5 bright by the sky
/// alone.
fn lamps_before_the_floor(max_depth: u32, hide_emitters: bool) -> (f32, f32, f32) {
    let mut scene = floor(diffuse(0.5));
    let lamp = Some(Rgb::ONE);
    scene.add(Primitive::Rectangle, facing_down(1e-3, 1.0), diffuse(0.0), lamp);
    let facing_up = Affine3A::from_translation(Vec3::Y * 1.5)
        * Affine3A::from_rotation_x(-PI / 2.0)
        * Affine3A::from_scale(Vec3::splat(1e-3));
    scene.add(Primitive::Rectangle, facing_up, diffuse(0.0), lamp);
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(0.5),
    });
    let mut view = view(camera(Vec3::Y * 2.0, Vec3::ZERO, 0.01), 4, max_depth, Strategy::Mis);
    let settings = view.integrator.settings_mut();
    settings.hide_emitters = hide_emitters;
    let film = render(&scene.build(), &view, 64);
    let (mean, error) = mean_luminance(&film);
    (mean, error, film.depth()[0])
}

#[test]
fn hidden_emitters_light_but_do_not_show() {
    let (seen, _, depth) = lamps_before_the_floor(2, false);
    assert!(
        (seen - 1.0).abs() < 1e-4 && (depth - 0.5).abs() < 1e-5,
        "{seen} {depth}"
    );
    let (behind, error, depth) = lamps_before_the_floor(2, true);
    // What the tiny lamps add and hide is less than the tolerance.
    assert_close("the floor behind both", (behind, error + 1e-4), 0.25);
    assert!((depth - 2.0).abs() < 1e-5, "{depth}");
    let (too_short, _, _) = lamps_before_the_floor(1, true);
    assert_eq!(too_short, 0.0, "the floor itself does not shine");
}

/// As in Mitsuba 3.9: the sky is hidden behind what lets the camera ray pass straight on, and seen in a mirror.
#[test]
fn a_hidden_sky_is_hidden_behind_panes_too() {
    let through = |material: Material| {
        let mut scene = SceneBuilder::default();
        scene.add(Primitive::Rectangle, Affine3A::IDENTITY, material, None);
        scene.light(LightSource::Constant { radiance: Rgb::ONE });
        let mut view = view(camera(Vec3::Z * 2.0, Vec3::ZERO, 10.0), 4, 8, Strategy::Mis);
        let settings = view.integrator.settings_mut();
        settings.hide_emitters = true;
        mean_luminance(&render(&scene.build(), &view, 4)).0
    };
    assert_eq!(through(Material::Null), 0.0);
    assert_eq!(through(Bsdf::Conductor(Conductor { specular: perfect() }).into()), 1.0);
}

#[test]
fn a_longest_path_of_nothing_is_black() {
    let mut scene = SceneBuilder::default();
    scene.add(Primitive::Sphere, Affine3A::IDENTITY, diffuse(0.5), Some(Rgb::ONE));
    scene.light(LightSource::Constant { radiance: Rgb::ONE });
    let scene = scene.build();
    // The lamp in the middle, the sky around it.
    let seen = |max_depth| {
        let view = view(camera(Vec3::Z * 4.0, Vec3::ZERO, 60.0), 8, max_depth, Strategy::Mis);
        mean_luminance(&render(&scene, &view, 4)).0
    };
    assert_eq!((seen(0), seen(1)), (0.0, 1.0));
}

#[test]
fn refraction_through_a_slab_of_glass_keeps_what_fresnel_leaves() {
    // Two parallel faces seen at normal incidence pass (1 - R) / (1 + R) of the sky behind and reflect the rest of an
    // equal sky.
    let mut scene = SceneBuilder::default();
    for (z, turn) in [(0.1, 0.0), (-0.1, PI)] {
        let to_world = Affine3A::from_translation(Vec3::Z * z) * Affine3A::from_rotation_y(turn);
        scene.add(
            Primitive::Rectangle,
            to_world * Affine3A::from_scale(Vec3::splat(100.0)),
            glass(1.5),
            None,
        );
    }
    // A glowing wall behind; in front it is dark.
    let behind = Affine3A::from_translation(Vec3::Z * -5.0) * Affine3A::from_scale(Vec3::splat(100.0));
    scene.add(Primitive::Rectangle, behind, diffuse(0.0), Some(Rgb::ONE));
    let r = (0.5f32 / 2.5).powi(2);
    let look = view(
        camera(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.1),
        8,
        UNBOUNDED,
        Strategy::Mis,
    );
    check("slab", &scene.build(), &look, 4096, (1.0 - r) / (1.0 + r));
}

#[test]
fn two_sided_means_both_sides() {
    let sun = LightSource::Directional {
        direction: Vec3::Y,
        irradiance: Rgb::splat(PI),
    };
    let from_below = view(camera(Vec3::new(0.0, -3.0, 0.0), Vec3::ZERO, 5.0), 4, 2, Strategy::Mis);
    let mut one_sided = floor(diffuse(0.5));
    one_sided.light(sun.clone());
    check(
        "the back of a one-sided floor",
        &one_sided.build(),
        &from_below,
        16,
        0.0,
    );

    let mut two_sided = floor(Material::TwoSided {
        front: MaterialId(1),
        back: MaterialId(1),
    });
    // Far away; it only brings the bsdf that the floor refers to.
    two_sided.add(Primitive::Disk, placed(1.0, Vec3::X * 1e3), diffuse(0.5), None);
    two_sided.light(sun);
    check(
        "the back of a two-sided floor",
        &two_sided.build(),
        &from_below,
        16,
        0.5,
    );
}

#[test]
fn samples_are_a_pure_function_of_pixel_and_index() {
    let scene = furnished_room();
    let look = view(camera(Vec3::new(0.0, 0.0, 3.5), Vec3::ZERO, 40.0), 40, 6, Strategy::Mis);
    let go = AtomicBool::new(false);
    for tile in tiles(40, 40) {
        let whole = render_tile(&scene, &look, tile, 0..2, &go).expect("not cancelled");
        let again = render_tile(&scene, &look, tile, 0..2, &go).expect("not cancelled");
        assert_eq!(whole, again);
        let mut parts = render_tile(&scene, &look, tile, 0..1, &go).expect("not cancelled");
        let second = render_tile(&scene, &look, tile, 1..2, &go).expect("not cancelled");
        for (sum, pixel) in parts.pixels.iter_mut().zip(&second.pixels) {
            sum.add(pixel);
        }
        assert_eq!(whole.pixels, parts.pixels);
    }
}

#[test]
fn a_cancelled_tile_gives_nothing() {
    let scene = furnished_room();
    let look = view(camera(Vec3::new(0.0, 0.0, 3.5), Vec3::ZERO, 40.0), 40, 6, Strategy::Mis);
    assert_eq!(
        render_tile(&scene, &look, tiles(40, 40)[0], 0..4, &AtomicBool::new(true)),
        None
    );
}
