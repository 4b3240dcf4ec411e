//! Light on texels against closed forms, the conservation of energy, the path tracer, and what must not leak.

use std::f32::consts::PI;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::bake::finish::finish;
use sunroom::bake::sides::lit_sides;
use sunroom::bake::texels::BakeSurface;
use sunroom::color::Rgb;
use sunroom::geometry::primitives::unit_cube;
use sunroom::light::{LightSource, Projector};
use sunroom::render::gathering::Gathering;
use sunroom::render::irradiance::ReceivedLight;
use sunroom::render::view::Strategy;
use sunroom::texture::Parameter;

use super::{DOWN, add_lamp, corner, covered, diffuse, gather, gathering, mean, patch, point, rectangle, settings};
use crate::support::{SceneBuilder, assert_close, camera, mean_luminance, render, view};

#[test]
fn a_rectangle_lights_a_point_by_its_form_factor() {
    let mut scene = SceneBuilder::default();
    add_lamp(&mut scene);
    let scene = scene.build();
    // Of a rectangle above the corner of which the point lies (Howell, factor B-4), four times.
    let (x, y) = (0.3f32 / 0.8, 0.5f32 / 0.8);
    let along = |x: f32, y: f32| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    let form_factor = 4.0 * (along(x, y) + along(y, x)) / (2.0 * PI);
    for strategy in [Strategy::Bsdf, Strategy::Light, Strategy::Mis] {
        let light = gather(
            &gathering(&scene, &settings(strategy)),
            &point(Vec3::ZERO, Vec3::Y),
            20_000,
        );
        assert_close(&format!("{strategy:?}"), mean(&light), 2.0 * PI * form_factor);
    }
    let below = gather(
        &gathering(&scene, &settings(Strategy::Mis)),
        &point(Vec3::ZERO, Vec3::NEG_Y),
        100,
    );
    assert_eq!(mean(&below).0, 0.0);
}

#[test]
fn all_light_of_a_lamp_is_found_on_the_walls() {
    let intensity = 0.7;
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Point {
        position: Vec3::new(0.2, -0.3, 0.1),
        intensity: Rgb::splat(intensity),
    });
    let scene = scene.build();
    let texels = 64.0;
    let walls = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let walls: Vec<BakeSurface> = (0..)
        .zip(walls)
        .map(|(number, outwards)| {
            let offset = Vec2::new(4.0 + 70.0 * (number % 3) as f32, 4.0 + 70.0 * (number / 3) as f32);
            patch(outwards, -outwards, 1.0, texels, offset)
        })
        .collect();
    let found = covered(&walls, UVec2::new(214, 144), 1);
    let light = gather(&gathering(&scene, &settings(Strategy::Mis)), &found, 1);
    let is_whole = |place: UVec2| {
        let within = (place.as_vec2() + 0.5 - 4.0) % 70.0;
        within.max_element() < texels
    };
    let whole: Vec<usize> = (0..found.texels.len())
        .filter(|&texel| found.texels[texel].place.min_element() >= 4 && is_whole(found.texels[texel].place))
        .collect();
    assert_eq!(whole.len(), 6 * 64 * 64);
    let area = (2.0 / texels).powi(2);
    let flux: f32 = whole.iter().map(|&texel| area * light.light(texel).x).sum();
    assert!((flux / (4.0 * PI * intensity) - 1.0).abs() < 1e-3, "{flux}");
}

#[test]
fn a_closed_furnace_sends_pi_times_its_radiance() {
    for albedo in [0.0, 0.5, 0.8] {
        let mut scene = SceneBuilder::default();
        scene
            .add(Primitive::Sphere, Affine3A::IDENTITY, diffuse(albedo), Some(Rgb::ONE))
            .flip_normals = true;
        let scene = scene.build();
        let texels = covered(
            &[patch(
                Vec3::new(0.1, 0.2, 0.0),
                Vec3::new(0.6, 0.8, 0.0),
                0.3,
                4.0,
                Vec2::splat(2.0),
            )],
            UVec2::splat(8),
            1,
        );
        let light = gather(&gathering(&scene, &settings(Strategy::Mis)), &texels, 400);
        assert_close(&format!("albedo {albedo}"), mean(&light), PI / (1.0 - albedo));
    }
}

#[test]
fn a_lightmap_shows_what_the_path_tracer_sees() {
    let scene = corner();
    let looking = view(
        camera(Vec3::new(2.0, 0.6, 0.4), Vec3::ZERO, 0.05),
        4,
        u32::MAX,
        Strategy::Mis,
    );
    let (seen, seen_error) = mean_luminance(&render(&scene, &looking, 4000));
    let texels = point(Vec3::ZERO, Vec3::Y);
    let (light, error) = mean(&gather(&gathering(&scene, &settings(Strategy::Mis)), &texels, 60_000));
    let factor = 0.6 / PI;
    let both = (factor * light, (factor * error).hypot(seen_error));
    assert_close("the floor", both, seen);

    let view = settings(Strategy::Mis);
    let without = Gathering {
        light: ReceivedLight::WithoutPunctual,
        ..gathering(&scene, &view)
    };
    let (rest, rest_error) = mean(&gather(&without, &texels, 60_000));
    let direct = 0.3 * 0.5 / 0.75f32.powf(1.5);
    assert_close("without the lamp", (light - rest, error.hypot(rest_error)), direct);
}

/// A level has no light in the place of a projector, so that its light has to be in the lightmap.
#[test]
fn light_of_projectors_is_never_left_out() {
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Projector(Projector {
        world_from_local: Affine3A::from_translation(Vec3::Y * 4.0) * Affine3A::from_rotation_x(PI / 2.0),
        irradiance: Parameter::Constant(Rgb::ONE),
        scale: 1.0,
        half_size: Vec2::splat(0.5),
    }));
    let scene = scene.build();
    let view = settings(Strategy::Mis);
    let of = |light| {
        let gathering = Gathering {
            light,
            ..gathering(&scene, &view)
        };
        mean(&gather(&gathering, &point(Vec3::ZERO, Vec3::Y), 16)).0
    };
    let all = of(ReceivedLight::All);
    assert!(all > 0.0);
    assert_eq!(of(ReceivedLight::WithoutPunctual), all);
}

#[test]
fn no_light_leaks_through_a_wall_into_a_dark_room() {
    let mut scene = SceneBuilder::default();
    let cube = || {
        let blas = sunroom::accel::Blas::build(std::sync::Arc::new(unit_cube()), sunroom::accel::SplitMethod::Sah);
        Primitive::Mesh(std::sync::Arc::new(blas))
    };
    let rooms = Affine3A::from_scale(Vec3::new(2.0, 1.0, 1.0));
    scene.add(cube(), rooms, diffuse(0.5), None).flip_normals = true;
    // Four texels thick.
    let wall = Affine3A::from_scale(Vec3::new(0.1, 1.1, 1.1));
    scene.add(cube(), wall, diffuse(0.5), None);
    let lamp = rectangle(Vec2::splat(0.3), Quat::from_rotation_x(DOWN), Vec3::new(-1.0, 0.9, 0.0));
    scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::ONE));
    let scene = scene.build();
    let corners = [(-2.0, 1.0), (2.0, 1.0), (2.0, -1.0), (-2.0, -1.0)];
    let floor = BakeSurface {
        positions: corners.map(|(x, z)| Vec3::new(x, -1.0, z)).to_vec(),
        coordinates: corners.map(|(x, z)| Vec2::new(x + 2.2, z + 1.2) * 20.0).to_vec(),
        // Row by row from the far end.
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..BakeSurface::default()
    };
    let texels = covered(&[floor], UVec2::new(88, 48), 1);
    let light = gather(&gathering(&scene, &settings(Strategy::Mis)), &texels, 64);
    let picture = finish(&texels, 0, &light, &[], None).expect("nothing is denoised");
    let row: Vec<f32> = (0..88).map(|x| picture.irradiance[24 * 88 + x].x).collect();
    // The wall is at columns 42 to 45.
    assert!(row[4..42].iter().all(|light| *light > 0.02), "{row:?}");
    let inside = row[40..44].windows(2).map(|two| two[1] / two[0]);
    assert!(
        inside.into_iter().all(|ratio| ratio > 0.7),
        "the wall is as bright as the floor beside it: {row:?}"
    );
    let dark = (46..88).flat_map(|x| (0..48).map(move |y| (x, y)));
    for (x, y) in dark {
        assert_eq!(picture.irradiance[y * 88 + x], Rgb::ZERO, "column {x}, row {y}");
    }
}

#[test]
fn sides_are_lit_where_light_comes() {
    let mut scene = SceneBuilder::default();
    add_lamp(&mut scene);
    let scene = scene.build();
    let view = settings(Strategy::Mis);
    let gathering = gathering(&scene, &view);
    let at = |height: f32| {
        [[
            Vec3::new(0.0, height, 0.0),
            Vec3::new(0.0, height, 1.0),
            Vec3::new(1.0, height, 0.0),
        ]]
    };
    let never = AtomicBool::new(false);
    assert_eq!(lit_sides(&gathering, &at(0.0), &never), (true, false));
    let turned = at(0.0).map(|[a, b, c]| [a, c, b]);
    assert_eq!(lit_sides(&gathering, &turned, &never), (false, true));
    assert_eq!(lit_sides(&gathering, &at(2.0), &never), (false, false));
    assert_eq!(lit_sides(&gathering, &[[Vec3::ZERO; 3]], &never), (false, false));
}
