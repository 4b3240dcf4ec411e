//! Skies, openings to them, and glare.

use super::*;

#[test]
fn a_uniform_sky_lights_a_plane_by_pi() {
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(2.0),
    });
    let ground = rectangle(Vec2::splat(1e5), Vec3::Y, Vec3::ZERO);
    scene.add(Primitive::Rectangle, ground, diffuse(0.0), None);
    // A wall beside the second point, which takes half of its sky but for what is seen past its ends.
    let wall = rectangle(Vec2::splat(50.0), Vec3::X, Vec3::new(20.0, 0.0, 0.0));
    scene.add(Primitive::Rectangle, wall, diffuse(0.0), None);
    let scene = scene.build();
    let places = [
        (Vec3::Y, Vec3::new(-4e4, 0.01, 0.0)),
        (Vec3::X, Vec3::new(-4e4, 1.0, 0.0)),
        (Vec3::Y, Vec3::new(20.01, 0.01, 0.0)),
        (Vec3::Y, Vec3::new(12.0, 0.01, 7.0)),
    ];
    let readings = measure(
        &scene,
        places.map(|(normal, at)| facing(normal, at)).to_vec(),
        &exactly(4096),
        7,
    );
    let whole = K * 2.0 * PI;
    let past_wall = |at: Vec3| {
        // What is above the horizon of the point.
        let low = f64::from(at.y);
        let corners = [(low, -50.0), (50.0, -50.0), (50.0, 50.0), (low, 50.0)].map(|(y, z)| DVec3::new(20.0, y, z));
        K * 2.0 * (PI - lambert(&corners, at.as_dvec3(), DVec3::Y))
    };
    off("open plane", readings[0].points[0], whole);
    off("upright", readings[1].points[0], 0.5 * whole);
    let behind = past_wall(places[2].1);
    assert!(
        (behind / (0.5 * whole) - 1.0).abs() < 2e-3,
        "half of the sky is hidden: {behind} of {whole}"
    );
    off("at the wall", readings[2].points[0], behind);
    off("before the wall", readings[3].points[0], past_wall(places[3].1));
}

#[test]
fn an_overcast_sky_gives_the_open_ground_its_lux() {
    for up in [Vec3::Y, Vec3::Z, Vec3::NEG_X] {
        // A lamp of the scene does not shine under that sky, nor does another sky.
        let mut scene = SceneBuilder::default();
        let lamp = rectangle(Vec2::splat(0.01), -up, 5.0 * up);
        scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::splat(1e9)));
        scene.light(LightSource::Constant { radiance: Rgb::ONE });
        let scene = lit_by(&scene.build(), overcast_sky(up));
        let side = up.any_orthonormal_vector();
        let meters = [up, side, -up].map(|normal| facing(normal, Vec3::ZERO)).to_vec();
        let readings = measure(&scene, meters, &exactly(1 << 14), 8);
        let ground = f64::from(OPEN_GROUND);
        // The lamp's shadow is of no account.
        off("ground", readings[0].points[0], ground);
        // Upright, of the zenith's luminance: pi / 6 + 4 / 9, for 7 pi / 9 on the ground.
        let upright = ground * (PI / 6.0 + 4.0 / 9.0) / (7.0 / 9.0 * PI);
        off("upright", readings[1].points[0], upright);
        assert!(readings[2].points[0].value < 1e-3 * ground, "{:?}", readings[2]);
        assert!((daylight_factor(readings[0].points[0].value) - 100.0).abs() < 1.0);
    }
}

/// CIE 171, 5.9 and 5.11: the sky component through openings of a black room of 4 x 4 x 3 without glass.
#[test]
fn the_sky_through_openings_has_the_sky_component_of_the_openings() {
    let zenith = f64::from(OPEN_GROUND) / (7.0 / 9.0 * PI);
    let mut found = Vec::new();
    let slab = |scene: &mut SceneBuilder, half: Vec2, normal: Vec3, at: Vec3| {
        scene.add(Primitive::Rectangle, rectangle(half, normal, at), diffuse(0.0), None);
    };
    // Closed but for one side; the openings are made of the parts around them.
    let closed = |without: Vec3| {
        let mut scene = SceneBuilder::default();
        for (normal, middle) in [
            (Vec3::X, Vec3::new(-2.0, 1.5, 0.0)),
            (Vec3::NEG_X, Vec3::new(2.0, 1.5, 0.0)),
            (Vec3::Z, Vec3::new(0.0, 1.5, -2.0)),
            (Vec3::NEG_Z, Vec3::new(0.0, 1.5, 2.0)),
            (Vec3::Y, Vec3::new(0.0, 0.0, 0.0)),
            (Vec3::NEG_Y, Vec3::new(0.0, 3.0, 0.0)),
        ] {
            if normal != without {
                slab(&mut scene, Vec2::splat(2.0), normal, middle);
            }
        }
        scene
    };
    // A hole of 1 x 1 in the middle of the roof.
    let mut roof = closed(Vec3::NEG_Y);
    for (x, z, half) in [
        (-1.25, 0.0, Vec2::new(0.75, 2.0)),
        (1.25, 0.0, Vec2::new(0.75, 2.0)),
        (0.0, -1.25, Vec2::new(0.5, 0.75)),
        (0.0, 1.25, Vec2::new(0.5, 0.75)),
    ] {
        slab(&mut roof, half, Vec3::NEG_Y, Vec3::new(x, 3.0, z));
    }
    let scene = lit_by(&roof.build(), overcast_sky(Vec3::Y));
    let floor = || vec![grid(Vec2::splat(1.9), Vec3::Y * 1e-3, 0.7)];
    let reading = &measure(&scene, floor(), &exactly(8192), 9)[0];
    let hole = |u: f64, v: f64| DVec3::new(u - 0.5, 3.0, v - 0.5);
    for (place, measured) in reading.positions.iter().zip(&reading.points) {
        let expected = zenith * through(hole, DVec3::Y, 1.0, place.as_dvec3(), DVec3::Y);
        found.push(off("roof", *measured, expected));
    }
    // A window of 2 x 1 in a wall, 1 above the floor.
    let mut facade = closed(Vec3::NEG_X);
    for (y, z, half) in [
        (0.5, 0.0, Vec2::new(0.5, 2.0)),
        (2.5, 0.0, Vec2::new(0.5, 2.0)),
        (1.5, -1.5, Vec2::new(0.5, 0.5)),
        (1.5, 1.5, Vec2::new(0.5, 0.5)),
    ] {
        let place = Affine3A::from_mat3_translation(
            glam::Mat3::from_cols(Vec3::Y * half.x, Vec3::Z * half.y, Vec3::X),
            Vec3::new(2.0, y, z),
        );
        facade.add(Primitive::Rectangle, place, diffuse(0.0), None);
    }
    let scene = lit_by(&facade.build(), overcast_sky(Vec3::Y));
    let reading = &measure(&scene, floor(), &exactly(8192), 10)[0];
    let window = |u: f64, v: f64| DVec3::new(2.0, 1.0 + u, 2.0 * v - 1.0);
    for (place, measured) in reading.positions.iter().zip(&reading.points) {
        let expected = zenith * through(window, DVec3::X, 2.0, place.as_dvec3(), DVec3::Y);
        found.push(off("facade", *measured, expected));
    }
    assert_honest(&found);
}

/// A lamp of known luminance in a uniform sky, seen above the line of sight (CIE 117).
#[test]
fn the_glare_of_a_lamp_follows_from_its_place_and_luminance() {
    let (lamp, sky) = (20.0f32, 0.2f32);
    for (up, half) in [(0.0, 0.2), (0.8, 0.2), (1.5, 0.1)] {
        let (eye, middle) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, up, -3.0));
        let mut scene = SceneBuilder::default();
        let place = rectangle(Vec2::splat(half), Vec3::Z, eye + middle);
        scene.add(Primitive::Rectangle, place, diffuse(0.0), Some(Rgb::splat(lamp)));
        scene.light(LightSource::Constant {
            radiance: Rgb::splat(sky),
        });
        let scene = scene.build();
        let sight = camera(eye, eye - Vec3::Z, 40.0);
        let found = glare(&scene, &settings(3), &sight, &AtomicBool::new(false)).expect("a place");
        const STEPS: u32 = 200;
        let share = |step: u32| 2.0 * (step as f32 + 0.5) / STEPS as f32 - 1.0;
        let cell = f64::from(2.0 * half / STEPS as f32).powi(2);
        let (mut sum, mut angle, mut factor) = (0.0, 0.0, 0.0);
        for way in (0..STEPS).flat_map(|u| (0..STEPS).map(move |v| half * Vec3::new(share(u), share(v), 0.0))) {
            let way = middle + way;
            let cosine = f64::from(-way.z / way.length());
            let solid_angle = cell * cosine / f64::from(way.length_squared());
            // In the space of the camera the line of sight is +z.
            sum += solid_angle / position_index(Vec3::new(way.x, way.y, -way.z)).powi(2);
            angle += solid_angle;
            factor += solid_angle * cosine;
        }
        let background = K * f64::from(sky) * (PI - factor) / PI;
        let expected = 8.0 * (0.25 / background * (K * f64::from(lamp)).powi(2) * sum).log10();
        let rating = found.rating.expect("a source");
        assert!(
            (rating.value - expected).abs() < 0.1,
            "{up}: {rating:?}, expected {expected}"
        );
        assert!((found.background.value / background - 1.0).abs() < 0.01, "{found:?}");
        assert!(
            found.solid_angle > angle && found.solid_angle < 1.6 * angle,
            "{} {angle}",
            found.solid_angle
        );
    }
    let mut dull = SceneBuilder::default();
    dull.light(LightSource::Constant { radiance: Rgb::ONE });
    let sight = camera(Vec3::ZERO, Vec3::X, 40.0);
    let found = glare(&dull.build(), &settings(3), &sight, &AtomicBool::new(false)).expect("a place");
    assert_eq!(found.rating, None);
}

#[test]
fn meters_in_a_surface_near_the_origin_are_not_shadowed_by_it() {
    for turn in 0..24 {
        let turned = Quat::from_euler(glam::EulerRot::XYZ, 0.37 * turn as f32, 0.11 + 0.23 * turn as f32, 0.7);
        let mut scene = SceneBuilder::default();
        scene.light(LightSource::Constant { radiance: Rgb::ONE });
        let floor = Affine3A::from_scale_rotation_translation(Vec3::new(200.0, 200.0, 1.0), turned, Vec3::ZERO);
        scene.add(Primitive::Rectangle, floor, diffuse(0.0), None);
        let meter = asked(MeterKind::Point, Affine3A::from_quat(turned));
        let reading = &measure(&scene.build(), vec![meter], &exactly(1024), 3)[0];
        off("in the floor", reading.points[0], K * PI);
    }
}

#[test]
fn light_through_a_pinhole_is_not_taken_for_darkness() {
    // A closed box but for a hole of 10 x 10 cm in the middle of its roof.
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(100.0),
    });
    for (normal, middle) in [
        (Vec3::X, Vec3::new(-2.0, 2.0, 0.0)),
        (Vec3::NEG_X, Vec3::new(2.0, 2.0, 0.0)),
        (Vec3::Z, Vec3::new(0.0, 2.0, -2.0)),
        (Vec3::NEG_Z, Vec3::new(0.0, 2.0, 2.0)),
        (Vec3::Y, Vec3::new(0.0, 0.0, 0.0)),
    ] {
        scene.add(
            Primitive::Rectangle,
            rectangle(Vec2::splat(2.0), normal, middle),
            diffuse(0.0),
            None,
        );
    }
    for (x, z, half) in [
        (-1.025, 0.0, Vec2::new(0.975, 2.0)),
        (1.025, 0.0, Vec2::new(0.975, 2.0)),
        (0.0, -1.025, Vec2::new(0.05, 0.975)),
        (0.0, 1.025, Vec2::new(0.05, 0.975)),
    ] {
        let roof = rectangle(half, Vec3::NEG_Y, Vec3::new(x, 4.0, z));
        scene.add(Primitive::Rectangle, roof, diffuse(0.0), None);
    }
    let scene = scene.build();
    let end = MeterEnd {
        noise: 0.2,
        ..exactly(1 << 20)
    };
    let meter = || vec![facing(Vec3::Y, 0.01 * Vec3::Y)];
    for seed in 0..5 {
        let reading = &measure(&scene, meter(), &end, seed)[0];
        assert!(reading.points[0].value > 0.0, "seed {seed}: {:?}", reading.points[0]);
    }
}
