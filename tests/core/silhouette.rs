//! The edges of marked shapes, as outlines need them.

use std::sync::atomic::AtomicBool;

use glam::{Affine3A, UVec2, Vec2, Vec3};
use sunroom::accel::{Instance, Primitive, SplitMethod, Tlas};
use sunroom::math::Aabb;
use sunroom::render::camera::{Camera, ThinLens};
use sunroom::render::visibility::sight::{CutPlane, Sight};
use sunroom::render::visibility::silhouette::{EdgePoint, MarkedShapes, PixelGrid, edges};

const PICTURE: UVec2 = UVec2::new(200, 100);

/// Forty units wide at the sphere's distance, so that a unit is five pixels.
fn orthographic() -> Camera {
    Camera::orthographic(Affine3A::IDENTITY, Vec2::new(20.0, 10.0), 0.0, 100.0)
}

fn scene(shapes: &[(Primitive, Affine3A)]) -> Tlas {
    let instances = shapes
        .iter()
        .map(|(primitive, pose)| Instance::new(primitive.clone(), *pose).expect("a pose"));
    Tlas::build(instances.collect(), SplitMethod::default())
}

/// A ball with a radius of 4 units, 20 pixels, around the middle of the picture.
fn ball() -> (Primitive, Affine3A) {
    let pose = Affine3A::from_translation(50.0 * Vec3::Z) * Affine3A::from_scale(Vec3::splat(4.0));
    (Primitive::Sphere, pose)
}

/// A wall before the ball: everything with an x of `from` and more.
fn wall(from: f32) -> (Primitive, Affine3A) {
    let pose = Affine3A::from_translation(Vec3::new(from + 30.0, 0.0, 20.0))
        * Affine3A::from_scale(Vec3::new(30.0, 30.0, 1.0));
    (Primitive::Rectangle, pose)
}

fn found(scene: &Tlas, marks: &[(u32, u32)], camera: Camera, step: u32) -> Vec<EdgePoint> {
    let shapes = MarkedShapes::new(scene, marks.iter().copied());
    let grid = PixelGrid::around(&shapes.bounds(), camera, PICTURE).expect("it is seen");
    edges(
        &shapes,
        (scene, &Sight::default()),
        &PixelGrid { step, ..grid },
        &AtomicBool::new(false),
    )
    .expect("nobody cancels")
}

/// The largest distance of a point from the circle of the ball, and the widest gap between neighbours along it in
/// degrees.
fn off_circle(points: &[EdgePoint]) -> (f32, f32) {
    let from_middle = points.iter().map(|point| point.at - 0.5 * PICTURE.as_vec2());
    let off = from_middle
        .clone()
        .map(|at| (at.length() - 20.0).abs())
        .fold(0.0, f32::max);
    let mut angles: Vec<f32> = from_middle.map(|at| at.to_angle().to_degrees()).collect();
    angles.sort_by(f32::total_cmp);
    let gaps = angles.windows(2).map(|pair| pair[1] - pair[0]);
    (off, gaps.fold(360.0 + angles[0] - angles[angles.len() - 1], f32::max))
}

#[test]
fn the_edge_of_a_ball_is_a_circle() {
    let scene = scene(&[ball()]);
    for step in [1, 2, 4, 7] {
        let points = found(&scene, &[(0, 1)], orthographic(), step);
        let (off, gap) = off_circle(&points);
        assert!(off < 0.3 * step as f32, "{off} pixels with cells of {step}");
        assert!(gap < 4.0 * step as f32, "{gap} degrees with cells of {step}");
        assert!(points.iter().all(|point| point.visible && point.mark == 1));
    }
}

#[test]
fn a_lens_does_not_blur_it() {
    let lens = ThinLens {
        aperture_radius: 5.0,
        focus_distance: 10.0,
        blades: 5,
        blade_rotation: 0.0,
    };
    let scene = scene(&[ball()]);
    let camera = |lens| Camera::new(Affine3A::IDENTITY, 40.0, 2.0, 0.1, 100.0, lens);
    assert_eq!(
        found(&scene, &[(0, 1)], camera(Some(lens)), 1),
        found(&scene, &[(0, 1)], camera(None), 1)
    );
}

#[test]
fn what_is_in_front_hides_only_the_part_behind_it() {
    let all = scene(&[ball(), wall(-30.0)]);
    let points = found(&all, &[(0, 1)], orthographic(), 1);
    assert!(off_circle(&points).0 < 0.3, "it is found through the wall");
    assert!(points.iter().all(|point| !point.visible));

    // The wall begins in the middle: +x is to the left.
    let half = scene(&[ball(), wall(0.0)]);
    let points = found(&half, &[(0, 1)], orthographic(), 1);
    let on_side = |point: &EdgePoint| point.visible == (point.at.x > 100.0) || (point.at.x - 100.0).abs() < 1.5;
    assert!(points.iter().all(on_side));
    assert!(points.iter().any(|point| point.visible) && points.iter().any(|point| !point.visible));
}

#[test]
fn shapes_that_touch_have_an_edge_between_them() {
    let square = |x: f32| {
        let pose = Affine3A::from_translation(Vec3::new(x, 0.0, 50.0)) * Affine3A::from_scale(Vec3::splat(4.0));
        (Primitive::Rectangle, pose)
    };
    let scene = scene(&[square(4.0), square(-4.0)]);
    let between = |marks: [(u32, u32); 2]| {
        let points = found(&scene, &marks, orthographic(), 1);
        let inside = |at: Vec2| (at.x - 100.0).abs() < 1.0 && (at.y - 50.0).abs() < 15.0;
        points
            .into_iter()
            .filter(|point| inside(point.at))
            .map(|point| point.mark)
            .collect::<Vec<_>>()
    };
    let marks = between([(0, 5), (1, 3)]);
    assert!(marks.len() > 60 && marks.iter().all(|mark| *mark == 5), "{marks:?}");
    assert!(between([(0, 5), (1, 5)]).is_empty(), "they are one thing");
}

#[test]
fn a_grid_covers_what_can_be_seen() {
    let camera = Camera::new(Affine3A::IDENTITY, 90.0, 2.0, 0.1, 100.0, None);
    let around = |min: Vec3, max: Vec3| PixelGrid::around(&Aabb { min, max }, camera, PICTURE);
    let ahead = around(Vec3::new(-1.0, -1.0, 10.0), Vec3::new(1.0, 1.0, 12.0)).expect("it is ahead");
    assert!(
        ahead.min.x > 80 && ahead.max.x < 120 && ahead.min.y > 30 && ahead.max.y < 70,
        "{ahead:?}"
    );
    let around_us = around(Vec3::NEG_ONE, Vec3::ONE).expect("we are in it");
    assert_eq!((around_us.min, around_us.max), (UVec2::ZERO, PICTURE));
    assert_eq!(around(Vec3::new(-1.0, -1.0, -12.0), Vec3::new(1.0, 1.0, -10.0)), None);
    assert_eq!(around(Vec3::new(50.0, -1.0, 10.0), Vec3::new(51.0, 1.0, 12.0)), None);
    let few = around_us.with_cells(500);
    assert!(few.cells().element_product() <= 600 && few.step > 1, "{few:?}");
}

#[test]
fn a_flag_ends_the_search() {
    let scene = scene(&[ball()]);
    let shapes = MarkedShapes::new(&scene, [(0, 1), (7, 1)]);
    let grid = PixelGrid::around(&shapes.bounds(), orthographic(), PICTURE).expect("it is seen");
    assert_eq!(
        edges(&shapes, (&scene, &Sight::default()), &grid, &AtomicBool::new(true)),
        None
    );
}

#[test]
fn what_the_camera_does_not_see_hides_nothing() {
    let all = scene(&[ball(), wall(-30.0)]);
    let visible = |cut_at: f32| {
        let sight = Sight {
            cut: Some(CutPlane {
                normal: Vec3::NEG_Z,
                offset: -cut_at,
            }),
            ..Sight::default()
        };
        let shapes = MarkedShapes::new(&all, [(0, 1)]);
        let grid = PixelGrid::around(&shapes.bounds(), orthographic(), PICTURE).expect("it is seen");
        let points = edges(&shapes, (&all, &sight), &grid, &AtomicBool::new(false)).expect("nobody cancels");
        points.iter().filter(|point| point.visible).count() as f32 / points.len() as f32
    };
    // The wall is at 20, the ball from 46 to 54.
    assert_eq!([visible(10.0), visible(30.0), visible(60.0)], [0.0, 1.0, 0.0]);
}
