//! Views that are flown away from their sensors, through borders of media.

use bevy::math::Affine3A;
use bevy::prelude::*;
use sunroom::engine::PackedScene;
use sunroom::scene::{
    DocumentOrder, FreeView, Hidden, InMedium, IntegratorSettings, InteriorMedium, Medium, PathPlugin, Sensor, Shape,
};

use crate::{ball, finish};

const MIDDLE: Vec3 = Vec3::new(0.0, 0.0, 4.0);

/// A sensor at the origin, a ball around [`MIDDLE`] with a medium in it, and the medium.
fn filled_ball() -> (App, Entity) {
    let mut app = ball(MIDDLE, 8, 8);
    let world = app.world_mut();
    world.resource_mut::<IntegratorSettings>().plugin = PathPlugin::VolPath;
    let medium = world.spawn((DocumentOrder(4), Medium::default())).id();
    let shape = only::<Shape>(world);
    world.entity_mut(shape).insert(InteriorMedium(medium));
    (app, medium)
}

fn only<T: Component>(world: &mut World) -> Entity {
    let mut found = world.query_filtered::<Entity, With<T>>();
    found.single(world).expect("one thing")
}

/// Whether the view is in a medium, once it was flown to a place; None is the sensor's own.
fn is_in_medium(app: &mut App, place: Option<Vec3>) -> bool {
    let view = place.map_or_else(FreeView::default, |place| {
        FreeView::at(Affine3A::from_translation(place))
    });
    app.world_mut().insert_resource(view);
    finish(app);
    let packed = app.world().resource::<PackedScene>();
    packed.view.as_ref().expect("a view").medium.is_some()
}

#[test]
fn a_view_enters_and_leaves_media_where_it_flies_through_their_borders() {
    let (mut app, medium) = filled_ball();
    assert!(!is_in_medium(&mut app, None));
    assert!(is_in_medium(&mut app, Some(MIDDLE)));
    assert!(!is_in_medium(&mut app, Some(2.0 * MIDDLE)));
    let sensor = only::<Sensor>(app.world_mut());
    app.world_mut().entity_mut(sensor).insert(InMedium(medium));
    assert!(is_in_medium(&mut app, None));
    assert!(is_in_medium(&mut app, Some(Vec3::X)));
    // The far side of the ball leads out, whatever the sensor is in.
    assert!(!is_in_medium(&mut app, Some(2.0 * MIDDLE)));
}

#[test]
fn the_medium_at_a_place_is_told_from_that_at_another() {
    let (mut app, medium) = filled_ball();
    finish(&mut app);
    let packed = app.world().resource::<PackedScene>();
    let places = [Vec3::ZERO, MIDDLE, 2.0 * MIDDLE];
    for (from, inside) in [(0, None), (1, Some(medium)), (2, None)] {
        for (to, expected) in [(0, None), (1, Some(medium)), (2, None)] {
            assert_eq!(packed.medium_at(places[from], inside, places[to]), expected);
        }
    }
}

#[test]
fn without_media_in_the_picture_a_place_keeps_its_medium() {
    let (mut app, medium) = filled_ball();
    app.world_mut().resource_mut::<IntegratorSettings>().plugin = PathPlugin::Path;
    finish(&mut app);
    let packed = app.world().resource::<PackedScene>();
    assert_eq!(packed.medium_at(MIDDLE, Some(medium), Vec3::ZERO), Some(medium));
}

#[test]
fn a_medium_whose_borders_are_hidden_is_not_there() {
    let (mut app, medium) = filled_ball();
    let world = app.world_mut();
    let (sensor, ball) = (only::<Sensor>(world), only::<Shape>(world));
    world.entity_mut(sensor).insert(InMedium(medium));
    assert!(is_in_medium(&mut app, None));
    app.world_mut().entity_mut(ball).insert(Hidden);
    assert!(!is_in_medium(&mut app, None));
    app.world_mut().entity_mut(ball).remove::<Hidden>();
    assert!(is_in_medium(&mut app, None));
    // A medium without any borders has no shape that could be hidden.
    app.world_mut().entity_mut(ball).remove::<InteriorMedium>();
    assert!(is_in_medium(&mut app, None));
    app.world_mut().entity_mut(ball).insert(Hidden);
    assert!(is_in_medium(&mut app, None));
}
