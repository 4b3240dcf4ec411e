//! Lamps over planes, spheres and surfaces that light others.

use super::*;

/// CIE 171, 5.2: the illuminance of a point light is I cos^3 / h^2 on a plane.
#[test]
fn a_point_light_over_a_plane_falls_with_the_cube_of_the_cosine() {
    let (height, intensity) = (3.0, 100.0 / 683.0);
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Point {
        position: Vec3::new(0.5, height, -1.0),
        intensity: Rgb::splat(intensity),
    });
    let scene = scene.build();
    let places = [0.0, 1.0, 2.5, 5.0, 40.0];
    let meters = places.map(|x| facing(Vec3::Y, Vec3::new(0.5 + x, 0.0, -1.0))).to_vec();
    for (x, reading) in places.iter().zip(measure(&scene, meters, &exactly(64), 1)) {
        let (h, x) = (f64::from(height), f64::from(*x));
        let cosine = h / h.hypot(x);
        off("point", reading.points[0], 100.0 * cosine.powi(3) / (h * h));
    }
    // From behind no light arrives, and the dark is certain.
    let behind = &measure(&scene, vec![facing(Vec3::NEG_Y, Vec3::ZERO)], &exactly(64), 1)[0];
    assert_eq!(behind.points[0], Estimate::default());
}

/// CIE 171, 5.3.
#[test]
fn area_lights_over_a_plane_have_the_illuminance_of_their_form_factors() {
    let radiance = 4.0;
    let mut found = Vec::new();
    let (half, at) = (Vec2::new(0.5, 0.25), Vec3::new(0.3, 2.0, -0.2));
    let mut scene = SceneBuilder::default();
    scene.add(
        Primitive::Rectangle,
        rectangle(half, Vec3::NEG_Y, at),
        diffuse(0.0),
        Some(Rgb::splat(radiance)),
    );
    let scene_of_rectangle = scene.build();
    let reading = &measure(
        &scene_of_rectangle,
        vec![grid(Vec2::splat(2.0), Vec3::ZERO, 0.5)],
        &exactly(2048),
        2,
    )[0];
    assert_eq!(reading.points.len(), 64);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    // The lamp's own x is the world's, or its opposite.
    let corners = corners.map(|(x, z)| (at + Vec3::new(half.x * x, 0.0, half.y * z)).as_dvec3());
    for (place, measured) in reading.positions.iter().zip(&reading.points) {
        let expected = K * f64::from(radiance) * lambert(&corners, place.as_dvec3(), DVec3::Y);
        found.push(off("rectangle", *measured, expected));
    }
    // A disk over parallel elements at lateral distances (Howell, A Catalog of Radiation Heat Transfer Configuration
    // Factors, B-13).
    let (radius, height) = (0.7f64, 1.5f64);
    let mut scene = SceneBuilder::default();
    let place = rectangle(Vec2::splat(radius as f32), Vec3::NEG_Y, Vec3::Y * height as f32);
    scene.add(Primitive::Disk, place, diffuse(0.0), Some(Rgb::splat(radiance)));
    let scene = scene.build();
    let places: Vec<f32> = (0..16).map(|step| 0.2 * step as f32).collect();
    let meters = places.iter().map(|x| facing(Vec3::Y, Vec3::X * *x)).collect();
    for (x, reading) in places.iter().zip(measure(&scene, meters, &exactly(2048), 3)) {
        let (r, h, l) = (radius * radius, height * height, f64::from(*x).powi(2));
        let factor = 0.5 * (1.0 + (r - l - h) / ((l + h + r).powi(2) - 4.0 * r * l).sqrt());
        found.push(off("disk", reading.points[0], K * PI * f64::from(radiance) * factor));
    }
    assert_honest(&found);
}

/// CIE 171, 5.8, in a sphere, where the reflected light is the same everywhere.
#[test]
fn inside_of_spheres_light_is_the_same_everywhere() {
    let sphere = |albedo: f32, radiance: Option<Rgb>| {
        let mut scene = SceneBuilder::default();
        let place = Affine3A::from_scale(Vec3::splat(3.0));
        scene
            .add(Primitive::Sphere, place, diffuse(albedo), radiance)
            .flip_normals = true;
        scene
    };
    let meters = || {
        let places = [Vec3::ZERO, Vec3::new(1.0, 2.0, -1.5), Vec3::new(-2.9, 0.0, 0.0)];
        let normals = [Vec3::Y, Vec3::new(1.0, -1.0, 0.3), Vec3::NEG_Z];
        let pairs = places
            .into_iter()
            .flat_map(|at| normals.map(|normal| facing(normal, at)));
        pairs.collect::<Vec<_>>()
    };
    let mut found = Vec::new();
    for albedo in [0.0, 0.5, 0.8] {
        let scene = sphere(albedo, Some(Rgb::splat(3.0))).build();
        for reading in measure(&scene, meters(), &exactly(2048), 4) {
            let expected = K * PI * 3.0 / (1.0 - f64::from(albedo));
            let off = off("shining sphere", reading.points[0], expected);
            if albedo > 0.0 {
                found.push(off);
            }
        }
    }
    // An integrating sphere with a point light in its middle, measured on its wall.
    let (albedo, lumens) = (0.7, 500.0);
    let mut scene = sphere(albedo, None);
    scene.light(LightSource::Point {
        position: Vec3::ZERO,
        intensity: Rgb::splat((lumens / (4.0 * PI * K)) as f32),
    });
    let scene = scene.build();
    let normals = [Vec3::Y, Vec3::X, Vec3::new(1.0, 1.0, 1.0), Vec3::new(-3.0, 1.0, 0.5)];
    let walls = normals
        .map(|normal| facing(normal, -2.9999 * normal.normalize()))
        .to_vec();
    for reading in measure(&scene, walls, &exactly(8192), 5) {
        let expected = lumens / (4.0 * PI * 9.0) / (1.0 - f64::from(albedo));
        // The points are a little inside of the wall, nearer to the light.
        let nearer = lumens / (4.0 * PI) * (1.0 / 2.9999f64.powi(2) - 1.0 / 9.0);
        found.push(off("integrating sphere", reading.points[0], expected + nearer));
    }
    assert_honest(&found);
}

/// CIE 171, 5.6: a point light on a diffuse square, which lights a point beside it that the lamp does not reach.
#[test]
fn a_diffuse_surface_lights_what_faces_it() {
    let (albedo, intensity) = (0.8f32, 2.0f32);
    let mut scene = SceneBuilder::default();
    scene.add(
        Primitive::Rectangle,
        rectangle(Vec2::splat(0.5), Vec3::Y, Vec3::ZERO),
        diffuse(albedo),
        None,
    );
    let lamp = Vec3::new(0.2, 1.5, 0.1);
    scene.light(LightSource::Point {
        position: lamp,
        intensity: Rgb::splat(intensity),
    });
    let scene = scene.build();
    let (at, normal) = (DVec3::new(0.1, 0.8, -0.3), DVec3::NEG_Y);
    let window = |u: f64, v: f64| DVec3::new(u - 0.5, 0.0, v - 0.5);
    const STEPS: u32 = 1000;
    let middle = |step: u32| (f64::from(step) + 0.5) / f64::from(STEPS);
    let lit = |place: DVec3| {
        let way = lamp.as_dvec3() - place;
        f64::from(intensity) * way.normalize().y / way.length_squared()
    };
    let sum: f64 = (0..STEPS)
        .flat_map(|u| (0..STEPS).map(move |v| window(middle(u), middle(v))))
        .map(|place| {
            let way = place - at;
            let to = way.normalize();
            lit(place) * f64::from(albedo) / PI * to.dot(normal) * -to.y / way.length_squared()
        })
        .sum();
    let expected = K * sum / f64::from(STEPS * STEPS);
    let reading = &measure(&scene, vec![facing(Vec3::NEG_Y, at.as_vec3())], &exactly(1 << 14), 6)[0];
    off("reflected", reading.points[0], expected);
}
