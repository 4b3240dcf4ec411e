//! Tests of edits of properties.

use super::*;
use crate::app::editor::command::properties::{PropertyChange, PropertyEdit, PropertyOwner};
use crate::scene::{Properties, PropertyType, PropertyValue, SceneProperties};

fn value(kind: &str, text: &str) -> PropertyValue {
    let kind = PropertyType::of_name(kind).expect(kind);
    kind.parse(text).expect(text)
}

fn set(things: &[Entity], name: &str, value: PropertyValue) -> PropertyEdit {
    PropertyEdit {
        owner: PropertyOwner::Things(things.to_vec()),
        name: name.into(),
        change: PropertyChange::Set(value),
    }
}

fn cube(world: &mut World, name: &str) -> Entity {
    let addition = Addition {
        name: Some(name.into()),
        ..AdditionKind::Cube.into()
    };
    say(world, SceneEdit::Add(addition));
    world.resource::<Selection>().active().expect("the cube")
}

fn text(world: &World, thing: Entity, name: &str) -> Option<String> {
    Some(world.get::<Properties>(thing)?.get(name)?.text())
}

#[test]
fn properties_of_several_things_are_set_renamed_and_undone() {
    let mut world = bare_world();
    let [one, two] = ["one", "two"].map(|name| cube(&mut world, name));
    say(&mut world, set(&[one], "armour", value("number", "2")));
    say(&mut world, set(&[one, two], "health", value("integer", "10")));
    let health = |world: &World| [one, two].map(|it| text(world, it, "health"));
    assert_eq!(health(&world), [Some("10".into()), Some("10".into())]);
    let change = |change| PropertyEdit {
        change,
        ..set(&[one, two], "health", value("integer", "0"))
    };
    say(&mut world, change(PropertyChange::Rename("life".into())));
    assert_eq!(text(&world, two, "life"), Some("10".into()));
    // Another one has the name already: nothing changes.
    let taken = PropertyEdit {
        name: "life".into(),
        ..change(PropertyChange::Rename("armour".into()))
    };
    assert!(apply(&mut world, Command::from(EditCommand::from(taken))).is_err());
    assert_eq!(text(&world, two, "life"), Some("10".into()));
    say(&mut world, HistoryCommand::Undo);
    say(&mut world, change(PropertyChange::Remove));
    assert_eq!(health(&world), [None, None]);
    assert!(world.get::<Properties>(two).is_none() && world.get::<Properties>(one).is_some());
    say(&mut world, HistoryCommand::Undo);
    assert_eq!(text(&world, one, "health"), Some("10".into()));
}

#[test]
fn references_follow_the_names_of_things() {
    let mut world = bare_world();
    let [door, key] = ["door", "key"].map(|name| cube(&mut world, name));
    say(&mut world, set(&[key], "opens", value("reference list", "door; gate")));
    say(
        &mut world,
        PropertyEdit {
            owner: PropertyOwner::Scene,
            ..set(&[], "exit", value("reference", "door"))
        },
    );
    say(&mut world, OutlineEdit::Rename(door, "portal".into()));
    assert_eq!(text(&world, key, "opens"), Some("portal; gate".into()));
    let exit = |world: &World| {
        world
            .resource::<SceneProperties>()
            .0
            .get("exit")
            .map(PropertyValue::text)
    };
    assert_eq!(exit(&world), Some("portal".into()));
    say(&mut world, HistoryCommand::Undo);
    assert_eq!(text(&world, key, "opens"), Some("door; gate".into()));
    assert_eq!(exit(&world), Some("door".into()));
    // Copies that refer to each other go on doing so.
    say(&mut world, SelectionCommand::Select(vec![door, key], Extend::Replace));
    say(&mut world, SceneEdit::Duplicate);
    let copies = world.resource::<Selection>().entities().to_vec();
    let name = |world: &World, it: Entity| world.get::<SceneId>(it).expect("a name").0.clone();
    let copied = copies.iter().find(|it| world.get::<Properties>(**it).is_some());
    let other = copies.iter().find(|it| world.get::<Properties>(**it).is_none());
    let (copied, other) = (*copied.expect("the key"), *other.expect("the door"));
    assert_eq!(
        text(&world, copied, "opens"),
        Some(format!("{}; gate", name(&world, other)))
    );
    assert_eq!(text(&world, key, "opens"), Some("door; gate".into()));
}
