//! Tests of the pictures of the side views.

use std::time::{Duration, Instant};

use bevy::math::{Affine3A, Vec2, Vec3};

use super::*;
use crate::app::editor::camera::picking::tests::spheres;
use crate::color::Rgb;
use crate::material::{Material, MaterialId, MaterialTable};
use crate::render::scene::{SurfaceSlot, SurfaceTable};
use crate::shading::{Bsdf, Diffuse};

/// A painted unit sphere at the origin.
fn scene() -> RenderScene {
    let (packed, _) = spheres(&[Vec3::ZERO]);
    let paint = Material::Plain(Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(0.5),
    }));
    let slot = SurfaceSlot {
        material: MaterialId(0),
        light: None,
        media: Default::default(),
    };
    RenderScene {
        surfaces: Arc::new(SurfaceTable {
            first_slot: vec![0],
            slots: vec![slot],
        }),
        materials: Arc::new(MaterialTable::new(vec![paint]).expect("no circles")),
        ..packed.scene.expect("a sphere")
    }
}

/// A view of 40 x 20 pixels along z, with five pixels for a unit.
fn view(x: f32) -> View {
    let pose = Affine3A::from_translation(Vec3::new(x, 0.0, -10.0));
    let camera = Camera::orthographic(pose, Vec2::new(4.0, 2.0), 0.0, 100.0);
    side_view(camera, UVec2::new(40, 20), true, Sight::default())
}

/// Waits for a picture of this many pixels taken by this camera.
fn awaited(pictures: &mut SidePictures, side: usize, camera: Camera, width: usize) -> SidePicture {
    let begin = Instant::now();
    loop {
        pictures.collect();
        if let Some(picture) = pictures.picture(side)
            && picture.camera == camera
            && picture.image.size[0] == width
        {
            return picture.clone();
        }
        assert!(begin.elapsed() < Duration::from_secs(600));
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn grey(picture: &SidePicture, x: usize, y: usize) -> u8 {
    picture.image.pixels[y * picture.image.size[0] + x].r()
}

#[test]
fn views_are_traced_and_follow_their_cameras() {
    let scene = scene();
    let mut pictures = SidePictures::default();
    let (one, other) = (view(0.0), view(2.0));
    pictures.request(&scene, [Some(&one), None, Some(&other)], Some(2), &WakeUp::default());
    // +x is to the left, so that the sphere is right of the middle of the other view.
    let middle = awaited(&mut pictures, 0, one.camera, 40);
    let nothing = grey(&middle, 2, 2);
    assert!(
        grey(&middle, 20, 10) > nothing + 40,
        "{} on {nothing}",
        grey(&middle, 20, 10)
    );
    let aside = awaited(&mut pictures, 2, other.camera, 40);
    assert!(grey(&aside, 20, 10) == nothing && grey(&aside, 30, 10) > nothing + 40);
    assert!(pictures.picture(1).is_none());

    let moved = view(-2.0);
    pictures.request(&scene, [Some(&moved), None, None], None, &WakeUp::default());
    let moved = awaited(&mut pictures, 0, moved.camera, 40);
    assert!(grey(&moved, 10, 10) > nothing + 40 && moved.number > aside.number);
    pictures.clear();
    assert!(pictures.picture(0).is_none());
}

/// A scene with a shape that has no surface, which no renderer gets.
fn broken_scene() -> RenderScene {
    spheres(&[Vec3::ZERO]).0.scene.expect("a sphere")
}

#[test]
fn all_views_follow_a_scene_that_changes_after_each_picture() {
    let desk = Desk::default();
    let mut works = Works::default();
    let views = [view(0.0), view(1.0), view(2.0)];
    let turns = [(); 6].map(|()| {
        assert!(desk.order(&scene(), views.each_ref().map(Some), Some(1)));
        let side = works.next(&desk).expect("there is work");
        let work = works.of_sides[side].as_mut().expect("it was chosen");
        assert!(work.advance(&desk.ends).is_some());
        side
    });
    assert_eq!(turns, [1, 0, 2, 1, 0, 2]);
}

#[test]
fn the_coarse_pass_stops_with_the_thread_and_not_with_its_order() {
    let mut work = Work::new(Arc::new(Order::new(&scene(), &view(0.0))));
    work.order.is_stale.store(true, Ordering::Relaxed);
    assert!(work.advance(&AtomicBool::new(false)).is_some());
    assert!(work.film.is_none());
    let mut work = Work::new(Arc::new(Order::new(&scene(), &view(0.0))));
    assert!(work.advance(&AtomicBool::new(true)).is_none());
}

#[test]
fn a_panic_ends_nothing_but_its_order() {
    let mut work = Work::new(Arc::new(Order::new(&broken_scene(), &view(0.0))));
    assert!(work.advance(&AtomicBool::new(false)).is_none() && work.is_done());
    let mut pictures = SidePictures::default();
    let (broken, whole) = (view(0.0), view(0.5));
    pictures.request(&broken_scene(), [Some(&broken), None, None], None, &WakeUp::default());
    pictures.request(&scene(), [Some(&whole), None, None], None, &WakeUp::default());
    awaited(&mut pictures, 0, whole.camera, 40);
}

#[test]
fn nothing_keeps_the_scene_after_the_end() {
    let scene = scene();
    let geometry = Arc::downgrade(&scene.geometry);
    let mut pictures = SidePictures::default();
    let views = [view(0.0), view(1.0), view(2.0)];
    pictures.request(&scene, views.each_ref().map(Some), None, &WakeUp::default());
    drop(scene);
    pictures.clear();
    let begin = Instant::now();
    while geometry.strong_count() > 0 {
        assert!(begin.elapsed() < Duration::from_secs(600));
        std::thread::sleep(Duration::from_millis(1));
    }
}
