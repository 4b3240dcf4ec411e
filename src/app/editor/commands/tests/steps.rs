//! The step of lengths: it depends on the scene alone.

use super::full_film::{app, update_until};
use super::*;
use crate::app::editor::camera::picking;
use crate::app::editor::commands::scene_watch::measure_scene;
use crate::app::editor::session::history::Edit;
use crate::engine::{EngineSystems, PackedScene};
use crate::scene::FreeView;

fn step(app: &App) -> f32 {
    app.world().resource::<ViewSettings>().length_step()
}

/// Waits until the spawned shapes are in the picture.
fn wait_for(app: &mut App, shapes: &[Entity]) {
    update_until(app, |world| {
        let packed = &world.resource::<PackedScene>().entity_of_instance;
        packed.len() == shapes.len() && shapes.iter().all(|shape| packed.contains(shape))
    });
    app.update();
}

fn cube(app: &mut App, size: f32, at: Vec3) -> Entity {
    let pose = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5 * size), Quat::IDENTITY, at);
    let shape = Shape {
        kind: ShapeKind::Cube,
        ..Shape::default()
    };
    app.world_mut().spawn((DocumentOrder(9), shape, ToWorld(pose))).id()
}

/// An empty scene that is measured, with a camera that looks at the origin.
fn measured() -> App {
    let mut app = app();
    app.add_systems(PostUpdate, measure_scene.after(EngineSystems::Detect));
    let camera = app.world().resource::<ActiveSensor>().0.expect("a camera");
    let place = ToWorld(Affine3A::from_translation(6.0 * Vec3::NEG_Z));
    app.world_mut().entity_mut(camera).insert(place);
    app
}

#[test]
fn the_step_depends_on_nothing_but_the_scene() {
    let mut app = measured();
    app.update();
    app.update();
    assert_eq!(step(&app), 0.1, "the scene is empty");
    let first = cube(&mut app, 1.0, Vec3::ZERO);
    wait_for(&mut app, &[first]);
    assert_eq!(step(&app), 0.1, "a cube");
    // Neither flying nor the former scene counts.
    app.world_mut().resource_mut::<FreeView>().pose = Some(Affine3A::from_translation(Vec3::NEG_Z));
    let floor = cube(&mut app, 1000.0, Vec3::Y * -501.0);
    wait_for(&mut app, &[first, floor]);
    assert_eq!(step(&app), 0.2, "what the camera is directed at is near");
    app.world_mut().entity_mut(floor).despawn();
    wait_for(&mut app, &[first]);
    assert_eq!(step(&app), 0.1);
    // A small thing that is seen through a long lens.
    app.world_mut().entity_mut(first).despawn();
    let small = cube(&mut app, 0.01, Vec3::ZERO);
    wait_for(&mut app, &[small]);
    assert_eq!(step(&app), 0.001);
}

#[test]
fn moving_a_thing_leaves_the_step_and_building_changes_it() {
    let mut app = measured();
    let (near, far) = (cube(&mut app, 1.0, Vec3::ZERO), cube(&mut app, 1.0, 3.0 * Vec3::Z));
    wait_for(&mut app, &[near, far]);
    let before = app.world().resource::<ViewSettings>().navigation.scene_size;
    let move_to = |app: &mut App, thing: Entity, at: Vec3| {
        let mut edit = Edit::begin(app.world_mut());
        let pose = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), Quat::IDENTITY, at);
        edit.set(thing, ToWorld(pose));
        edit.finish("move".to_owned(), None);
        update_until(app, |world| {
            let bounds = picking::scene_bounds(world.resource::<PackedScene>());
            bounds.is_some_and(|bounds| bounds.max.x > at.x)
        });
        app.update();
    };
    move_to(&mut app, near, Vec3::X);
    assert_eq!(app.world().resource::<ViewSettings>().navigation.scene_size, before);
    move_to(&mut app, far, 300.0 * Vec3::X);
    assert!(app.world().resource::<ViewSettings>().navigation.scene_size > 2.0 * before);
}
