//! Probes against closed forms: what is seen from a point, and the light from six sides.

use std::f32::consts::PI;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, UVec3, Vec2, Vec3};
use sunroom::accel::{Blas, Primitive, SplitMethod};
use sunroom::bake::lightmap::Lightmaps;
use sunroom::bake::placement::{PlacementError, around, check_sight, is_enclosed, seeing};
use sunroom::bake::prefilter::Prefiltered;
use sunroom::bake::progress::Work;
use sunroom::bake::reflection::{finish, outlook};
use sunroom::bake::texels::Texels;
use sunroom::bake::volume::Grid;
use sunroom::color::Rgb;
use sunroom::geometry::primitives::unit_cube;
use sunroom::light::LightSource;
use sunroom::render::gathering::{Gathering, Site};
use sunroom::render::irradiance::ReceivedLight;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Strategy, View};
use sunroom::shading::{Bsdf, Diffuse};

use crate::support::{SceneBuilder, camera, view};

const AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

fn diffuse(reflectance: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(reflectance),
    })
}

/// A view for its settings; the camera does not matter.
fn settings() -> View {
    View {
        seed: 5,
        ..view(camera(Vec3::ONE, Vec3::ZERO, 90.0), 1, u32::MAX, Strategy::Mis)
    }
}

fn gathering<'a>(scene: &'a RenderScene, view: &'a View) -> Gathering<'a> {
    Gathering {
        scene,
        view,
        light: ReceivedLight::WithoutPunctual,
    }
}

fn gather<S: Site>(scene: &RenderScene, texels: &Texels<S>, samples: u32) -> Lightmaps {
    let mut light = Lightmaps::new(texels.texels.len());
    let view = settings();
    assert!(light.add(&gathering(scene, &view), texels, samples, &AtomicBool::new(false)));
    assert_eq!(light.invalid, 0);
    light
}

fn reflection(scene: &RenderScene, world_from_box: &Affine3A, samples: u32) -> Prefiltered {
    let texels = outlook(world_from_box, 16);
    let light = gather(scene, &texels, samples);
    finished(world_from_box, &light)
}

fn finished(world_from_box: &Affine3A, light: &Lightmaps) -> Prefiltered {
    let work = &mut Work {
        pool: &rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads"),
        cancel: &AtomicBool::new(false),
        watch: &mut |_| {},
    };
    let finished = finish(world_from_box, 16, light, false, work).expect("nothing is denoised");
    finished.expect("nothing cancels it")
}

/// A long, low box that is turned.
fn slanting(at: Vec3) -> Affine3A {
    Affine3A::from_scale_rotation_translation(Vec3::new(4.0, 1.0, 2.0), Quat::from_rotation_y(0.7), at)
}

/// A rectangle that faces `normal` and shines.
fn add_lamp(scene: &mut SceneBuilder, at: Vec3, normal: Vec3, half_size: Vec2, radiance: Rgb) {
    let turned = Quat::from_rotation_arc(Vec3::Z, normal);
    let place = Affine3A::from_scale_rotation_translation(half_size.extend(1.0), turned, at);
    scene.add(Primitive::Rectangle, place, diffuse(0.0), Some(radiance));
}

/// A sphere of radius 50 that shines inwards.
fn add_sky(scene: &mut SceneBuilder, radiance: f32) {
    let sky = Affine3A::from_scale(Vec3::splat(50.0));
    scene
        .add(Primitive::Sphere, sky, diffuse(0.0), Some(Rgb::splat(radiance)))
        .flip_normals = true;
}

#[test]
fn a_probe_inside_of_a_shining_sphere_has_its_radiance_everywhere() {
    for albedo in [0.0, 0.5] {
        let mut scene = SceneBuilder::default();
        let sphere = Affine3A::from_scale(Vec3::splat(10.0));
        scene
            .add(Primitive::Sphere, sphere, diffuse(albedo), Some(Rgb::splat(3.0)))
            .flip_normals = true;
        let scene = scene.build();
        // Of a closed furnace.
        let expected = 3.0 / (1.0 - albedo);
        let pictures = reflection(&scene, &slanting(Vec3::new(1.0, 0.5, -2.0)), 64);
        let sizes: Vec<u32> = pictures.specular.iter().map(|level| level.size).collect();
        assert_eq!(sizes, [16, 8, 4]);
        // Of a black sphere every sample is exact. Else the first level has the noise of single texels.
        for (level, picture) in pictures.specular.iter().chain([&pictures.diffuse]).enumerate() {
            let tolerance = match albedo > 0.0 {
                true => [0.4, 0.1, 0.05, 0.05][level],
                false => 1e-4,
            };
            for texel in &picture.texels {
                let error = (*texel / expected - 1.0).abs().max_element();
                assert!(error < tolerance, "level {level}: {texel} for {expected}");
            }
        }
    }
}

#[test]
fn a_uniform_environment_is_seen_in_each_direction_and_lights_each_side() {
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Constant {
        radiance: Rgb::new(1.0, 2.0, 4.0),
    });
    let scene = scene.build();
    let pictures = reflection(&scene, &slanting(Vec3::ZERO), 2);
    for picture in pictures.specular.iter().chain([&pictures.diffuse]) {
        for texel in &picture.texels {
            assert!(texel.abs_diff_eq(Rgb::new(1.0, 2.0, 4.0), 1e-4), "{texel}");
        }
    }
    let grid = Grid::new(slanting(Vec3::ZERO), Some(1.0)).expect("a grid");
    assert_eq!(grid.points, UVec3::new(4, 1, 2));
    let (size, texels) = grid.texture(&gather(&scene, &grid.texels(), 400));
    assert_eq!((size, texels.len()), (UVec3::new(4, 2, 6), 48));
    for texel in texels {
        // Lights are sampled, too, so that a sample is not the mean.
        assert!(texel.abs_diff_eq(Rgb::new(1.0, 2.0, 4.0), 0.08), "{texel}");
    }
}

/// The irradiance by a polygon of radiance 1 (Lambert 1760; Arvo, 1994, equation 2.4), of which only what is above the
/// horizon counts. The corners are relative to the point, clockwise as seen from there.
fn lambert(corners: &[Vec3], normal: Vec3) -> f32 {
    let mut above = Vec::new();
    for (index, &from) in corners.iter().enumerate() {
        let to = corners[(index + 1) % corners.len()];
        let (low, high) = (from.dot(normal), to.dot(normal));
        if low >= 0.0 {
            above.push(from);
        }
        if (low < 0.0) != (high < 0.0) {
            above.push(from.lerp(to, low / (low - high)));
        }
    }
    let edges = (0..above.len()).map(|index| {
        let (from, to) = (above[index], above[(index + 1) % above.len()]);
        from.angle_between(to) * from.cross(to).normalize_or_zero().dot(normal)
    });
    0.5 * edges.sum::<f32>().abs()
}

#[test]
fn a_point_below_a_lamp_has_the_irradiance_of_the_lamp_on_six_sides() {
    let mut scene = SceneBuilder::default();
    let (half, at) = (Vec2::new(0.6, 0.6), Vec3::new(0.3, 0.8, 0.0));
    add_lamp(&mut scene, at, Vec3::NEG_Y, half, Rgb::splat(2.0));
    let scene = scene.build();
    let corners = [(-0.6, -0.6), (0.6, -0.6), (0.6, 0.6), (-0.6, 0.6)].map(|(x, z)| at + Vec3::new(x, 0.0, z));
    let grid = Grid::new(Affine3A::from_scale(Vec3::splat(0.1)), Some(1.0)).expect("a grid");
    let light = gather(&scene, &grid.texels(), 20_000);
    for (side, axis) in AXES.into_iter().enumerate() {
        let expected = 2.0 * lambert(&corners, axis);
        let found = light.light(side).x;
        assert!(
            (found - expected).abs() < 0.01 * expected.max(0.2),
            "{axis}: {found} for {expected}"
        );
    }
    // The known form factor of a square above its middle checks the formula itself.
    let above = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| Vec3::new(x, 1.0, z));
    let factor = 4.0 / (2.0 * PI) * 2.0 * (0.5f32.sqrt() * 0.5f32.sqrt().atan());
    assert!((lambert(&above, Vec3::Y) / PI - factor).abs() < 1e-5);
}

#[test]
fn half_a_sky_lights_the_sides_by_half() {
    let mut scene = SceneBuilder::default();
    add_sky(&mut scene, 2.0);
    let floor =
        Affine3A::from_scale_rotation_translation(Vec3::splat(49.0), Quat::from_rotation_x(-PI / 2.0), Vec3::ZERO);
    scene.add(Primitive::Rectangle, floor, diffuse(0.0), None);
    let scene = scene.build();
    let grid = Grid::new(Affine3A::from_scale(Vec3::splat(0.02)), Some(1.0)).expect("a grid");
    let place = Affine3A::from_translation(Vec3::Y * 0.02) * grid.world_from_box;
    let grid = Grid {
        world_from_box: place,
        ..grid
    };
    let light = gather(&scene, &grid.texels(), 20_000);
    for (side, axis) in AXES.into_iter().enumerate() {
        let expected = 2.0 * PI * 0.5 * (1.0 + axis.y);
        let found = light.light(side).x;
        assert!(
            (found - expected).abs() < 0.03 * expected.max(0.5),
            "{axis}: {found} for {expected}"
        );
    }
    let pictures = reflection(&scene, &place, 64);
    for axis in AXES {
        let found = pictures.diffuse.at(axis).x;
        let expected = 1.0 + axis.y;
        // A texel of the picture is up to 5 degrees from the axis.
        assert!((found - expected).abs() < 0.1, "{axis}: {found} for {expected}");
    }
}

#[test]
fn walls_turn_up_on_their_sides() {
    let mut scene = SceneBuilder::default();
    let colour = |axis: Vec3| Rgb::new(1.0 + axis.x, 1.0 + axis.y, 1.0 + axis.z);
    for axis in AXES {
        add_lamp(&mut scene, 2.0 * axis, -axis, Vec2::splat(2.0), colour(axis));
    }
    let scene = scene.build();
    let pictures = reflection(&scene, &Affine3A::from_scale(Vec3::splat(4.0)), 4);
    // The order of graphics cards, which has z turned around: the third dimension of directions is that of a
    // left-handed space.
    let order = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::Z];
    for (side, axis) in order.into_iter().enumerate() {
        let whole = 16 * 16;
        for texel in &pictures.specular[0].texels[side * whole..(side + 1) * whole] {
            assert!(texel.abs_diff_eq(colour(axis), 1e-3), "{axis}: {texel}");
        }
        assert!(pictures.specular[0].at(axis).abs_diff_eq(colour(axis), 1e-3));
    }
    let grid = Grid::new(Affine3A::from_scale(Vec3::splat(0.1)), Some(1.0)).expect("a grid");
    let (size, texels) = grid.texture(&gather(&scene, &grid.texels(), 4000));
    assert_eq!(size, UVec3::new(1, 2, 3));
    for (texel, axis) in texels.iter().zip(AXES) {
        // The light of the opposite wall never comes to this side, and that of the wall in front is most of it.
        let most = *texel - 1.0;
        assert!(
            most.dot(axis) > 0.4 && (most - most.dot(axis) * axis).length() < 0.1,
            "{axis}: {texel}"
        );
    }
    // In a box that is turned, a direction of the picture is one of the box.
    let turned = Affine3A::from_scale_rotation_translation(
        Vec3::new(2.0, 1.0, 3.0),
        Quat::from_rotation_y(PI / 2.0),
        Vec3::ZERO,
    );
    let pictures = reflection(&scene, &turned, 4);
    assert!(pictures.specular[0].at(Vec3::X).abs_diff_eq(colour(Vec3::NEG_Z), 1e-3));
    assert!(pictures.specular[0].at(Vec3::Z).abs_diff_eq(colour(Vec3::X), 1e-3));
}

#[test]
fn lights_without_extent_are_neither_seen_nor_in_a_volume() {
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Point {
        position: Vec3::Y,
        intensity: Rgb::ONE,
    });
    let scene = scene.build();
    let pictures = reflection(&scene, &Affine3A::IDENTITY, 4);
    assert!(pictures.specular[0].texels.iter().all(|texel| *texel == Rgb::ZERO));
    let grid = Grid::new(Affine3A::IDENTITY, Some(1.0)).expect("a grid");
    let light = gather(&scene, &grid.texels(), 16);
    assert!((0..6).all(|side| light.light(side) == Rgb::ZERO));
}

/// A cube of half size 1 in the middle of a room that shines.
fn room_with_a_block() -> RenderScene {
    let mut scene = SceneBuilder::default();
    let cube = || {
        Primitive::Mesh(std::sync::Arc::new(Blas::build(
            std::sync::Arc::new(unit_cube()),
            SplitMethod::Sah,
        )))
    };
    let room = Affine3A::from_scale(Vec3::splat(3.0));
    scene.add(cube(), room, diffuse(0.0), Some(Rgb::ONE)).flip_normals = true;
    scene.add(cube(), Affine3A::IDENTITY, diffuse(0.5), None);
    scene.build()
}

#[test]
fn points_inside_of_things_have_the_light_around_them_and_probes_stand_beside() {
    let scene = room_with_a_block();
    let level = around(&scene.geometry.bounds()).expect("a box");
    let grid = Grid::new(level, Some(6.0 / 9.0)).expect("a grid");
    assert_eq!(grid.points, UVec3::splat(9));
    let light = gather(&scene, &grid.texels(), 64);
    let buried = grid.buried(&light);
    for (place, is_buried) in grid.places().zip(&buried) {
        assert_eq!(*is_buried, place.abs().max_element() < 1.0, "{place}");
    }
    let (_, texels) = grid.texture(&light);
    assert!(texels.iter().all(|texel| texel.x > 0.1), "none is dark");

    let view = settings();
    let gathering = gathering(&scene, &view);
    let never = AtomicBool::new(false);
    assert_eq!(check_sight(&gathering, &level, &never), Err(PlacementError::Buried));
    let placed = seeing(&gathering, &level, &never).expect("a place");
    let middle = Vec3::from(placed.translation);
    assert!(middle.abs().max_element() > 1.0 && middle.length() < 1.5, "{middle}");
    assert_eq!(check_sight(&gathering, &placed, &never), Ok(()));
    assert!(is_enclosed(&scene, &placed));
    let outside = Affine3A::from_translation(Vec3::X * 3.5);
    assert!(!is_enclosed(&scene, &outside), "half of it is sky");
    let corner = placed.transform_point3(Vec3::splat(-0.5));
    let other = placed.transform_point3(Vec3::splat(0.5));
    assert!(
        corner.max_element() <= -3.0 + 1e-4 && other.min_element() >= 3.0 - 1e-4,
        "{corner} {other}"
    );
}

#[test]
fn threads_and_rounds_change_no_bit_of_a_probe() {
    let scene = room_with_a_block();
    let view = settings();
    let gathering = gathering(&scene, &view);
    let texels = outlook(&slanting(Vec3::new(0.0, 2.0, 0.0)), 16);
    let with = |threads: usize, rounds: &[u32]| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| {
            let mut light = Lightmaps::new(texels.texels.len());
            for &samples in rounds {
                assert!(light.add(&gathering, &texels, samples, &AtomicBool::new(false)));
            }
            let pictures = finished(&slanting(Vec3::Y), &light);
            (light, pictures)
        })
    };
    let one = with(1, &[7]);
    assert!(one == with(4, &[7]));
    assert!(one == with(3, &[1, 1, 2, 3]));
}
