//! Edits of properties, and the references of properties to things that get other names.

use bevy::prelude::*;

use super::world::set_resource;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::properties::{PropertyChange, PropertyEdit, PropertyOwner};
use crate::app::editor::session::history::Edit;
use crate::document::value::quote;
use crate::scene::{
    Locked, ObjectState, Placements, Properties, PropertyItem, PropertyValue, SceneId, SceneProperties,
};

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: PropertyEdit) -> Result<(), CommandError> {
    let PropertyEdit { owner, name, change } = command;
    if let PropertyChange::Set(value) = &change {
        check(value)?;
    }
    match owner {
        PropertyOwner::Scene => {
            let SceneProperties(before) = edit.world.get_resource().cloned().unwrap_or_default();
            set_resource(edit.world, SceneProperties(changed(&before, &name, &change)?));
        }
        PropertyOwner::Things(things) => {
            let is_free = |thing: &Entity| edit.world.get::<Locked>(*thing).is_none();
            let things: Vec<Entity> = things.into_iter().filter(is_free).collect();
            if things.is_empty() {
                return Err("What is selected is locked.".into());
            }
            for thing in things {
                if !ObjectState::is_in_scene(edit.world, thing) || edit.world.get::<Placements>(thing).is_some() {
                    return Err("This thing cannot have properties.".into());
                }
                let before = edit.world.get::<Properties>(thing).cloned().unwrap_or_default();
                // Of several things those without the property keep their others.
                if before.get(&name).is_none() && !matches!(change, PropertyChange::Set(_)) {
                    continue;
                }
                match changed(&before, &name, &change)?.some() {
                    Some(properties) => edit.set(thing, properties),
                    None => edit.remove::<Properties>(thing),
                }
            }
        }
    }
    Ok(())
}

/// The properties after the change.
fn changed(before: &Properties, name: &str, change: &PropertyChange) -> Result<Properties, CommandError> {
    match change {
        PropertyChange::Set(value) => {
            let name = Properties::checked_name(name).map_err(CommandError::from)?;
            Ok(before.with(name, Some(value.clone())))
        }
        PropertyChange::Remove => Ok(before.with(name, None)),
        PropertyChange::Rename(new) => {
            let new = Properties::checked_name(new).map_err(CommandError::from)?;
            let value = before.get(name);
            let value = value
                .ok_or_else(|| format!("There is no property {}.", quote(name)))?
                .clone();
            if new != name && before.get(new).is_some() {
                return Err(format!("There is a property {} already.", quote(new)).into());
            }
            Ok(before.with(name, None).with(new, Some(value)))
        }
    }
}

/// An error if a file cannot hold the value.
fn check(value: &PropertyValue) -> Result<(), CommandError> {
    let is_fine = |item: &PropertyItem| match item {
        PropertyItem::Number(number) => number.is_finite(),
        PropertyItem::Vector(numbers) | PropertyItem::Color(numbers) => numbers.is_finite(),
        PropertyItem::Boolean(_) | PropertyItem::Integer(_) => true,
        PropertyItem::Text(text)
        | PropertyItem::File(text)
        | PropertyItem::Reference(text)
        | PropertyItem::Component(text) => {
            let is_odd = |c: char| c.is_control() && !matches!(c, '\n' | '\t') || matches!(c, '\u{fffe}' | '\u{ffff}');
            text.len() <= LONGEST_TEXT && !text.contains(is_odd)
        }
    };
    match value.items().iter().all(is_fine) && value.items().len() <= MOST_ITEMS {
        true => Ok(()),
        false => Err("A file cannot hold this value.".into()),
    }
}

/// The longest text of a property in bytes, which a reader of the file accepts.
const LONGEST_TEXT: usize = 1 << 15;
/// The most values of a list.
const MOST_ITEMS: usize = 4096;

/// Lets references to things that the edit has renamed follow the new names.
pub(super) fn follow_names(edit: &mut Edit) {
    let renamed = |(thing, before): (Entity, &ObjectState)| {
        let (old, new) = (before.id.as_ref()?, edit.world.get::<SceneId>(thing)?);
        (old != new).then(|| (old.0.clone(), new.0.clone()))
    };
    let renamed: Vec<(String, String)> = edit.touched().filter_map(renamed).collect();
    if renamed.is_empty() {
        return;
    }
    let new_name = |name: &str| {
        let found = renamed.iter().find(|(old, _)| old == name);
        found.map(|(_, new)| new.clone())
    };
    let mut all = edit.world.query::<(Entity, &Properties)>();
    let changed = all
        .iter(edit.world)
        .filter_map(|(thing, properties)| Some((thing, properties.renamed(new_name)?)));
    let changed: Vec<(Entity, Properties)> = changed.collect();
    for (thing, properties) in changed {
        edit.set(thing, properties);
    }
    let of_scene = edit.world.get_resource::<SceneProperties>();
    if let Some(properties) = of_scene.and_then(|own| own.0.renamed(new_name)) {
        edit.world.insert_resource(SceneProperties(properties));
    }
}
