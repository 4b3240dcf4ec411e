//! The actions of the menu *Arrange*: what moves snap to, steps, series, alignment and distribution.

use bevy_egui::egui::Key;

use super::action::{Action, ActionContext, Group, action, plain, shift};
use crate::app::editor::command::arrange::{Reference, Side, Spacing};
use crate::app::editor::command::gizmo_settings::{GizmoSettings, Pivot};
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::app::editor::command::snapping::{SnapTo, Snapping};
use crate::app::editor::command::{Command, Direction};

macro_rules! snap_to {
    ($name:literal, $label:literal, $to:ident) => {
        action(Group::Arrange, $name, $label, &[], |context| {
            Some(snapping(context, |snap| Snapping {
                to: SnapTo::$to,
                ..snap
            }))
        })
    };
}

macro_rules! pivot {
    ($name:literal, $label:literal, $pivot:ident) => {
        action(Group::Arrange, $name, $label, &[], |context| {
            Some(Command::SetGizmo(GizmoSettings {
                pivot: Pivot::$pivot,
                ..context.gizmo
            }))
        })
    };
}

macro_rules! nudge {
    ($name:literal, $label:literal, $key:expr, $direction:ident) => {
        action(Group::Arrange, $name, $label, &[plain($key)], |context| {
            context.with_selection(Command::Nudge(Direction::$direction))
        })
    };
}

macro_rules! align {
    ($name:literal, $label:literal, $axis:literal, $side:ident, $to:ident) => {
        action(Group::Arrange, $name, $label, &[], |context| {
            context.with_selection(Command::Align($axis, Side::$side, Reference::$to))
        })
    };
}

macro_rules! distribute {
    ($name:literal, $label:literal, $axis:literal, $by:ident) => {
        action(Group::Arrange, $name, $label, &[], |context| {
            context.with_selection(Command::Distribute($axis, Spacing::$by))
        })
    };
}

/// The actions in the order of the menu.
pub const ACTIONS: &[Action] = &[
    snap_to!("snap-increments", "Snap to increments", Increments),
    snap_to!("snap-grid", "Snap to the grid", Grid),
    snap_to!("snap-vertices", "Snap to vertices", Vertices),
    snap_to!("snap-edges", "Snap to edges", Edges),
    snap_to!("snap-faces", "Snap to faces", Faces),
    action(
        Group::Arrange,
        "snap-always",
        "Snap always or with Ctrl",
        &[shift(Key::Tab)],
        |context| {
            let always = !context.gizmo.snap.always;
            Some(snapping(context, |snap| Snapping { always, ..snap }))
        },
    ),
    action(
        Group::Arrange,
        "snap-align",
        "Turn to the surface when snapping",
        &[],
        |context| {
            let aligns = !context.gizmo.snap.aligns;
            Some(snapping(context, |snap| Snapping { aligns, ..snap }))
        },
    ),
    action(
        Group::Arrange,
        "selection-to-grid",
        "Put onto the grid",
        &[],
        |context| context.with_selection(Command::SnapToGrid),
    ),
    pivot!("pivot-middle", "Turn about the middle", Middle),
    pivot!("pivot-median", "Turn about the median", Median),
    pivot!("pivot-active", "Turn about the active thing", Active),
    pivot!("pivot-own", "Turn about own origins", Each),
    pivot!("pivot-world", "Turn about the world origin", World),
    nudge!("nudge-left", "Nudge left", Key::ArrowLeft, Left),
    nudge!("nudge-right", "Nudge right", Key::ArrowRight, Right),
    nudge!("nudge-ahead", "Nudge away", Key::ArrowUp, Ahead),
    nudge!("nudge-back", "Nudge nearer", Key::ArrowDown, Back),
    nudge!("nudge-up", "Nudge up", Key::PageUp, Up),
    nudge!("nudge-down", "Nudge down", Key::PageDown, Down),
    action(
        Group::Arrange,
        "drop",
        "Drop to the surface below",
        &[plain(Key::End)],
        |context| context.with_selection(Command::Drop),
    ),
    action(Group::Arrange, "series", "Series of copies…", &[], |context| {
        context.with_selection(Command::Shell(ShellCommand::ShowSheet(Sheet::Series)))
    }),
    action(Group::Arrange, "fit-to-view", "Fit to view", &[], |context| {
        context.with_selection(Command::FitToView(context.selection.entities().to_vec()))
    }),
    align!("align-x-low", "Align low sides along X", 0, Low, Bounds),
    align!("align-x-middle", "Align middles along X", 0, Middle, Bounds),
    align!("align-x-high", "Align high sides along X", 0, High, Bounds),
    align!("align-y-low", "Align low sides along Y", 1, Low, Bounds),
    align!("align-y-middle", "Align middles along Y", 1, Middle, Bounds),
    align!("align-y-high", "Align high sides along Y", 1, High, Bounds),
    align!("align-z-low", "Align low sides along Z", 2, Low, Bounds),
    align!("align-z-middle", "Align middles along Z", 2, Middle, Bounds),
    align!("align-z-high", "Align high sides along Z", 2, High, Bounds),
    align!(
        "align-active-x-low",
        "Align low sides with the active along X",
        0,
        Low,
        Active
    ),
    align!(
        "align-active-x-middle",
        "Align middles with the active along X",
        0,
        Middle,
        Active
    ),
    align!(
        "align-active-x-high",
        "Align high sides with the active along X",
        0,
        High,
        Active
    ),
    align!(
        "align-active-y-low",
        "Align low sides with the active along Y",
        1,
        Low,
        Active
    ),
    align!(
        "align-active-y-middle",
        "Align middles with the active along Y",
        1,
        Middle,
        Active
    ),
    align!(
        "align-active-y-high",
        "Align high sides with the active along Y",
        1,
        High,
        Active
    ),
    align!(
        "align-active-z-low",
        "Align low sides with the active along Z",
        2,
        Low,
        Active
    ),
    align!(
        "align-active-z-middle",
        "Align middles with the active along Z",
        2,
        Middle,
        Active
    ),
    align!(
        "align-active-z-high",
        "Align high sides with the active along Z",
        2,
        High,
        Active
    ),
    distribute!("distribute-x-gaps", "Equal gaps along X", 0, Gaps),
    distribute!("distribute-x-middles", "Equal distances along X", 0, Middles),
    distribute!("distribute-y-gaps", "Equal gaps along Y", 1, Gaps),
    distribute!("distribute-y-middles", "Equal distances along Y", 1, Middles),
    distribute!("distribute-z-gaps", "Equal gaps along Z", 2, Gaps),
    distribute!("distribute-z-middles", "Equal distances along Z", 2, Middles),
];

fn snapping(context: &ActionContext, change: impl Fn(Snapping) -> Snapping) -> Command {
    Command::SetGizmo(GizmoSettings {
        snap: change(context.gizmo.snap),
        ..context.gizmo
    })
}
