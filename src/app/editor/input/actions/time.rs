//! The actions of the menu *Time*: the timeline, its frames, and keys of the selection.

use bevy_egui::egui::Key;

use super::action::{Action, Group, action, alt, plain, shift};
use crate::app::editor::command::timeline::TimeStep;
use crate::app::editor::command::{TimeCommand, TimeEdit};
use crate::scene::KeyEdit;

macro_rules! step {
    ($name:literal, $label:literal, $keys:expr, $step:ident) => {
        action(Group::Time, $name, $label, $keys, |_| {
            Some(TimeCommand::StepTime(TimeStep::$step).into())
        })
    };
}

macro_rules! key {
    ($name:literal, $label:literal, $keys:expr, $edit:ident) => {
        action(Group::Time, $name, $label, $keys, |context| {
            context.with_selection(TimeEdit::Key(Vec::new(), KeyEdit::$edit))
        })
    };
}

/// The actions in the order of the menu.
pub const ACTIONS: &[Action] = &[
    action(Group::Time, "timeline-shown", "Timeline", &[alt(Key::T)], |context| {
        Some(TimeCommand::ShowTimeline(!context.timeline_shown).into())
    }),
    action(Group::Time, "play", "Play", &[shift(Key::Space)], |context| {
        Some(TimeCommand::SetPlaying(!context.playing).into())
    }),
    step!("first-frame", "First frame", &[], FirstFrame),
    step!("last-frame", "Last frame", &[], LastFrame),
    step!("previous-frame", "Previous frame", &[plain(Key::Comma)], PreviousFrame),
    step!("next-frame", "Next frame", &[plain(Key::Period)], NextFrame),
    step!("previous-key", "Previous key", &[alt(Key::Comma)], PreviousKey),
    step!("next-key", "Next key", &[alt(Key::Period)], NextKey),
    key!("set-key", "Set a key of the place", &[plain(Key::K)], Set),
    key!("remove-key", "Remove the keys at this time", &[alt(Key::K)], Remove),
    key!("remove-animation", "Remove all keys", &[], RemoveAll),
];
