//! The titles of steps in the history: the verb of the command, and the names of its things.

use bevy::math::Mat3A;
use bevy::prelude::*;

use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::traits::{Object, Subject};
use crate::app::editor::command::{EditCommand, SceneEdit, ValueEdit};
use crate::scene::{Declared, Locked, Medium, ObjectState, ToWorld};

/// The title of a step during the edit: names are read before it, because it may delete or rename things.
pub struct Title {
    verb: String,
    /// The things in the title; None for things that the edit creates, which are selected after it.
    subject: Option<String>,
    /// The object that they get, behind a colon; empty without any.
    object: String,
}

impl Title {
    /// To be called before the edit.
    pub fn before(world: &World, command: &EditCommand) -> Self {
        let selected = || {
            let selected = world.resource::<Selection>().entities().iter().copied();
            // Locked things stay as they are.
            let free = selected.filter(|entity| world.get::<Locked>(*entity).is_none());
            subject(world, &free.collect::<Vec<_>>())
        };
        let traits = command.traits();
        let named = match &traits.subject {
            Subject::Things(things) => Some(subject(world, things)),
            Subject::Selection => Some(selected()),
            Subject::Made => None,
        };
        Self {
            verb: verb(world, command, traits.label),
            subject: named,
            object: object(world, command, traits.object),
        }
    }

    /// To be called after the edit.
    pub fn after(self, world: &World) -> String {
        let Self {
            verb,
            subject: named,
            object,
        } = self;
        let named = named.unwrap_or_else(|| subject(world, world.resource::<Selection>().entities()));
        format!("{verb}{named}{object}")
    }
}

/// The name of one thing or the number of several, with a blank before it; empty for no thing and for one without a
/// name.
fn subject(world: &World, things: &[Entity]) -> String {
    match things {
        [] => String::new(),
        [only] => match world.get::<Name>(*only) {
            Some(name) if ObjectState::is_in_scene(world, *only) => format!(" `{name}`"),
            _ => String::new(),
        },
        several => format!(" {} things", several.len()),
    }
}

/// The material that things get, or their new name, or the changed parameter.
fn object(world: &World, command: &EditCommand, declared: Option<Object>) -> String {
    let name = match declared {
        Some(Object::Name(name)) => Some(name),
        Some(Object::Thing(thing)) => world.get::<Name>(thing).map(|name| name.to_string()),
        None => None,
    };
    let mut parameter = None;
    if let EditCommand::Value(ValueEdit::SetMedium(medium, after)) = command {
        let before = world.get(*medium);
        parameter = before.and_then(|before| parameter_of_medium(before, after));
    }
    let object = name.as_deref().or(parameter);
    object.map_or_else(String::new, |object| format!(": {object}"))
}

/// The only parameter in which two media differ.
fn parameter_of_medium(before: &Medium, after: &Medium) -> Option<&'static str> {
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    before.visit(&mut |info, value| ours.push((info.label, value)));
    after.visit(&mut |_, value| theirs.push(value));
    let values = ours.into_iter().zip(theirs);
    let mut changed: Vec<&str> = values
        .filter(|((_, ours), theirs)| ours != theirs)
        .map(|((label, _), _)| label)
        .collect();
    changed.extend((before.phase != after.phase).then_some("Phase"));
    match changed[..] {
        [only] => Some(only),
        _ => None,
    }
}

/// The verb of an edit: its label, with the kind of an added thing. For a change of pose it depends on the change of
/// the first thing.
fn verb(world: &World, command: &EditCommand, label: &str) -> String {
    if let EditCommand::Scene(SceneEdit::Add(addition)) = command {
        return format!("{label} {}", addition.kind.name());
    }
    let moved = if let EditCommand::Value(ValueEdit::Transform(poses)) = command {
        poses.first().copied()
    } else if let EditCommand::Value(ValueEdit::Turn(entity, after, _)) = command {
        Some((*entity, *after))
    } else {
        None
    };
    let change = moved.and_then(|(entity, after)| Some([world.get::<ToWorld>(entity)?.0.matrix3, after.matrix3]));
    let Some([before, after]) = change.filter(|[before, after]| before != after) else {
        return label.to_owned();
    };
    // A rotation keeps the lengths of the axes.
    let lengths = |matrix: Mat3A| [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.length());
    let is_turn = lengths(before)
        .iter()
        .zip(lengths(after))
        .all(|(before, after)| (after - before).abs() <= 1e-4 * before);
    if is_turn { "Rotate" } else { "Scale" }.to_owned()
}
