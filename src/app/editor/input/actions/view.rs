//! The actions of the menu *View*: camera, display, and what is drawn over the picture.

use bevy_egui::egui::Key;

use super::action::{Action, Group, action, alt, command, command_alt, command_numpad, numpad, plain, shift};
use crate::app::editor::command::Command;
use crate::app::editor::command::axis_view::AxisView;
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::DisplaySettings;
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::navigation_preset::NavigationPreset;
use crate::app::editor::command::seeing::Seeing;
use crate::app::editor::command::shell::ShellCommand;
use crate::app::editor::command::shortcut::Shortcut;
use crate::app::editor::command::tool::Tool;

/// The stops of a press of a bracket key.
const EXPOSURE_STEP: f32 = 0.25;

macro_rules! view {
    ($name:literal, $label:literal, $shortcut:expr => $command:expr) => {
        action(Group::View, $name, $label, &[$shortcut], |_| Some($command))
    };
}

macro_rules! navigation {
    ($name:literal, $label:literal, $preset:ident) => {
        action(Group::View, $name, $label, &[], |_| {
            Some(Command::Shell(ShellCommand::SetNavigation(NavigationPreset::$preset)))
        })
    };
}

/// The actions in the order of the menu.
pub const ACTIONS: &[Action] = &[
    action(
        Group::View,
        "frame-selection",
        "Frame the selection",
        &[plain(Key::F)],
        |context| context.with_selection(Command::FrameSelection),
    ),
    action(
        Group::View,
        "frame-all",
        "Frame everything",
        &[plain(Key::Home)],
        |_| Some(Command::FrameAll),
    ),
    action(
        Group::View,
        "camera-to-view",
        "Move camera to view",
        &[
            command_alt(Key::Num0),
            Shortcut {
                numpad: true,
                ..command_alt(Key::Num0)
            },
        ],
        |_| Some(Command::MoveCameraToView),
    ),
    view!("view-front", "Look at the front", numpad(Key::Num1) => Command::LookAlong(AxisView::Front)),
    view!("view-back", "Look at the back", command_numpad(Key::Num1) => Command::LookAlong(AxisView::Back)),
    view!("view-right", "Look from the right", numpad(Key::Num3) => Command::LookAlong(AxisView::Right)),
    view!("view-left", "Look from the left", command_numpad(Key::Num3) => Command::LookAlong(AxisView::Left)),
    view!("view-top", "Look from above", numpad(Key::Num7) => Command::LookAlong(AxisView::Top)),
    view!("view-bottom", "Look from below", command_numpad(Key::Num7) => Command::LookAlong(AxisView::Bottom)),
    view!("switch-projection", "Perspective or orthographic", numpad(Key::Num5) => Command::SwitchProjection),
    view!("view-1", "View 1", plain(Key::Num1) => Command::RecallView(1)),
    view!("view-2", "View 2", plain(Key::Num2) => Command::RecallView(2)),
    view!("view-3", "View 3", plain(Key::Num3) => Command::RecallView(3)),
    view!("view-4", "View 4", plain(Key::Num4) => Command::RecallView(4)),
    view!("view-5", "View 5", plain(Key::Num5) => Command::RecallView(5)),
    view!("view-6", "View 6", plain(Key::Num6) => Command::RecallView(6)),
    view!("view-7", "View 7", plain(Key::Num7) => Command::RecallView(7)),
    view!("view-8", "View 8", plain(Key::Num8) => Command::RecallView(8)),
    view!("view-9", "View 9", plain(Key::Num9) => Command::RecallView(9)),
    view!("store-view-1", "Store view 1", command(Key::Num1) => Command::StoreView(1)),
    view!("store-view-2", "Store view 2", command(Key::Num2) => Command::StoreView(2)),
    view!("store-view-3", "Store view 3", command(Key::Num3) => Command::StoreView(3)),
    view!("store-view-4", "Store view 4", command(Key::Num4) => Command::StoreView(4)),
    view!("store-view-5", "Store view 5", command(Key::Num5) => Command::StoreView(5)),
    view!("store-view-6", "Store view 6", command(Key::Num6) => Command::StoreView(6)),
    view!("store-view-7", "Store view 7", command(Key::Num7) => Command::StoreView(7)),
    view!("store-view-8", "Store view 8", command(Key::Num8) => Command::StoreView(8)),
    view!("store-view-9", "Store view 9", command(Key::Num9) => Command::StoreView(9)),
    action(
        Group::View,
        "next-mode",
        "Next display mode",
        &[plain(Key::Tab)],
        |context| {
            Some(Command::SetDisplay(DisplaySettings {
                mode: context.display.mode.next(),
                ..context.display
            }))
        },
    ),
    action(Group::View, "darker", "Darker", &[plain(Key::OpenBracket)], |context| {
        Some(context.exposed(-EXPOSURE_STEP))
    }),
    action(
        Group::View,
        "brighter",
        "Brighter",
        &[plain(Key::CloseBracket)],
        |context| Some(context.exposed(EXPOSURE_STEP)),
    ),
    action(Group::View, "expose-automatically", "Expose automatically", &[], |_| {
        Some(Command::ExposeAutomatically)
    }),
    action(
        Group::View,
        "see-into-rooms",
        "See into rooms, or not",
        &[alt(Key::W)],
        |context| Some(Command::SetSeeing(context.seeing.with_walls_switched())),
    ),
    action(
        Group::View,
        "cut-open",
        "Cut the scene open, or shut",
        &[alt(Key::C)],
        |context| {
            Some(match context.seeing.cut {
                None => Command::CutOpen,
                Some(_) => Command::SetSeeing(Seeing {
                    cut: None,
                    ..context.seeing
                }),
            })
        },
    ),
    action(
        Group::View,
        "isolate",
        "Show the selection alone, or all",
        // Many keyboards have the slash above a digit.
        &[plain(Key::Slash), shift(Key::Slash)],
        |context| match context.isolated {
            true => Some(Command::Isolate(Vec::new())),
            false => context.with_selection(Command::Isolate(context.selection.entities().to_vec())),
        },
    ),
    action(
        Group::View,
        "wireframe",
        "Wireframe of the selection",
        &[alt(Key::E)],
        |context| {
            Some(Command::SetSeeing(Seeing {
                wireframe: !context.seeing.wireframe,
                ..context.seeing
            }))
        },
    ),
    action(Group::View, "safe-frame", "Safe frame", &[], |context| {
        Some(Command::ShowSafeFrame(!context.safe_frame))
    }),
    action(Group::View, "grid", "Grid and axes", &[plain(Key::Num0)], |context| {
        Some(Command::SetGrid(GridSettings {
            shown: !context.grid.shown,
            ..context.grid
        }))
    }),
    action(
        Group::View,
        "dimensions",
        "Dimensions of the selection",
        &[],
        |context| Some(Command::ShowDimensions(!context.dimensions)),
    ),
    action(Group::View, "ruler", "Measure distances", &[plain(Key::M)], |context| {
        Some(Command::SetTool(match context.tool {
            Tool::Ruler => Tool::Select,
            _ => Tool::Ruler,
        }))
    }),
    action(
        Group::View,
        "clear-rulers",
        "Remove the measured distances",
        &[],
        |_| Some(Command::ClearRulers),
    ),
    action(
        Group::View,
        "inspect-paths",
        "Inspect paths",
        &[plain(Key::P)],
        |context| {
            Some(Command::SetTool(match context.tool {
                Tool::Paths => Tool::Select,
                _ => Tool::Paths,
            }))
        },
    ),
    navigation!("navigation-sunroom", "Navigate as in Sunroom", Sunroom),
    navigation!("navigation-blender", "Navigate as in Blender", Blender),
    navigation!("navigation-godot", "Navigate as in Godot", Godot),
    navigation!("navigation-trenchbroom", "Navigate as in TrenchBroom", TrenchBroom),
    action(Group::View, "boxes", "BVH boxes", &[plain(Key::B)], |context| {
        Some(Command::SetOverlay(BvhOverlay {
            shown: !context.overlay.shown,
            ..context.overlay
        }))
    }),
];
