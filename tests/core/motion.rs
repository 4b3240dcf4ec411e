//! The layer of motion: how far surfaces have moved in the picture since the frame before, against formulas.

use std::f32::consts::FRAC_PI_6;
use std::sync::Arc;

use glam::{Affine3A, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::{Instance, Placement, Primitive, SplitMethod, Tlas};
use sunroom::color::Rgb;
use sunroom::layer::{Layer, Layers};
use sunroom::light::LightSource;
use sunroom::render::camera::Camera;
use sunroom::render::layers::LayerPixels;
use sunroom::render::motion::FrameBefore;
use sunroom::render::scene::{RenderScene, SurfaceTable};
use sunroom::render::view::{Strategy, View};
use sunroom::shading::{Bsdf, Diffuse};

use crate::support::{SceneBuilder, render, view};

const SIZE: u32 = 40;
const SAMPLES: u32 = 4;
/// The camera shows two units, so many pixels for each.
const PER_UNIT: f32 = SIZE as f32 / 2.0;

fn scene(shapes: &[(Primitive, Affine3A)]) -> RenderScene {
    let mut scene = SceneBuilder::default();
    for (primitive, placed) in shapes {
        let reflectance = Rgb::splat(0.5);
        scene.add(primitive.clone(), *placed, Bsdf::Diffuse(Diffuse { reflectance }), None);
    }
    scene.light(LightSource::Constant { radiance: Rgb::ONE });
    scene.build()
}

/// A camera at (0, 0, 4) that looks along -z, turned to its left by an angle.
fn pose(left: f32) -> Affine3A {
    let axes = glam::Mat3::from_cols(Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z);
    let looks = Affine3A::from_mat3_translation(axes, Vec3::ZERO);
    Affine3A::from_translation(4.0 * Vec3::Z) * Affine3A::from_rotation_y(left) * looks
}

fn parallel() -> Camera {
    Camera::orthographic(pose(0.0), Vec2::ONE, 0.1, 100.0)
}

fn perspective(left: f32) -> Camera {
    Camera::new(pose(left), 60.0, 1.0, 0.1, 100.0, None)
}

/// Motion and alpha of each pixel.
fn motion(now: &RenderScene, camera: Camera, before: Option<FrameBefore>) -> (Vec<Vec2>, Vec<f32>, View) {
    let look = View {
        layers: Layers::of(&[Layer::Motion, Layer::Alpha]),
        before,
        ..view(camera, SIZE, 2, Strategy::Mis)
    };
    let film = render(now, &look, SAMPLES);
    let Some(LayerPixels::Pairs(motion)) = film.layer(Layer::Motion, &camera) else {
        panic!("motion is kept")
    };
    let Some(LayerPixels::Numbers(alpha)) = film.layer(Layer::Alpha, &camera) else {
        panic!("alpha is kept")
    };
    (motion, alpha, look)
}

fn before(scene: &RenderScene, camera: Camera) -> Option<FrameBefore> {
    Some(FrameBefore {
        geometry: scene.geometry.clone(),
        camera,
    })
}

#[test]
fn a_ball_that_is_shifted_moves_by_its_way() {
    let at = |x: f32, y: f32| {
        let ball = Affine3A::from_scale_rotation_translation(Vec3::splat(0.4), Quat::IDENTITY, Vec3::new(x, y, 0.0));
        scene(&[(Primitive::Sphere, ball)])
    };
    let (then, now) = (at(-0.2, 0.0), at(0.1, 0.15));
    let (found, alpha, _) = motion(&now, parallel(), before(&then, parallel()));
    // To the right and, as rows count, up.
    let way = Vec2::new(0.3, -0.15) * PER_UNIT;
    let mut covered = 0;
    for (motion, alpha) in found.into_iter().zip(alpha) {
        assert!(motion.abs_diff_eq(alpha * way, 1e-3), "{motion} at {alpha}");
        covered += u32::from(alpha == 1.0);
    }
    assert!(covered > 100, "{covered}");
}

#[test]
fn a_square_that_turns_moves_about_its_middle() {
    let turned = |angle: f32| {
        let middle = Vec3::new(0.2, -0.1, 0.5);
        scene(&[(
            Primitive::Rectangle,
            Affine3A::from_rotation_translation(Quat::from_rotation_z(angle), middle)
                * Affine3A::from_scale(Vec3::splat(3.0)),
        )])
    };
    let (then, now) = (turned(0.1), turned(0.1 + FRAC_PI_6));
    let (found, _, look) = motion(&now, parallel(), before(&then, parallel()));
    let middle = Vec2::new(0.2, -0.1);
    for (place, motion) in found.into_iter().enumerate() {
        let pixel = UVec2::new(place as u32 % SIZE, place as u32 / SIZE);
        let places = (0..SAMPLES).map(|index| look.camera_sample(pixel, index).ray.origin.truncate() - middle);
        let mean = places.sum::<Vec2>() / SAMPLES as f32;
        let way = mean - Vec2::from_angle(-FRAC_PI_6).rotate(mean);
        let expected = Vec2::new(way.x, -way.y) * PER_UNIT;
        assert!(motion.abs_diff_eq(expected, 2e-3), "{pixel}: {motion}, not {expected}");
    }
}

#[test]
fn what_a_camera_pans_over_moves_the_other_way_with_the_sky() {
    // The ball stands before a part of the sky; a turn of the camera moves what is near and what is far alike.
    let ball = scene(&[(Primitive::Sphere, Affine3A::from_scale(Vec3::splat(0.8)))]);
    let angle = 0.2f32;
    let (found, alpha, look) = motion(&ball, perspective(angle), before(&ball, perspective(0.0)));
    let half = 30f32.to_radians().tan();
    let film = |direction: Vec2, depth: f32| 0.5 * (1.0 + direction / (depth * half)) * SIZE as f32;
    for (place, motion) in found.into_iter().enumerate() {
        let pixel = UVec2::new(place as u32 % SIZE, place as u32 / SIZE);
        let ways = (0..SAMPLES).map(|index| {
            let ray = look.camera_sample(pixel, index).ray.dir;
            // To the right and down, as an unturned camera sees it, and as one that looks to the left.
            let then = film(Vec2::new(ray.x, -ray.y), -ray.z);
            let back = Quat::from_rotation_y(-angle) * ray;
            film(Vec2::new(back.x, -back.y), -back.z) - then
        });
        let expected = ways.sum::<Vec2>() / SAMPLES as f32;
        assert!(motion.abs_diff_eq(expected, 2e-3), "{pixel}: {motion}, not {expected}");
        assert!(motion.x > 0.0, "things move to the right");
    }
    assert!(alpha.contains(&0.0) && alpha.contains(&1.0));
}

#[test]
fn nothing_moves_in_a_still_picture() {
    let ball = scene(&[(Primitive::Sphere, Affine3A::from_scale(Vec3::splat(0.8)))]);
    for before in [None, before(&ball, perspective(0.1))] {
        let (found, ..) = motion(&ball, perspective(0.1), before);
        assert!(found.into_iter().all(|motion| motion == Vec2::ZERO));
    }
}

#[test]
fn placed_groups_move_with_their_placements_and_their_members() {
    let shift = |x: f32, y: f32| Affine3A::from_translation(Vec3::new(x, y, 0.0));
    let at = |placed: Affine3A, member: Affine3A| {
        let own = scene(&[(Primitive::Sphere, Affine3A::from_scale(Vec3::splat(0.5)))]);
        let far = Instance::new(Primitive::Sphere, shift(90.0, 0.0)).expect("can be undone");
        let member = Instance::new(Primitive::Sphere, member).expect("can be undone");
        let group = Tlas::build(vec![far, member], SplitMethod::Sah);
        let placement = Placement::new(0, &placed).expect("can be undone");
        let geometry = Tlas::with_placements(vec![], vec![Arc::new(group)], vec![placement], SplitMethod::Sah);
        let surfaces = SurfaceTable {
            first_slot: vec![0, 0],
            ..(*own.surfaces).clone()
        };
        RenderScene {
            media: Arc::default(),
            geometry: Arc::new(geometry),
            surfaces: Arc::new(surfaces),
            ..own
        }
    };
    let half = Affine3A::from_scale(Vec3::splat(0.5));
    let then = at(shift(0.1, 0.0) * half, shift(0.0, 0.2));
    let now = at(shift(0.2, 0.0) * half, shift(0.0, 0.0));
    let (found, alpha, _) = motion(&now, parallel(), before(&then, parallel()));
    let way = Vec2::new(0.1, 0.1) * PER_UNIT;
    assert!(alpha.contains(&1.0));
    for (motion, alpha) in found.into_iter().zip(alpha) {
        assert!(motion.abs_diff_eq(alpha * way, 1e-3), "{motion} at {alpha}");
    }
    // What was not there stands still.
    let (found, ..) = motion(&now, parallel(), before(&scene(&[]), parallel()));
    assert!(found.into_iter().all(|motion| motion == Vec2::ZERO));
}
