//! The choice of the integrator `auto`.

use std::sync::atomic::AtomicBool;

use crate::bidirectional::{diffuse, glass, lit_room, look, placed};
use crate::guide::cove;
use crate::support::{SceneBuilder, camera};
use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::light::LightSource;
use sunroom::render::auto::{Choice, Method, choose, has_choice};
use sunroom::render::guide::Guide;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Shown, View};
use sunroom::sampling::SequenceKind;

/// The samples of a picture that can pay for the whole pilot.
const MANY: u64 = 1 << 25;

fn chosen(scene: &RenderScene, view: &View, threads: usize) -> Choice {
    choose(scene, view, &Guide::default(), MANY, threads, &AtomicBool::new(false)).expect("nothing cancels it")
}

fn floor(scene: &mut SceneBuilder) {
    let turn = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let floor = placed(Vec3::splat(4.0), turn, Vec3::new(0.0, -1.0, 0.0));
    scene.add(Primitive::Rectangle, floor, diffuse(0.6), None);
}

/// A glowing bead in a ball of glass.
fn bulb() -> RenderScene {
    let mut scene = SceneBuilder::default();
    floor(&mut scene);
    scene.add(Primitive::Sphere, Affine3A::from_scale(Vec3::splat(0.3)), glass(), None);
    let bead = Affine3A::from_scale(Vec3::splat(0.02));
    scene.add(Primitive::Sphere, bead, diffuse(0.0), Some(Rgb::splat(1000.0)));
    scene.build()
}

/// A ball of glass under a point.
fn caustic() -> RenderScene {
    let mut scene = SceneBuilder::default();
    floor(&mut scene);
    scene.add(Primitive::Sphere, Affine3A::from_scale(Vec3::splat(0.4)), glass(), None);
    scene.light(LightSource::Point {
        position: Vec3::new(0.0, 3.0, 0.0),
        intensity: Rgb::splat(10.0),
    });
    scene.build()
}

/// A look at the floor.
fn down() -> View {
    let mut view = look(8);
    view.camera = camera(Vec3::new(0.0, 0.6, 3.0), Vec3::new(0.0, -1.0, 0.0), 40.0);
    view
}

#[test]
fn paths_from_the_lights_are_chosen_where_paths_find_little() {
    let room = chosen(&lit_room(), &look(8), 2);
    assert!(room.method == Method::Path && room.gain.is_some(), "{room:?}");
    assert_eq!(room.missed, 0.0);
    let bulb = chosen(&bulb(), &down(), 2);
    assert!(
        bulb.method == Method::Bidirectional && bulb.gain > Some(4.0) && bulb.missed == 0.0,
        "{bulb:?}"
    );
    // Path tracing finds the light around the caustic alone.
    let caustic = chosen(&caustic(), &down(), 2);
    assert!(
        caustic.method == Method::Bidirectional && (0.01..0.5).contains(&caustic.missed),
        "{caustic:?}"
    );
}

#[test]
fn paths_are_guided_where_lamps_are_behind_corners() {
    let (scene, view) = (cove(), look(8));
    let guide = Guide::default();
    let choose = |samples, threads| {
        let choice = choose(&scene, &view, &guide, samples, threads, &AtomicBool::new(false));
        choice.expect("nothing cancels it")
    };
    // Too few samples to learn a guide for.
    let few = choose(1 << 23, 1);
    assert!(
        few.method != Method::GuidedPath && few.gain_of_guide.is_none(),
        "{few:?}"
    );
    assert_eq!(guide.learnings(), 0);
    let many = choose(MANY, 1);
    assert!(
        many.method == Method::GuidedPath && many.gain_of_guide > Some(1.25),
        "{many:?}"
    );
    // Its rays are the pilot's, and no picture counts them.
    assert!(guide.rays_of_pilot() > 65_536 && guide.take_rays() == 0);
    // What was learnt for the pilot is there for the picture, on any number of threads.
    assert_eq!((choose(MANY, 3), guide.learnings()), (many, 1));
    assert_eq!(chosen(&scene, &view, 3), many);
    // Nothing is learnt where paths are calm.
    let calm = Guide::default();
    let choice = sunroom::render::auto::choose(&lit_room(), &view, &calm, MANY, 2, &AtomicBool::new(false));
    assert!(choice.is_some_and(|choice| choice.method == Method::Path && choice.gain_of_guide.is_none()));
    assert_eq!(calm.learnings(), 0);
}

#[test]
fn the_choice_does_not_depend_on_threads_seeds_and_pixels() {
    for scene in [lit_room(), caustic(), cove()] {
        let view = down();
        let choice = chosen(&scene, &view, 1);
        assert_eq!(chosen(&scene, &view, 4), choice);
        let other = View {
            width: 5 * view.width,
            height: 5 * view.height,
            seed: 77,
            sequence: match view.sequence {
                SequenceKind::Sobol => SequenceKind::Independent,
                SequenceKind::Independent => SequenceKind::Sobol,
            },
            ..view
        };
        assert_eq!(chosen(&scene, &other, 3), choice);
    }
}

#[test]
fn there_is_no_pilot_where_it_cannot_pay() {
    let (scene, view) = (caustic(), down());
    assert!(has_choice(&scene, &view, MANY));
    assert!(!has_choice(&scene, &view, 1 << 16));
    let choose = |view: &View, samples| choose(&scene, view, &Guide::default(), samples, 1, &AtomicBool::new(false));
    assert_eq!(choose(&view, 1 << 16), Some(Choice::UNTRIED));
    let mut short = view.clone();
    short.integrator.settings_mut().max_depth = 2;
    let clay = View {
        shown: Shown::Clay,
        ..view.clone()
    };
    for view in [short, clay] {
        assert_eq!(choose(&view, MANY), Some(Choice::UNTRIED));
    }
    let cancelled = sunroom::render::auto::choose(&scene, &view, &Guide::default(), MANY, 2, &AtomicBool::new(true));
    assert_eq!(cancelled, None);
}

#[test]
fn a_scene_without_light_is_left_to_paths() {
    let mut scene = SceneBuilder::default();
    floor(&mut scene);
    assert_eq!(chosen(&scene.build(), &down(), 1).method, Method::Path);
}
