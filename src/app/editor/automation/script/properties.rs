//! The verbs of properties.

use super::error::ScriptError;
use super::names::{named, unknown};
use super::verb::verbs;
use crate::app::editor::command::properties::{PropertyChange, PropertyEdit, PropertyOwner};
use crate::scene::{ItemType, PropertyType, PropertyValue};

verbs! {
    VERBS(world):
    "property" "THING NAME TYPE [VALUE] | THING NAME none"
        [thing, name, "none"] => of_thing(named(world, thing)?, name, PropertyChange::Remove),
        [thing, name, words @ ..] if !words.is_empty() => {
            let value = value(words)?;
            of_thing(named(world, thing)?, name, PropertyChange::Set(value))
        };
    "scene-property" "NAME TYPE [VALUE] | NAME none"
        [name, "none"] => of_scene(name, PropertyChange::Remove),
        [name, words @ ..] if !words.is_empty() => of_scene(name, PropertyChange::Set(value(words)?));
    "rename-property" "THING NAME NAME"
        [thing, name, new] => of_thing(named(world, thing)?, name, PropertyChange::Rename((*new).to_owned()));
}

fn of_thing(thing: bevy::prelude::Entity, name: &str, change: PropertyChange) -> PropertyEdit {
    PropertyEdit {
        owner: PropertyOwner::Things(vec![thing]),
        name: name.to_owned(),
        change,
    }
}

fn of_scene(name: &str, change: PropertyChange) -> PropertyEdit {
    PropertyEdit {
        owner: PropertyOwner::Scene,
        name: name.to_owned(),
        change,
    }
}

/// A value after its type: `integer 3`, `text list a; b`. A type alone gives the value of a new property.
fn value(words: &[&str]) -> Result<PropertyValue, ScriptError> {
    let (kind, rest) = match words {
        [item, "list", rest @ ..] => (format!("{item} list"), rest),
        [item, rest @ ..] => ((*item).to_owned(), rest),
        [] => return Err("expected a type".into()),
    };
    let known = PropertyType::of_name(&kind);
    let known = known.ok_or_else(|| unknown("type of properties", &kind, ItemType::ALL.map(ItemType::name)))?;
    match rest {
        [] => Ok(known.new_value()),
        rest => Ok(known.parse(&rest.join(" "))?),
    }
}
