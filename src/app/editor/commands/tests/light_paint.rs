//! The light you want: from strokes to lamps, and back by undo.

use bevy::math::Affine3A;

use super::full_film::{app, update_until};
use super::*;
use crate::app::editor::command::light_mix::note_film_lights;
use crate::app::editor::command::light_paint::{Brush, LampChoice, LightPainting};
use crate::app::editor::command::{LightPaintCommand, SettingsEdit};
use crate::app::editor::commands::light_paint::{follow, search_under_way};
use crate::app::editor::picture::light_search::{LampPlacing, StrokeLux};
use crate::engine::EngineSystems;
use crate::engine::lamp_freedom::LampFreedom;
use crate::inverse_lighting::Wish;
use crate::scene::{EmitterKind, SunPosition};

/// The distance of the wall that the camera looks at, and of the lamp before it.
const WALL: f32 = 4.0;
const LAMP: f32 = 2.0;

/// A wall before the camera, with a lamp of 1 W/sr on its axis.
fn wall(material: Material) -> (App, Entity) {
    let mut app = app();
    app.init_resource::<LightPainting>()
        .init_resource::<LampPlacing>()
        .init_resource::<StrokeLux>()
        .add_systems(PostUpdate, follow.before(EngineSystems::Detect))
        .add_systems(PostUpdate, note_film_lights.after(EngineSystems::Dispatch));
    let world = app.world_mut();
    let sky = world
        .query_filtered::<Entity, With<Emitter>>()
        .single(world)
        .expect("a sky");
    world.despawn(sky);
    let material = world.spawn((DocumentOrder(2), material)).id();
    let turned = Affine3A::from_rotation_y(std::f32::consts::PI);
    let place = Affine3A::from_translation(Vec3::Z * WALL) * turned * Affine3A::from_scale(Vec3::splat(20.0));
    let shape = Shape {
        kind: ShapeKind::Rectangle,
        ..Shape::default()
    };
    world.spawn((DocumentOrder(3), shape, ToWorld(place), UsesMaterial(material)));
    let lamp = world
        .spawn((
            DocumentOrder(4),
            Name::new("bulb"),
            Emitter::from(EmitterKind::Point { intensity: Rgb::ONE }),
            ToWorld(Affine3A::from_translation(Vec3::Z * LAMP)),
        ))
        .id();
    world.resource_mut::<RenderControl>().target_samples = Some(64);
    (app, lamp)
}

fn stroke(wish: Wish) -> LightPaintCommand {
    let brush = Brush {
        wish,
        radius: 0.03,
        ..Brush::default()
    };
    LightPaintCommand::SetStrokes(vec![brush.stroke(vec![Vec2::splat(0.5)])])
}

fn painting(world: &World) -> &LightPainting {
    world.resource::<LightPainting>()
}

/// The strength in the mix once the picture has all its samples.
fn solved(app: &mut App, lamp: Entity) -> f32 {
    update_until(app, |world| {
        world.resource::<RenderFilm>().samples == 64
            && painting(world).answer.is_some()
            && search_under_way(world).is_none()
    });
    apply(app.world_mut(), LightPaintCommand::Solve).expect("an answer");
    app.world().resource::<LightMix>().channel(lamp).strength
}

fn intensity(world: &World, lamp: Entity) -> f32 {
    match world.get::<Emitter>(lamp).map(|emitter| &emitter.kind) {
        Some(EmitterKind::Point { intensity }) => intensity.x,
        other => panic!("a bulb: {other:?}"),
    }
}

fn assert_near(found: f32, expected: f32, error: f32) {
    assert!((found / expected - 1.0).abs() < error, "{found}, not {expected}");
}

#[test]
fn what_was_painted_is_baked_and_undone() {
    let (mut app, lamp) = wall(Material::default());
    apply(app.world_mut(), stroke(Wish::Brighter(3.0))).expect("painted");
    assert_near(solved(&mut app, lamp), 3.0, 1e-3);
    let notes = &painting(app.world()).answer.as_ref().expect("an answer").notes;
    assert_eq!(notes[..], ["All is met within 5 %."]);
    assert_eq!(intensity(app.world(), lamp), 1.0, "nothing changes in the scene");
    // What is painted next is relative to the light of before the first stroke.
    apply(app.world_mut(), stroke(Wish::Brighter(4.0))).expect("painted");
    assert_near(solved(&mut app, lamp), 4.0, 1e-3);
    apply(app.world_mut(), LightPaintCommand::SetStrokes(Vec::new())).expect("cleared");
    assert!(app.world().resource::<LightMix>().is_neutral());
    apply(app.world_mut(), stroke(Wish::Darker(2.0))).expect("painted");
    assert_near(solved(&mut app, lamp), 0.5, 1e-3);
    let world = app.world_mut();
    say(world, SettingsEdit::BakeLights);
    assert_near(intensity(world, lamp), 0.5, 1e-3);
    assert!(painting(world).is_empty());
    say(world, HistoryCommand::Undo);
    assert_eq!(intensity(world, lamp), 1.0);
}

#[test]
fn a_lamp_that_limits_is_told() {
    let (mut app, lamp) = wall(Material::default());
    let choice = LampChoice {
        most: 2.0,
        ..LampChoice::default()
    };
    apply(app.world_mut(), LightPaintCommand::SetLamp(lamp, choice)).expect("chosen");
    apply(app.world_mut(), stroke(Wish::Brighter(3.0))).expect("painted");
    assert_eq!(solved(&mut app, lamp), 2.0);
    let notes = &painting(app.world()).answer.as_ref().expect("an answer").notes;
    let expected = [
        "Stroke 1 (brighter 3) is missed by 33 %.",
        "bulb is at its upper limit, 2.",
    ];
    assert_eq!(notes[..], expected);
}

/// A mirror shows nothing of a point light, but gets as many lux as any other wall.
#[test]
fn lux_are_those_on_the_surface_whatever_its_material() {
    for material in [Material::default(), Material::of_plugin("conductor").expect("a plugin")] {
        let (mut app, lamp) = wall(material);
        let present = 683.0 / (WALL - LAMP).powi(2);
        apply(app.world_mut(), stroke(Wish::Illuminance(2.5 * present))).expect("painted");
        assert_near(solved(&mut app, lamp), 2.5, 0.01);
    }
}

#[test]
fn lux_of_nothing_are_refused() {
    let (mut app, _) = wall(Material::default());
    let world = app.world_mut();
    let wall = world
        .query_filtered::<Entity, With<Shape>>()
        .single(world)
        .expect("a wall");
    world.despawn(wall);
    apply(world, stroke(Wish::Illuminance(100.0))).expect("painted");
    update_until(&mut app, |world| {
        world.resource::<RenderFilm>().samples == 64
            && painting(world).answer.is_some()
            && search_under_way(world).is_none()
    });
    let refused = apply(app.world_mut(), LightPaintCommand::Solve).expect_err("there is no surface");
    assert_eq!(refused.to_string(), "There is no surface where lux are wanted.");
}

/// The illuminance in the middle of the wall from the lamp.
fn lux(world: &World, lamp: Entity) -> f32 {
    let place = world.get::<ToWorld>(lamp).expect("a place").0.translation;
    let to_lamp = Vec3::from(place) - Vec3::Z * WALL;
    683.0 * intensity(world, lamp) * -to_lamp.z / to_lamp.length().powi(3)
}

#[test]
fn a_lamp_is_placed_when_that_is_accepted() {
    let (mut app, lamp) = wall(Material::default());
    let before = app.world().get::<ToWorld>(lamp).copied();
    let choice = LampChoice {
        chosen: false,
        freedom: LampFreedom {
            radius: 1.0,
            ..LampFreedom::default()
        },
        ..LampChoice::default()
    };
    apply(app.world_mut(), LightPaintCommand::SetLamp(lamp, choice)).expect("chosen");
    let wanted = 683.0 / 1.4_f32.powi(2);
    apply(app.world_mut(), stroke(Wish::Illuminance(wanted))).expect("painted");
    solved(&mut app, lamp);
    let refused = apply(app.world_mut(), SettingsEdit::AcceptLamps).expect_err("nothing was found");
    assert_eq!(refused.to_string(), "No places of lamps were found yet.");
    apply(app.world_mut(), LightPaintCommand::Place).expect("begun");
    assert!(search_under_way(app.world()).is_some());
    apply(app.world_mut(), LightPaintCommand::Discard).expect("ended");
    assert!(search_under_way(app.world()).is_none());
    apply(app.world_mut(), LightPaintCommand::Place).expect("begun");
    update_until(&mut app, |world| painting(world).proposal.is_some());
    let world = app.world_mut();
    assert_eq!(world.get::<ToWorld>(lamp).copied(), before, "nothing changes before");
    let notes = painting(world).proposal.as_ref().expect("one").notes.join(" ");
    assert!(notes.contains("bulb moves by "), "{notes}");
    say(world, SettingsEdit::AcceptLamps);
    assert_near(lux(world, lamp), wanted, 0.03);
    assert!(painting(world).proposal.is_none() && painting(world).is_empty());
    say(world, HistoryCommand::Undo);
    assert_eq!(world.get::<ToWorld>(lamp).copied(), before);
}

#[test]
fn what_was_found_belongs_to_its_strokes() {
    let (mut app, lamp) = wall(Material::default());
    apply(app.world_mut(), stroke(Wish::Brighter(2.0))).expect("painted");
    solved(&mut app, lamp);
    let refused = apply(app.world_mut(), LightPaintCommand::Place).expect_err("no lamp may move");
    assert_eq!(
        refused.to_string(),
        "No lamp may move, turn or stand at another hour: choose some."
    );
    let choice = LampChoice {
        freedom: LampFreedom {
            hours: Some([0.0, 24.0]),
            ..LampFreedom::default()
        },
        ..LampChoice::default()
    };
    apply(app.world_mut(), LightPaintCommand::SetLamp(lamp, choice)).expect("chosen");
    solved(&mut app, lamp);
    let refused = apply(app.world_mut(), LightPaintCommand::Place).expect_err("it is no sun");
    assert_eq!(refused.to_string(), "bulb is no sun, and has no hour and no day.");
    for freedom in [
        LampFreedom {
            radius: -1.0,
            ..LampFreedom::default()
        },
        LampFreedom {
            hours: Some([9.0, 8.0]),
            ..LampFreedom::default()
        },
    ] {
        let choice = LampChoice { freedom, ..choice };
        apply(app.world_mut(), LightPaintCommand::SetLamp(lamp, choice)).expect_err("out of range");
    }
    let choice = LampChoice {
        freedom: LampFreedom {
            radius: 1.0,
            ..LampFreedom::default()
        },
        ..choice
    };
    apply(app.world_mut(), LightPaintCommand::SetLamp(lamp, choice)).expect("chosen");
    solved(&mut app, lamp);
    apply(app.world_mut(), LightPaintCommand::Place).expect("begun");
    update_until(&mut app, |world| painting(world).proposal.is_some());
    apply(app.world_mut(), stroke(Wish::Darker(2.0))).expect("painted");
    app.update();
    assert!(painting(app.world()).proposal.is_none());
}

#[test]
fn the_hour_of_the_sun_is_one_step_of_the_history() {
    let (mut app, lamp) = wall(Material::default());
    let sun = Emitter::of_plugin("sunsky").expect("a plugin");
    // The zenith is opposite to the wall.
    let turned = ToWorld(Affine3A::from_rotation_x(std::f32::consts::PI));
    app.world_mut().entity_mut(lamp).insert((sun.clone(), turned));
    let choice = LampChoice {
        most: 100.0,
        freedom: LampFreedom {
            hours: Some([8.0, 12.0]),
            ..LampFreedom::default()
        },
        ..LampChoice::default()
    };
    apply(app.world_mut(), LightPaintCommand::SetLamp(lamp, choice)).expect("chosen");
    apply(app.world_mut(), stroke(Wish::Color(Rgb::new(1.0, 0.9, 0.8)))).expect("painted");
    solved(&mut app, lamp);
    apply(app.world_mut(), LightPaintCommand::Place).expect("begun");
    update_until(&mut app, |world| painting(world).proposal.is_some());
    let world = app.world_mut();
    assert_eq!(world.get::<Emitter>(lamp), Some(&sun), "nothing changes before");
    say(world, SettingsEdit::AcceptLamps);
    let Some(EmitterKind::SunSky(sky)) = world.get::<Emitter>(lamp).map(|emitter| emitter.kind.clone()) else {
        panic!("a sun");
    };
    let SunPosition::PlaceAndTime(at) = sky.sun else {
        panic!("a time");
    };
    assert!((8.0..=12.0).contains(&(at.hour + at.minute / 60.0)), "{at:?}");
    say(world, HistoryCommand::Undo);
    assert_eq!(world.get::<Emitter>(lamp), Some(&sun));
}
