//! Bidirectional path tracing and light tracing against path tracing.

use std::f32::consts::PI;
use std::sync::Arc;

use crate::support::{SceneBuilder, assert_close, camera, mean_luminance, render, view};
use glam::{Affine3A, Quat, Vec2, Vec3};
use sunroom::accel::{Blas, Primitive, SplitMethod};
use sunroom::color::Rgb;
use sunroom::geometry::primitives::unit_cube;
use sunroom::layer::{Layer, Layers};
use sunroom::light::{LightSource, Spot};
use sunroom::material::Material;
use sunroom::render::camera::{Camera, ThinLens};
use sunroom::render::film::Film;
use sunroom::render::filter::{FilterKernel, PixelFilter};
use sunroom::render::light_layers::LightGroups;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Integrator, Strategy, View};
use sunroom::render::visibility::sight::CutPlane;
use sunroom::sampling::SequenceKind;
use sunroom::shading::{
    Bsdf, Compensation, Conductor, ConductorSpecular, Dielectric, DielectricModel, Diffuse, Microfacet, MicrofacetKind,
    RoughConductor, RoughDielectric,
};
use sunroom::texture::Parameter;

pub fn diffuse(reflectance: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(reflectance),
    })
}

pub fn glass() -> Bsdf {
    Bsdf::Dielectric(Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    })
}

fn metal() -> ConductorSpecular {
    ConductorSpecular {
        eta: Rgb::splat(0.2),
        k: Rgb::splat(3.0),
        specular_reflectance: Rgb::ONE,
    }
}

fn facets(alpha: f32) -> Microfacet {
    Microfacet::new(MicrofacetKind::Ggx, alpha, alpha)
}

pub fn placed(scale: Vec3, turn: Quat, translation: Vec3) -> Affine3A {
    Affine3A::from_scale_rotation_translation(scale, turn, translation)
}

/// A room of five walls, open towards +z, with things of several materials in it.
fn room(scene: &mut SceneBuilder) {
    let walls = [
        (Quat::from_rotation_x(-PI / 2.0), Vec3::new(0.0, -1.0, 0.0), 0.6),
        (Quat::from_rotation_x(PI / 2.0), Vec3::new(0.0, 1.0, 0.0), 0.6),
        (Quat::IDENTITY, Vec3::new(0.0, 0.0, -1.0), 0.5),
        (Quat::from_rotation_y(PI / 2.0), Vec3::new(-1.0, 0.0, 0.0), 0.7),
        (Quat::from_rotation_y(-PI / 2.0), Vec3::new(1.0, 0.0, 0.0), 0.4),
    ];
    for (turn, place, reflectance) in walls {
        scene.add(
            Primitive::Rectangle,
            placed(Vec3::ONE, turn, place),
            diffuse(reflectance),
            None,
        );
    }
    let ball = |x: f32, z: f32, radius: f32| placed(Vec3::splat(radius), Quat::IDENTITY, Vec3::new(x, radius - 1.0, z));
    scene.add(Primitive::Sphere, ball(-0.5, 0.2, 0.3), glass(), None);
    let rough = Bsdf::RoughConductor(RoughConductor {
        distribution: facets(0.3),
        specular: metal(),
        multiple_scattering: Compensation::NONE,
    });
    scene.add(Primitive::Sphere, ball(0.4, 0.4, 0.25), rough, None);
    let frosted = Bsdf::RoughDielectric(RoughDielectric {
        distribution: facets(0.25),
        model: DielectricModel::Exact,
        eta: 1.4,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    });
    let cube = Primitive::Mesh(Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah)));
    let box_place = placed(
        Vec3::new(0.2, 0.35, 0.2),
        Quat::from_rotation_y(0.4),
        Vec3::new(0.45, -0.65, -0.4),
    );
    scene.add(cube, box_place, frosted, None);
}

fn lamp(scene: &mut SceneBuilder) {
    let down = placed(
        Vec3::splat(0.3),
        Quat::from_rotation_x(PI / 2.0),
        Vec3::new(0.0, 0.98, 0.0),
    );
    scene.add(Primitive::Rectangle, down, diffuse(0.3), Some(Rgb::splat(8.0)));
}

pub fn lit_room() -> RenderScene {
    let mut scene = SceneBuilder::default();
    room(&mut scene);
    lamp(&mut scene);
    scene.build()
}

pub fn look(depth: u32) -> View {
    view(
        camera(Vec3::new(0.1, 0.0, 3.4), Vec3::new(0.0, -0.1, 0.0), 36.0),
        8,
        depth,
        Strategy::Mis,
    )
}

pub fn by(integrator: fn(sunroom::render::view::PathSettings) -> Integrator, view: &View) -> View {
    View {
        integrator: integrator(view.integrator.settings()),
        ..view.clone()
    }
}

fn assert_same(what: &str, scene: &RenderScene, view: &View, samples: u32) {
    let (a, b) = (
        render(scene, view, samples),
        render(scene, &by(Integrator::Bidirectional, view), samples),
    );
    assert_pictures(what, &a, &b);
}

/// The same mean, and pixels that differ by no more than their noise.
pub fn assert_pictures(what: &str, a: &Film, b: &Film) {
    let ((x, dx), (y, dy)) = (mean_luminance(a), mean_luminance(b));
    assert!(x > 0.0, "{what} is black");
    assert_close(what, (y, dx.hypot(dy)), x);
    // Quarters of the picture show what the mean hides.
    let quarter = |film: &Film, part: [u32; 2]| {
        let (mut sum, mut variance) = (0.0, 0.0);
        let half = [film.width() / 2, film.height() / 2];
        for (x, y) in (0..half[1]).flat_map(|y| (0..half[0]).map(move |x| (x, y))) {
            let [x, y] = [x + part[0] * half[0], y + part[1] * half[1]];
            let pixel = film.pixel(x, y).expect("samples");
            sum += sunroom::color::luminance(pixel.radiance);
            variance += film.standard_error(x, y).expect("samples").powi(2);
        }
        (sum, variance.sqrt())
    };
    for part in [[0, 0], [1, 0], [0, 1], [1, 1]] {
        let ((x, dx), (y, dy)) = (quarter(a, part), quarter(b, part));
        assert_close(&format!("{what}, quarter {part:?}"), (y, dx.hypot(dy)), x);
    }
}

#[test]
fn both_ends_find_what_one_end_finds() {
    let scene = lit_room();
    for depth in [1, 2, 3, 4, 6] {
        assert_same(&format!("depth {depth}"), &scene, &look(depth), 1500);
    }
}

#[test]
fn every_kind_of_light_is_found() {
    let at = Vec3::new(0.2, 0.6, 0.9);
    let spot = Spot {
        world_from_local: Affine3A::look_at_rh(at, Vec3::new(-0.2, -1.0, 0.0), Vec3::Y).inverse()
            * Affine3A::from_rotation_y(PI),
        intensity: Rgb::splat(3.0),
        cutoff_angle: 0.7,
        beam_angle: 0.5,
        texture: Parameter::Constant(Rgb::ONE),
    };
    let lights = [
        (
            "point",
            LightSource::Point {
                position: at,
                intensity: Rgb::splat(1.5),
            },
        ),
        ("spot", LightSource::Spot(spot)),
        (
            "directional",
            LightSource::Directional {
                direction: Vec3::new(-0.3, -0.4, -1.0).normalize(),
                irradiance: Rgb::splat(2.0),
            },
        ),
        (
            "constant",
            LightSource::Constant {
                radiance: Rgb::splat(0.8),
            },
        ),
    ];
    for (name, light) in lights {
        // Path tracing does not find the light of points behind glass.
        let mut scene = SceneBuilder::default();
        room(&mut scene);
        scene.light(light.clone());
        let scene = scene.build();
        let depth = if name == "constant" { 5 } else { 2 };
        assert_same(name, &scene, &look(depth), 2000);
        // With the lamp as well.
        let mut scene = SceneBuilder::default();
        room(&mut scene);
        lamp(&mut scene);
        scene.light(light);
        assert_same(&format!("{name} and lamp"), &scene.build(), &look(2), 1500);
    }
}

#[test]
fn every_camera_and_filter_is_found() {
    let scene = lit_room();
    let lens = ThinLens {
        aperture_radius: 0.15,
        focus_distance: 2.5,
        blades: 5,
        blade_rotation: 0.3,
    };
    let pose = Affine3A::from_rotation_translation(Quat::from_rotation_y(PI), Vec3::new(0.0, 0.0, 3.4));
    let cameras = [
        ("thin lens", Camera::new(pose, 36.0, 1.0, 0.1, 20.0, Some(lens))),
        ("parallel", Camera::orthographic(pose, Vec2::splat(0.9), 0.1, 20.0)),
        (
            "cropped",
            Camera::new(pose, 50.0, 1.0, 0.1, 20.0, None).cropped(Vec2::new(0.2, 0.3), Vec2::new(0.8, 0.9)),
        ),
        ("behind the near plane", Camera::new(pose, 36.0, 1.0, 3.4, 4.0, None)),
    ];
    for (name, camera) in cameras {
        let mut view = look(4);
        view.camera = camera;
        assert_same(name, &scene, &view, 1000);
    }
    let filters = [
        ("tent", PixelFilter::Tent { radius: 1.5 }),
        (
            "gaussian",
            PixelFilter::tabulated(FilterKernel::Gaussian { stddev: 0.7 }),
        ),
        (
            "mitchell",
            PixelFilter::tabulated(FilterKernel::Cubic {
                b: 1.0 / 3.0,
                c: 1.0 / 3.0,
            }),
        ),
        ("lanczos", PixelFilter::tabulated(FilterKernel::Lanczos { lobes: 3 })),
    ];
    for (name, filter) in filters {
        let view = View { filter, ..look(3) };
        assert_same(name, &scene, &view, 1000);
        let light = by(
            Integrator::LightTracing,
            &View {
                filter: PixelFilter::Box,
                ..view.clone()
            },
        );
        let filtered = by(Integrator::LightTracing, &view);
        let mut diffuse_room = SceneBuilder::default();
        room(&mut diffuse_room);
        lamp(&mut diffuse_room);
        let scene = diffuse_room.build();
        let ((x, dx), (y, dy)) = (
            mean_luminance(&render(&scene, &light, 1000)),
            mean_luminance(&render(&scene, &filtered, 1000)),
        );
        // Light at the edge of the picture is shared with what is beside it.
        assert_close(name, (y, dx.hypot(dy) + 0.01 * x), x);
    }
}

/// Without mirrors and glass, paths from the lights find everything.
#[test]
fn light_tracing_finds_all_but_what_mirrors_show() {
    let mut scene = SceneBuilder::default();
    room(&mut scene);
    lamp(&mut scene);
    let mirror = Bsdf::Conductor(Conductor { specular: metal() });
    let scene_with_mirror = {
        let mut scene = SceneBuilder::default();
        let wall = placed(Vec3::splat(3.0), Quat::IDENTITY, Vec3::new(0.0, 0.0, -1.0));
        scene.add(Primitive::Rectangle, wall, mirror, None);
        lamp(&mut scene);
        scene.build()
    };
    let mut below_the_lamp = look(6);
    below_the_lamp.camera = camera(Vec3::new(0.1, 0.0, 3.4), Vec3::new(0.0, -0.1, 0.0), 15.0);
    let dark = render(&scene_with_mirror, &by(Integrator::LightTracing, &below_the_lamp), 64);
    assert_eq!(mean_luminance(&dark).0, 0.0);
    // Only the walls: what is seen in the glass ball is black.
    let mut walls = look(5);
    walls.camera = camera(Vec3::new(0.0, 0.5, 0.9), Vec3::new(0.0, 0.45, -1.0), 50.0);
    let scene = scene.build();
    let (a, b) = (
        render(&scene, &walls, 2000),
        render(&scene, &by(Integrator::LightTracing, &walls), 2000),
    );
    assert_pictures("walls", &a, &b);
}

/// A half transparent sheet before the camera and another below the lamp, whose materials are nested in others.
fn veiled_room(hides: bool) -> RenderScene {
    let mut scene = SceneBuilder::default();
    room(&mut scene);
    lamp(&mut scene);
    let veil = |scene: &mut SceneBuilder, opacity: f32, to_world: Affine3A| {
        let nested = scene.material(diffuse(0.5));
        let veil = Material::Mask {
            nested,
            opacity: Parameter::Constant(opacity),
        };
        scene.add(Primitive::Rectangle, to_world, veil, None);
    };
    let below = placed(
        Vec3::splat(0.6),
        Quat::from_rotation_x(PI / 2.0),
        Vec3::new(0.0, 0.6, 0.0),
    );
    veil(&mut scene, 0.4, below);
    veil(
        &mut scene,
        0.3,
        placed(Vec3::splat(0.8), Quat::IDENTITY, Vec3::new(0.3, 0.0, 1.2)),
    );
    if hides {
        // A lamp before the camera's eye.
        let before = placed(Vec3::splat(0.2), Quat::IDENTITY, Vec3::new(-0.3, 0.2, 1.5));
        scene.add(Primitive::Rectangle, before, diffuse(0.2), Some(Rgb::splat(2.0)));
    }
    scene.build()
}

#[test]
fn surfaces_that_let_light_pass_are_passed() {
    let scene = veiled_room(false);
    for depth in [2, 3, 4, 6] {
        assert_same(&format!("depth {depth}"), &scene, &look(depth), 1500);
    }
}

#[test]
fn hidden_lamps_are_hidden_from_the_camera_alone() {
    let scene = veiled_room(true);
    for is_hidden in [false, true] {
        let mut view = look(4);
        view.integrator.settings_mut().hide_emitters = is_hidden;
        assert_same(&format!("hidden: {is_hidden}"), &scene, &view, 1500);
    }
}

/// A cut plane through the room, and walls that are seen through from behind.
#[test]
fn what_the_camera_looks_through_stays_in_the_light() {
    let scene = lit_room();
    let mut view = look(4);
    view.sight.cut = Some(CutPlane {
        normal: Vec3::Z,
        offset: 0.3,
    });
    assert_same("cut", &scene, &view, 1500);
    let mut view = look(4);
    view.camera = camera(Vec3::new(2.5, 1.2, 1.0), Vec3::new(0.0, -0.3, 0.0), 40.0);
    view.sight.passes_backs = true;
    assert_same("backs", &scene, &view, 1500);
}

/// Vertex normals that are far from those of the triangles: light that comes from a lamp is corrected for them.
#[test]
fn shading_normals_are_corrected_for() {
    for bsdf in [diffuse(0.8), glass()] {
        let mut scene = SceneBuilder::default();
        room(&mut scene);
        lamp(&mut scene);
        let mut mesh = unit_cube();
        let center = mesh.positions.iter().copied().sum::<Vec3>() / mesh.positions.len() as f32;
        mesh.normals = mesh.positions.iter().map(|&p| (p - center).normalize()).collect();
        let smooth = Primitive::Mesh(Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)));
        let place = placed(Vec3::splat(0.4), Quat::from_rotation_y(0.7), Vec3::new(0.0, -0.2, 0.2));
        scene.add(smooth, place, bsdf, None);
        assert_same("smooth cube", &scene.build(), &look(4), 2000);
    }
}

#[test]
fn roulette_does_not_shift_the_picture() {
    let scene = lit_room();
    let mut view = look(8);
    let early = render(&scene, &by(Integrator::Bidirectional, &view), 1000);
    view.integrator.settings_mut().rr_depth = 1;
    assert_pictures(
        "roulette from the first bounce",
        &early,
        &render(&scene, &by(Integrator::Bidirectional, &view), 1500),
    );
}

/// What no path from the camera can find: a spot's light behind a glass ball. All of it is as bright on the floor as
/// the power that the ball takes up and lets through, whatever its shape.
#[test]
fn a_caustic_has_the_power_of_the_light_that_makes_it() {
    let mut scene = SceneBuilder::default();
    let floor = placed(
        Vec3::splat(40.0),
        Quat::from_rotation_x(-PI / 2.0),
        Vec3::new(0.0, -2.0, 0.0),
    );
    scene.add(Primitive::Rectangle, floor, diffuse(0.5), None);
    // The pane bends nothing but what goes through it, and loses nothing but what it reflects.
    scene.add(Primitive::Sphere, Affine3A::from_scale(Vec3::splat(0.5)), glass(), None);
    scene.light(LightSource::Point {
        position: Vec3::new(0.0, 3.0, 0.0),
        intensity: Rgb::splat(10.0),
    });
    let with_ball = scene.build();
    let seen = |depth| {
        let mut view = look(depth);
        // From below a plane cannot be seen: the camera looks down from beside, through nothing.
        view.camera = Camera::orthographic(
            Affine3A::from_rotation_translation(Quat::from_rotation_x(PI / 2.0), Vec3::new(0.0, -0.9, 0.0)),
            Vec2::splat(6.0),
            0.0,
            10.0,
        );
        view.sequence = SequenceKind::Sobol;
        mean_luminance(&render(&with_ball, &by(Integrator::Bidirectional, &view), 4000))
    };
    // The direct light in the square, without the shadow, and the light that the ball sends there.
    let (direct, all) = (seen(2), seen(4));
    let irradiance = |x: f32, z: f32| {
        let squared = x * x + z * z + 25.0;
        10.0 * 5.0 / squared.powf(1.5)
    };
    let steps = 400;
    let cell = |step: i32| -6.0 + 12.0 * (step as f32 + 0.5) / steps as f32;
    // The cone of the ball has half the angle asin(1 / 6): its shadow is where a ray meets it.
    let is_shadowed = |x: f32, z: f32| {
        let along = 3.0 * 5.0 / (x * x + z * z + 25.0).sqrt();
        9.0 - along * along < 0.25
    };
    let mut expected = 0.0;
    for (x, z) in (0..steps).flat_map(|a| (0..steps).map(move |b| (cell(a), cell(b)))) {
        if !is_shadowed(x, z) {
            expected += irradiance(x, z) * 0.5 / PI;
        }
    }
    expected /= (steps * steps) as f32;
    assert_close("direct", (direct.0, direct.1 + 1e-3 * expected), expected);
    // Normal incidence loses 4 % twice; the rest of the cone's light loses little more, as far as it is refracted
    // twice.
    let solid_angle = 2.0 * PI * (1.0 - (1.0f32 - 1.0 / 36.0).sqrt());
    let most = 10.0 * solid_angle * 0.5 / PI / 144.0;
    let caustic = all.0 - direct.0;
    assert!((0.75 * most..0.96 * most).contains(&caustic), "{caustic} of {most}");
}

/// What is kept beside the picture adds up to it, joined paths included.
#[test]
fn layers_and_groups_have_all_light() {
    let mut scene = SceneBuilder::default();
    room(&mut scene);
    lamp(&mut scene);
    scene.light(LightSource::Point {
        position: Vec3::new(0.2, 0.6, 0.9),
        intensity: Rgb::splat(0.5),
    });
    let scene = scene.build();
    let parted = View {
        light_groups: LightGroups::new(&[0, 1]),
        layers: Layers::of(&[Layer::Direct, Layer::Indirect, Layer::Emitted]),
        ..by(Integrator::Bidirectional, &look(5))
    };
    let film = render(&scene, &parted, 400);
    for (x, y) in (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y))) {
        let radiance = film.pixel(x, y).expect("samples").radiance;
        let mixed = film.mixed_pixel(x, y, &[Rgb::ONE, Rgb::ONE]).expect("samples");
        assert!(
            radiance.abs_diff_eq(mixed, 1e-4 * radiance.max_element()),
            "{radiance} {mixed}"
        );
    }
    // Without splats it is the same picture, with more noise.
    assert_pictures("parted", &render(&scene, &by(Integrator::Path, &look(2)), 800), &{
        let mut view = parted.clone();
        view.integrator.settings_mut().max_depth = 2;
        render(&scene, &view, 800)
    });
}

/// A lamp that reflects, behind a veil, is lit by the others: the camera only looks through lamps before its first
/// surface.
#[test]
fn lamps_behind_a_veil_are_not_hidden() {
    let mut scene = SceneBuilder::default();
    room(&mut scene);
    lamp(&mut scene);
    let wall = placed(Vec3::splat(0.7), Quat::IDENTITY, Vec3::new(0.0, 0.0, 0.3));
    scene.add(Primitive::Rectangle, wall, diffuse(0.9), Some(Rgb::splat(0.05)));
    let nested = scene.material(diffuse(0.5));
    let veil = Material::Mask {
        nested,
        opacity: Parameter::Constant(0.3),
    };
    scene.add(
        Primitive::Rectangle,
        placed(Vec3::splat(0.9), Quat::IDENTITY, Vec3::new(0.0, 0.0, 0.8)),
        veil,
        None,
    );
    let scene = scene.build();
    let mut view = look(4);
    view.integrator.settings_mut().hide_emitters = true;
    assert_same("veiled lamp", &scene, &view, 2000);
}

#[test]
fn without_depth_the_picture_is_black_but_knows_its_surfaces() {
    let scene = lit_room();
    let films =
        [Integrator::Path, Integrator::Bidirectional].map(|integrator| render(&scene, &by(integrator, &look(0)), 4));
    for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
        let [path, both] = [&films[0], &films[1]].map(|film| film.pixel(x, y).expect("samples"));
        assert_eq!(both.radiance, Rgb::ZERO);
        assert!((path.depth - both.depth).abs() < 1e-5 && path.normal.abs_diff_eq(both.normal, 1e-5));
        let [path, both] = [&films[0], &films[1]].map(|film| film.first_hit(x, y).map(|hit| (hit.instance, hit.uv)));
        assert_eq!(path.map(|hit| hit.0), both.map(|hit| hit.0));
        assert!(
            path.zip(both)
                .is_none_or(|(path, both)| path.1.abs_diff_eq(both.1, 1e-5))
        );
    }
}
