//! The actions of the menu *View*: camera, display, and overlays.

use bevy_egui::egui::Key;

use super::action::{Action, Group, action, alt, command, command_alt, command_numpad, numpad, plain, shift};
use crate::app::editor::command::axis_view::AxisView;
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::DisplaySettings;
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::meter_choice::MeterChoice;
use crate::app::editor::command::navigation_preset::NavigationPreset;
use crate::app::editor::command::seeing::Seeing;
use crate::app::editor::command::shortcut::Shortcut;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{CameraEdit, Command, DisplayCommand, ShellCommand, ToolCommand, ViewCommand};

/// The step of the exposure for a press of a bracket key, in stops.
const EXPOSURE_STEP: f32 = 0.25;

macro_rules! view {
    ($name:literal, $label:literal, $shortcut:expr => $command:expr) => {
        action(Group::View, $name, $label, &[$shortcut], |_| Some($command.into()))
    };
}

macro_rules! navigation {
    ($name:literal, $label:literal, $preset:ident) => {
        action(Group::View, $name, $label, &[], |_| {
            Some(ShellCommand::SetNavigation(NavigationPreset::$preset).into())
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
        |context| context.with_selection(ViewCommand::FrameSelection),
    ),
    action(
        Group::View,
        "frame-all",
        "Frame everything",
        &[plain(Key::Home)],
        |_| Some(ViewCommand::FrameAll.into()),
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
        |_| Some(CameraEdit::MoveCameraToView.into()),
    ),
    view!("view-front", "Look at the front", numpad(Key::Num1) => ViewCommand::LookAlong(AxisView::Front)),
    view!("view-back", "Look at the back", command_numpad(Key::Num1) => ViewCommand::LookAlong(AxisView::Back)),
    view!("view-right", "Look from the right", numpad(Key::Num3) => ViewCommand::LookAlong(AxisView::Right)),
    view!("view-left", "Look from the left", command_numpad(Key::Num3) => ViewCommand::LookAlong(AxisView::Left)),
    view!("view-top", "Look from above", numpad(Key::Num7) => ViewCommand::LookAlong(AxisView::Top)),
    view!("view-bottom", "Look from below", command_numpad(Key::Num7) => ViewCommand::LookAlong(AxisView::Bottom)),
    view!("switch-projection", "Perspective or orthographic", numpad(Key::Num5) => ViewCommand::SwitchProjection),
    action(
        Group::View,
        "walk",
        "Walk",
        &[plain(Key::C), shift(Key::Backtick)],
        |context| Some(ViewCommand::Walk(!context.walks).into()),
    ),
    action(
        Group::View,
        "four-views",
        "Four views",
        &[plain(Key::V), command_alt(Key::Q)],
        |context| Some(ViewCommand::ShowSideViews(!context.side_views.shown).into()),
    ),
    action(Group::View, "side-views-clay", "Side views in clay", &[], |context| {
        Some(ViewCommand::ShowSidesInClay(!context.side_views.clay).into())
    }),
    view!("view-1", "View 1", plain(Key::Num1) => ViewCommand::RecallView(1)),
    view!("view-2", "View 2", plain(Key::Num2) => ViewCommand::RecallView(2)),
    view!("view-3", "View 3", plain(Key::Num3) => ViewCommand::RecallView(3)),
    view!("view-4", "View 4", plain(Key::Num4) => ViewCommand::RecallView(4)),
    view!("view-5", "View 5", plain(Key::Num5) => ViewCommand::RecallView(5)),
    view!("view-6", "View 6", plain(Key::Num6) => ViewCommand::RecallView(6)),
    view!("view-7", "View 7", plain(Key::Num7) => ViewCommand::RecallView(7)),
    view!("view-8", "View 8", plain(Key::Num8) => ViewCommand::RecallView(8)),
    view!("view-9", "View 9", plain(Key::Num9) => ViewCommand::RecallView(9)),
    view!("store-view-1", "Store view 1", command(Key::Num1) => ViewCommand::StoreView(1)),
    view!("store-view-2", "Store view 2", command(Key::Num2) => ViewCommand::StoreView(2)),
    view!("store-view-3", "Store view 3", command(Key::Num3) => ViewCommand::StoreView(3)),
    view!("store-view-4", "Store view 4", command(Key::Num4) => ViewCommand::StoreView(4)),
    view!("store-view-5", "Store view 5", command(Key::Num5) => ViewCommand::StoreView(5)),
    view!("store-view-6", "Store view 6", command(Key::Num6) => ViewCommand::StoreView(6)),
    view!("store-view-7", "Store view 7", command(Key::Num7) => ViewCommand::StoreView(7)),
    view!("store-view-8", "Store view 8", command(Key::Num8) => ViewCommand::StoreView(8)),
    view!("store-view-9", "Store view 9", command(Key::Num9) => ViewCommand::StoreView(9)),
    action(
        Group::View,
        "next-mode",
        "Next display mode",
        &[plain(Key::Tab)],
        |context| {
            Some(
                DisplayCommand::SetDisplay(DisplaySettings {
                    mode: context.display.mode.next(),
                    ..context.display
                })
                .into(),
            )
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
        Some(DisplayCommand::ExposeAutomatically.into())
    }),
    action(
        Group::View,
        "see-into-rooms",
        "See into rooms",
        &[alt(Key::W)],
        |context| Some(ViewCommand::SetSeeing(context.seeing.with_walls_switched()).into()),
    ),
    action(
        Group::View,
        "cut-open",
        "Cut the scene open",
        &[alt(Key::C)],
        |context| {
            Some(match context.seeing.cut {
                None => Command::from(ViewCommand::CutOpen),
                Some(_) => Command::from(ViewCommand::SetSeeing(Seeing {
                    cut: None,
                    ..context.seeing
                })),
            })
        },
    ),
    action(
        Group::View,
        "isolate",
        "Show the selection alone",
        // Many keyboards have the slash above a digit.
        &[plain(Key::Slash), shift(Key::Slash)],
        |context| match context.isolated {
            true => Some(ViewCommand::Isolate(Vec::new()).into()),
            false => context.with_selection(ViewCommand::Isolate(context.selection.entities().to_vec())),
        },
    ),
    action(
        Group::View,
        "wireframe",
        "Wireframe of the selection",
        &[alt(Key::E)],
        |context| {
            Some(
                ViewCommand::SetSeeing(Seeing {
                    wireframe: !context.seeing.wireframe,
                    ..context.seeing
                })
                .into(),
            )
        },
    ),
    action(Group::View, "safe-frame", "Safe frame", &[], |context| {
        Some(DisplayCommand::ShowSafeFrame(!context.safe_frame).into())
    }),
    action(Group::View, "grid", "Grid and axes", &[plain(Key::Num0)], |context| {
        Some(
            DisplayCommand::SetGrid(GridSettings {
                shown: !context.grid.shown,
                ..context.grid
            })
            .into(),
        )
    }),
    action(
        Group::View,
        "dimensions",
        "Dimensions of the selection",
        &[],
        |context| Some(DisplayCommand::ShowDimensions(!context.dimensions).into()),
    ),
    action(Group::View, "ruler", "Measure distances", &[plain(Key::M)], |context| {
        Some(
            ToolCommand::SetTool(match context.tool {
                Tool::Ruler => Tool::Select,
                _ => Tool::Ruler,
            })
            .into(),
        )
    }),
    action(Group::View, "light-brush", "Paint the light you want", &[], |context| {
        Some(
            ToolCommand::SetTool(match context.tool {
                Tool::PaintLight => Tool::Select,
                _ => Tool::PaintLight,
            })
            .into(),
        )
    }),
    action(
        Group::View,
        "daylight-factors",
        "Meters show daylight factors",
        &[],
        |context| {
            let choice = MeterChoice {
                daylight: !context.meters.daylight,
                ..context.meters
            };
            Some(DisplayCommand::SetMeters(choice).into())
        },
    ),
    action(
        Group::View,
        "rate-glare",
        "Rate the glare of the view",
        &[],
        |context| {
            let choice = MeterChoice {
                glare: !context.meters.glare,
                ..context.meters
            };
            Some(DisplayCommand::SetMeters(choice).into())
        },
    ),
    action(
        Group::View,
        "clear-rulers",
        "Remove the measured distances",
        &[],
        |_| Some(ToolCommand::ClearRulers.into()),
    ),
    action(
        Group::View,
        "inspect-paths",
        "Inspect paths",
        &[plain(Key::P)],
        |context| {
            Some(
                ToolCommand::SetTool(match context.tool {
                    Tool::Paths => Tool::Select,
                    _ => Tool::Paths,
                })
                .into(),
            )
        },
    ),
    navigation!("navigation-sunroom", "Navigate as in Sunroom", Sunroom),
    navigation!("navigation-blender", "Navigate as in Blender", Blender),
    navigation!("navigation-godot", "Navigate as in Godot", Godot),
    navigation!("navigation-trenchbroom", "Navigate as in TrenchBroom", TrenchBroom),
    action(Group::View, "boxes", "BVH boxes", &[plain(Key::B)], |context| {
        Some(
            DisplayCommand::SetOverlay(BvhOverlay {
                shown: !context.overlay.shown,
                ..context.overlay
            })
            .into(),
        )
    }),
];
