//! What the history calls the steps: the verb of the command, and the names of the things it was about.

use bevy::math::Mat3A;
use bevy::prelude::*;

use crate::app::editor::command::Command;
use crate::app::editor::command::media::Filling;
use crate::app::editor::command::selection::Selection;
use crate::scene::{Locked, Medium, ObjectState, ToWorld};

/// The title of a step while the edit is made: names are read before it, because it may delete or rename things.
pub struct Title {
    verb: String,
    /// The things that the edit is about; None for things that it makes, which are selected after it.
    subject: Option<String>,
    /// What they get, behind a colon; empty without any.
    object: String,
}

impl Title {
    /// To be called before the edit.
    pub fn before(world: &World, command: &Command) -> Self {
        let selected = || {
            let selected = world.resource::<Selection>().entities().iter().copied();
            // Locked things stay as they are.
            let free = selected.filter(|entity| world.get::<Locked>(*entity).is_none());
            subject(world, &free.collect::<Vec<_>>())
        };
        let targets = command.targets();
        let named = match command {
            Command::Add(_) | Command::Import(_) | Command::UseFile(_) | Command::Paste(_) => None,
            Command::Duplicate
            | Command::MakeSeries(_)
            | Command::Align(..)
            | Command::Distribute(..)
            | Command::Delete
            | Command::Cut
            | Command::Group
            | Command::Ungroup
            | Command::Nudge(_)
            | Command::Drop
            | Command::SnapToGrid => Some(selected()),
            Command::Key(targets, _) if targets.is_empty() => Some(selected()),
            _ => Some(subject(world, &targets)),
        };
        Self {
            verb: verb(world, command),
            subject: named,
            object: object(world, command),
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

/// The name of one thing or the number of several, with a blank before it; empty for nothing and for a thing without a
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

/// The material that things get, or their new name.
fn object(world: &World, command: &Command) -> String {
    let object = match command {
        Command::UsePreset { preset, .. } | Command::DropPreset { preset, .. } => Some(preset.name.as_str()),
        Command::UseMaterial { material: None, .. } => Some("none"),
        Command::UseMaterial {
            material: Some(material),
            ..
        } => world.get::<Name>(*material).map(Name::as_str),
        Command::UseMedium { medium: None, .. } => Some("none"),
        Command::UseMedium {
            medium: Some(medium), ..
        }
        | Command::Fill {
            with: Filling::Medium(medium),
            ..
        } => world.get::<Name>(*medium).map(Name::as_str),
        Command::Fill { with, .. } => with.name(),
        Command::Rename(_, name) => Some(name.as_str()),
        Command::SetMedium(entity, after) => world.get(*entity).and_then(|before| parameter_of_medium(before, after)),
        _ => None,
    };
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

/// The verb of a command: [`Command::label`], with the kind of what is added. For a change of pose it tells what
/// happens to the first thing.
fn verb(world: &World, command: &Command) -> String {
    let change = match command {
        Command::Add(addition) => return format!("{} {}", command.label(), addition.kind.name()),
        Command::Transform(poses) => poses.first().and_then(|(entity, after)| {
            let before = world.get::<ToWorld>(*entity)?.0.matrix3;
            Some([before, after.matrix3])
        }),
        Command::Turn(entity, after, _) => world
            .get::<ToWorld>(*entity)
            .map(|pose| [pose.0.matrix3, after.matrix3]),
        _ => None,
    };
    let Some([before, after]) = change.filter(|[before, after]| before != after) else {
        return command.label().to_owned();
    };
    // A rotation keeps the lengths of the axes.
    let lengths = |matrix: Mat3A| [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.length());
    let is_turn = lengths(before)
        .iter()
        .zip(lengths(after))
        .all(|(before, after)| (after - before).abs() <= 1e-4 * before);
    if is_turn { "Rotate" } else { "Scale" }.to_owned()
}
