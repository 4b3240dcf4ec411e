//! Where the light of places comes from, by the things of scenes: sums, and what is missing without a lamp.

use std::path::Path;

use bevy::prelude::*;
use sunroom::app::headless::headless;
use sunroom::engine::reasons::{Group, Grouping, Lamp, Things, thing_name};
use sunroom::engine::{Limits, PackedScene, RenderControl, load_to_completion};
use sunroom::render::breakdown::{Area, Batches, Breakdown, Progress, Route, break_down, destinations};
use sunroom::scene::{AreaLight, OpenScene};

const SIZE: UVec2 = UVec2::new(32, 24);

/// The middle of the picture.
const AREA: Area = Area {
    x: 8,
    y: 6,
    width: 16,
    height: 12,
};

/// A scene of the folder `scenes`, in a small picture.
fn opened(name: &str) -> App {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let mut app = headless(OpenScene { path, ..default() }, Some(2));
    app.world_mut().resource_mut::<RenderControl>().film_size_override = Some(SIZE);
    packed(&mut app);
    app
}

/// Packs what has changed.
fn packed(app: &mut App) {
    let loaded = load_to_completion(app, &Limits::default());
    assert!(loaded.expect("a scene that can be loaded"));
    app.update();
}

fn broken_down(app: &App, seed: u32) -> Breakdown {
    let packed = app.world().resource::<PackedScene>();
    let (scene, mut view) = (
        packed.scene.clone().expect("packed"),
        packed.view.clone().expect("packed"),
    );
    view.seed = seed;
    break_down(&scene, &view, AREA, Batches::of(128), &Progress::default()).expect("it is not cancelled")
}

/// Portions sum up to the value of the area, and without a lamp its portion is missing.
fn check(name: &str) {
    let mut app = opened(name);
    let before = broken_down(&app, 1);
    let things = Things::of(app.world().resource());
    let value = before.value();
    assert!(value.luminance > 0.0, "{name}: {value:?}");
    for grouping in Grouping::ALL {
        let portions = things.portions(&before, grouping);
        let light: Vec3 = portions.iter().map(|portion| portion.light).sum();
        let share: f32 = portions.iter().map(|portion| portion.share).sum();
        let noise: f32 = portions.iter().map(|portion| portion.noise).sum();
        let rounding = 1e-5 * value.light.max_element();
        assert!(light.abs_diff_eq(value.light, rounding), "{name}: {light} {value:?}");
        assert!(
            (share - 1.0).abs() < 1e-5 && (noise - 1.0).abs() < 1e-3,
            "{name}: {share} {noise}"
        );
    }
    let lamps = things.portions(&before, Grouping::Lamp);
    let lamp = lamps.iter().find_map(|portion| match portion.key {
        Group::Lamp(Lamp::Thing(entity)) => Some((entity, portion)),
        _ => None,
    });
    let (entity, portion) = lamp.expect("a lamp");
    let text = thing_name(app.world(), entity);
    let world = app.world_mut();
    match world.get::<AreaLight>(entity).is_some() {
        true => drop(world.entity_mut(entity).remove::<AreaLight>()),
        false => drop(world.despawn(entity)),
    }
    packed(&mut app);
    let after = broken_down(&app, 2).value();
    // The lamp is missing in both, so that its noise hides nothing.
    let is_other = |route: &Route| things.group(Grouping::Lamp, route) != portion.key;
    let rest = before.portions(|route| is_other(route).then_some(())).pop();
    let [rest, rest_error] = rest.map_or([0.0; 2], |rest| [rest.luminance, rest.error]);
    let error = rest_error.hypot(after.error);
    let rounding = 1e-5 * value.luminance;
    assert!(
        (rest - after.luminance).abs() < 3.0 * error + rounding,
        "{name}, {text}: {rest} without its portion, {after:?}"
    );
    assert!(
        portion.luminance > 10.0 * error,
        "{name}, {text}: {portion:?} ± {error}"
    );
}

#[test]
fn shares_of_scenes_are_what_is_missing_without_the_lamp() {
    for name in [
        "caustics",
        "lamps",
        "candle",
        "sunbeams",
        "materials",
        "hundred-spheres",
    ] {
        check(&format!("{name}.xml"));
    }
}

#[test]
fn sentences_name_the_things_of_the_file() {
    let app = opened("lamps.xml");
    let things = Things::of(app.world().resource());
    let found = things.portions(&broken_down(&app, 1), Grouping::Route);
    let name = |entity| thing_name(app.world(), entity);
    let texts: Vec<String> = found.iter().map(|portion| portion.key.text(&name)).collect();
    for expected in ["pendant directly", "downlight/left by way of "] {
        assert!(texts.iter().any(|text| text.starts_with(expected)), "{texts:?}");
    }
    // Every name is that of a thing that shines, or of a shape.
    for portion in &found {
        assert!(!portion.key.things().is_empty(), "{portion:?}");
    }
}

#[test]
fn the_light_of_a_lamp_goes_to_the_things_of_the_room() {
    let app = opened("lamps.xml");
    let packed = app.world().resource::<PackedScene>();
    let (scene, view) = (
        packed.scene.clone().expect("packed"),
        packed.view.clone().expect("packed"),
    );
    let things = Things::of(packed);
    let pendant = things.shining().iter().copied();
    let pendant = pendant
        .into_iter()
        .find(|lamp| thing_name(app.world(), *lamp) == "pendant");
    let alone = things.lit_by(&scene, pendant.expect("a pendant")).expect("it shines");
    let found = destinations(&alone, &view, 1 << 13, &Progress::default()).expect("it is not cancelled");
    let shares = found.by(|instance| things.instance(instance));
    let sum: f32 = shares.iter().map(|thing| thing.share).sum();
    let [escaped, _] = found.escaped();
    assert!((sum + escaped - 1.0).abs() < 1e-4, "{sum} {escaped}");
    let top = shares.first().and_then(|first| first.key);
    assert!(top.is_some(), "{shares:?}");
    assert!(things.lit_by(&scene, Entity::PLACEHOLDER).is_none());
}

/// The light of one lamp also meets the other lamps, which do not shine then.
#[test]
fn every_lamp_of_a_room_with_shining_shapes_can_be_followed() {
    let app = opened("desk.xml");
    let packed = app.world().resource::<PackedScene>();
    let scene = packed.scene.clone().expect("packed");
    let view = packed.view.clone().expect("packed");
    let things = Things::of(packed);
    assert!(things.shining().len() >= 3);
    for lamp in things.shining() {
        let alone = things.lit_by(&scene, *lamp).expect("it shines");
        let found = destinations(&alone, &view, 1 << 12, &Progress::default()).expect("it is not cancelled");
        let sum: f32 = found
            .by(|instance| things.instance(instance))
            .iter()
            .map(|thing| thing.share)
            .sum();
        let [escaped, _] = found.escaped();
        assert!((sum + escaped - 1.0).abs() < 1e-4, "{sum} {escaped}");
    }
}
