//! The actions of the menu *Arrange*: snapping, steps, series, alignment and distribution, in the order of the menu.

use bevy_egui::egui::Key;

use super::action::{Action, ActionContext, Group, action, plain, shift};
use crate::app::editor::command::arrange::{Direction, Reference, Side, Spacing};
use crate::app::editor::command::gizmo_settings::{GizmoSettings, Pivot};
use crate::app::editor::command::scene::Replacement;
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::app::editor::command::snapping::{SnapTo, Snapping};
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{ArrangeEdit, Command, FileCommand, FileDialogKind, SceneEdit, ToolCommand};

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
            Some(
                ToolCommand::SetGizmo(GizmoSettings {
                    pivot: Pivot::$pivot,
                    ..context.gizmo
                })
                .into(),
            )
        })
    };
}

macro_rules! nudge {
    ($name:literal, $label:literal, $key:expr, $direction:ident) => {
        action(Group::Arrange, $name, $label, &[plain($key)], |context| {
            context.with_selection(ArrangeEdit::Nudge(Direction::$direction))
        })
    };
}

macro_rules! alignments {
    ($name:literal, $with:literal, $to:ident, [$(($axis:literal, $letter:literal, $title:literal)),*]) => {
        &[$(
            alignments!(@ $name, $with, $to, $axis, $letter, $title, "low", "low sides", Low),
            alignments!(@ $name, $with, $to, $axis, $letter, $title, "middle", "middles", Middle),
            alignments!(@ $name, $with, $to, $axis, $letter, $title, "high", "high sides", High),
        )*]
    };
    (@ $name:literal, $with:literal, $to:ident, $axis:literal, $letter:literal, $title:literal,
        $side_name:literal, $sides:literal, $side:ident) => {
        action(
            Group::Arrange,
            concat!($name, "-", $letter, "-", $side_name),
            concat!("Align ", $sides, $with, " along ", $title),
            &[],
            |context| context.with_selection(ArrangeEdit::Align($axis, Side::$side, Reference::$to)),
        )
    };
}

macro_rules! distribute {
    ($name:literal, $label:literal, $axis:literal, $by:ident) => {
        action(Group::Arrange, $name, $label, &[], |context| {
            context.with_selection(ArrangeEdit::Distribute($axis, Spacing::$by))
        })
    };
}

/// Snapping, pivots, steps, dropping and series.
pub const ACTIONS: &[Action] = &[
    action(
        Group::Arrange,
        "place-texture",
        "Place texture",
        &[plain(Key::U)],
        |context| match context.tool {
            Tool::PlaceTexture => Some(ToolCommand::SetTool(Tool::Select).into()),
            _ => context
                .has_textures
                .then_some(Command::from(ToolCommand::SetTool(Tool::PlaceTexture))),
        },
    ),
    action(Group::Arrange, "project-texture", "Project texture…", &[], |context| {
        context.with_selection(ShellCommand::ShowSheet(Sheet::Projection))
    }),
    snap_to!("snap-increments", "Snap to increments", Increments),
    snap_to!("snap-grid", "Snap to the grid", Grid),
    snap_to!("snap-vertices", "Snap to vertices", Vertices),
    snap_to!("snap-edges", "Snap to edges", Edges),
    snap_to!("snap-faces", "Snap to faces", Faces),
    action(
        Group::Arrange,
        "snap-always",
        "Always snap",
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
        |context| context.with_selection(ArrangeEdit::SnapToGrid),
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
        |context| context.with_selection(ArrangeEdit::Drop),
    ),
    action(Group::Arrange, "series", "Series of copies…", &[], |context| {
        context.with_selection(ShellCommand::ShowSheet(Sheet::Series))
    }),
    action(
        Group::Arrange,
        "replace-by-file",
        "Replace by a mesh…",
        &[],
        |context| context.with_selection(FileCommand::ShowDialog(FileDialogKind::Replace)),
    ),
    action(
        Group::Arrange,
        "replace-by-active",
        "Replace by the shape selected last",
        &[],
        |context| {
            let [_, .., active] = *context.selection.entities() else {
                return None;
            };
            Some(SceneEdit::Replace(Replacement::Shape(active)).into())
        },
    ),
    action(Group::Arrange, "fit-to-view", "Fit to view", &[], |context| {
        context.with_selection(ArrangeEdit::FitToView(context.selection.entities().to_vec()))
    }),
];

/// Alignment with the box around the selection.
pub const ALIGN: &[Action] = alignments!("align", "", Bounds, [(0, "x", "X"), (1, "y", "Y"), (2, "z", "Z")]);

/// Alignment with the active thing.
pub const ALIGN_WITH_ACTIVE: &[Action] = alignments!(
    "align-active",
    " with the active",
    Active,
    [(0, "x", "X"), (1, "y", "Y"), (2, "z", "Z")]
);

/// Even spacing.
pub const DISTRIBUTE: &[Action] = &[
    distribute!("distribute-x-gaps", "Equal gaps along X", 0, Gaps),
    distribute!("distribute-x-middles", "Equal distances along X", 0, Middles),
    distribute!("distribute-y-gaps", "Equal gaps along Y", 1, Gaps),
    distribute!("distribute-y-middles", "Equal distances along Y", 1, Middles),
    distribute!("distribute-z-gaps", "Equal gaps along Z", 2, Gaps),
    distribute!("distribute-z-middles", "Equal distances along Z", 2, Middles),
];

fn snapping(context: &ActionContext, change: impl Fn(Snapping) -> Snapping) -> Command {
    Command::from(ToolCommand::SetGizmo(GizmoSettings {
        snap: change(context.gizmo.snap),
        ..context.gizmo
    }))
}
