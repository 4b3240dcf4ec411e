//! The table itself: names, labels, keys, and the command each action is.

use bevy_egui::egui::Key;

use super::{Action, ActionContext, Group, Shortcut};
use crate::app::editor::command::addition::AdditionKind;
use crate::app::editor::command::axis_view::AxisView;
use crate::app::editor::command::blocking::{BlockKind, OpeningKind};
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::DisplaySettings;
use crate::app::editor::command::gizmo_settings::{Axes, GizmoSettings, Mode};
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::navigation_preset::NavigationPreset;
use crate::app::editor::command::resolution::FullFilm;
use crate::app::editor::command::seeing::Seeing;
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{Command, FileDialogKind};
use crate::scene::LengthUnit;

pub(super) const fn plain(key: Key) -> Shortcut {
    Shortcut::plain(key)
}

const fn numpad(key: Key) -> Shortcut {
    Shortcut {
        numpad: true,
        ..plain(key)
    }
}

const fn command_numpad(key: Key) -> Shortcut {
    Shortcut {
        command: true,
        ..numpad(key)
    }
}

const fn command_alt(key: Key) -> Shortcut {
    Shortcut {
        alt: true,
        ..command(key)
    }
}

const fn command(key: Key) -> Shortcut {
    Shortcut {
        command: true,
        ..plain(key)
    }
}

pub(super) const fn shift(key: Key) -> Shortcut {
    Shortcut {
        shift: true,
        ..plain(key)
    }
}

const fn alt(key: Key) -> Shortcut {
    Shortcut {
        alt: true,
        ..plain(key)
    }
}

const fn command_shift(key: Key) -> Shortcut {
    Shortcut {
        command: true,
        ..shift(key)
    }
}

/// The stops of a press of a bracket key.
const EXPOSURE_STEP: f32 = 0.25;

pub(super) const fn action(
    group: Group,
    name: &'static str,
    label: &'static str,
    keys: &'static [Shortcut],
    command: fn(&ActionContext) -> Option<Command>,
) -> Action {
    Action {
        name,
        label,
        group,
        keys,
        command,
    }
}

macro_rules! gizmo_mode {
    ($name:literal, $label:literal, $key:expr, $mode:ident) => {
        action(Group::Edit, $name, $label, &[plain($key)], |context| {
            Some(Command::SetGizmo(GizmoSettings {
                mode: Mode::$mode,
                is_hidden: false,
                ..context.gizmo
            }))
        })
    };
}

macro_rules! tool {
    ($name:literal, $label:literal, $tool:ident $(($kind:expr))?) => {
        action(Group::Add, $name, $label, &[], |context| {
            let tool = Tool::$tool $(($kind))?;
            Some(Command::SetTool(if context.tool == tool { Tool::Select } else { tool }))
        })
    };
}

macro_rules! unit {
    ($name:literal, $label:literal, $unit:ident) => {
        action(Group::Edit, $name, $label, &[], |_| {
            Some(Command::SetUnit(LengthUnit::$unit))
        })
    };
}

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

/// All actions but those of the menu *Arrange*, in the order of the menus.
pub const ACTIONS: &[Action] = &[
    action(Group::File, "new", "New scene", &[command(Key::N)], |_| {
        Some(Command::NewScene)
    }),
    action(Group::File, "start-page", "Start page", &[], |_| {
        Some(Command::Shell(ShellCommand::ShowSheet(Sheet::Start)))
    }),
    action(Group::File, "open", "Open…", &[command(Key::O)], |_| {
        Some(Command::ShowDialog(FileDialogKind::OpenScene))
    }),
    action(
        Group::File,
        "reload",
        "Reload, keeping edits",
        &[plain(Key::F5)],
        |_| Some(Command::ReloadScene),
    ),
    action(Group::File, "revert", "Revert to the file", &[], |_| {
        Some(Command::RevertScene)
    }),
    action(Group::File, "import", "Import…", &[command(Key::I)], |_| {
        Some(Command::ShowDialog(FileDialogKind::Import))
    }),
    action(Group::File, "save", "Save", &[command(Key::S)], |_| Some(Command::Save)),
    action(Group::File, "save-as", "Save as…", &[command_shift(Key::S)], |_| {
        Some(Command::ShowDialog(FileDialogKind::SaveScene))
    }),
    action(Group::File, "save-image", "Save image…", &[plain(Key::F12)], |_| {
        Some(Command::ShowDialog(FileDialogKind::SaveImage))
    }),
    action(Group::File, "quit", "Quit", &[command(Key::Q)], |_| Some(Command::Quit)),
    action(Group::Edit, "undo", "Undo", &[command(Key::Z)], |_| Some(Command::Undo)),
    action(
        Group::Edit,
        "redo",
        "Redo",
        &[command_shift(Key::Z), command(Key::Y)],
        |_| Some(Command::Redo),
    ),
    action(Group::Edit, "duplicate", "Duplicate", &[command(Key::D)], |context| {
        context.with_selection(Command::Duplicate)
    }),
    action(Group::Edit, "delete", "Delete", &[plain(Key::Delete)], |context| {
        context.with_selection(Command::Delete)
    }),
    action(Group::Edit, "group", "Group", &[command(Key::G)], |context| {
        context.with_selection(Command::Group)
    }),
    action(Group::Edit, "ungroup", "Ungroup", &[command_shift(Key::G)], |context| {
        context.with_selection(Command::Ungroup)
    }),
    action(
        Group::Edit,
        "select-group",
        "Select the group",
        &[shift(Key::G)],
        |context| context.with_selection(Command::SelectGroup),
    ),
    action(
        Group::Edit,
        "select-all",
        "Select everything",
        &[command(Key::A)],
        |_| Some(Command::SelectAll),
    ),
    action(
        Group::Edit,
        "select-none",
        "Select nothing",
        &[plain(Key::Escape)],
        |context| match context.tool {
            Tool::Select => context.with_selection(Command::Select(Vec::new(), Extend::Replace)),
            _ => Some(Command::SetTool(Tool::Select)),
        },
    ),
    action(Group::Edit, "hide", "Hide", &[plain(Key::H)], |context| {
        context.with_selection(Command::Hide(context.selection.entities().to_vec(), true))
    }),
    action(
        Group::Edit,
        "hide-others",
        "Hide the others",
        &[command(Key::H)],
        |context| context.with_selection(Command::HideOthers),
    ),
    action(Group::Edit, "show-all", "Show everything", &[alt(Key::H)], |_| {
        Some(Command::ShowAll)
    }),
    gizmo_mode!("gizmo-move", "Move with the gizmo", Key::G, Move),
    gizmo_mode!("gizmo-rotate", "Rotate with the gizmo", Key::R, Rotate),
    gizmo_mode!("gizmo-scale", "Scale with the gizmo", Key::T, Scale),
    action(Group::Edit, "gizmo-hide", "Select without handles", &[], |context| {
        Some(Command::SetGizmo(GizmoSettings {
            is_hidden: true,
            ..context.gizmo
        }))
    }),
    action(
        Group::Edit,
        "gizmo-axes",
        "World or local axes",
        &[plain(Key::X)],
        |context| {
            let axes = match context.gizmo.axes {
                Axes::World => Axes::Local,
                Axes::Local => Axes::World,
            };
            let settings = GizmoSettings { axes, ..context.gizmo };
            Some(Command::SetGizmo(settings))
        },
    ),
    action(Group::Add, "add-sphere", "Sphere", &[], |_| {
        Some(addition(AdditionKind::Sphere))
    }),
    action(Group::Add, "add-rectangle", "Rectangle", &[], |_| {
        Some(addition(AdditionKind::Rectangle))
    }),
    action(Group::Add, "add-cube", "Cube", &[], |_| {
        Some(addition(AdditionKind::Cube))
    }),
    action(Group::Add, "add-disk", "Disk", &[], |_| {
        Some(addition(AdditionKind::Disk))
    }),
    action(Group::Add, "add-cylinder", "Cylinder", &[], |_| {
        Some(addition(AdditionKind::Cylinder))
    }),
    action(Group::Add, "add-wall", "Wall", &[], |_| {
        Some(addition(AdditionKind::Solid("wall")))
    }),
    action(Group::Add, "add-stairs", "Stairs", &[], |_| {
        Some(addition(AdditionKind::Solid("stairs")))
    }),
    action(Group::Add, "add-prism", "Prism", &[], |_| {
        Some(addition(AdditionKind::Solid("prism")))
    }),
    tool!("draw-box", "Draw a box", Draw(BlockKind::Box)),
    tool!("draw-floor", "Draw a floor", Draw(BlockKind::Floor)),
    tool!("draw-wall", "Draw a wall", Draw(BlockKind::Wall)),
    tool!("cut-door", "Cut a door", Cut(OpeningKind::Door)),
    tool!("cut-window", "Cut a window", Cut(OpeningKind::Window)),
    tool!("push-faces", "Push and pull faces", Push),
    action(Group::Add, "add-area", "Area light", &[], |_| {
        Some(addition(AdditionKind::AreaLight))
    }),
    action(Group::Add, "add-point", "Point light", &[], |_| {
        Some(addition(AdditionKind::Emitter("point")))
    }),
    action(Group::Add, "add-spot", "Spot light", &[], |_| {
        Some(addition(AdditionKind::Emitter("spot")))
    }),
    action(Group::Add, "add-projector", "Projector", &[], |_| {
        Some(addition(AdditionKind::Emitter("projector")))
    }),
    action(Group::Add, "add-directional", "Directional light", &[], |_| {
        Some(addition(AdditionKind::Emitter("directional")))
    }),
    action(Group::Add, "add-constant", "Constant sky", &[], |_| {
        Some(addition(AdditionKind::Emitter("constant")))
    }),
    action(Group::Add, "add-envmap", "Environment map…", &[], |_| {
        Some(Command::ShowDialog(FileDialogKind::OpenEnvironment))
    }),
    action(Group::Add, "add-sunsky", "Sun and sky", &[], |_| {
        Some(addition(AdditionKind::Emitter("sunsky")))
    }),
    action(Group::Add, "add-camera", "Camera at the view", &[], |_| {
        Some(addition(AdditionKind::Camera))
    }),
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
    unit!("unit-none", "Unit: none", None),
    unit!("unit-m", "Unit: metres", Metre),
    unit!("unit-cm", "Unit: centimetres", Centimetre),
    unit!("unit-mm", "Unit: millimetres", Millimetre),
    unit!("unit-in", "Unit: inches", Inch),
    unit!("unit-ft", "Unit: feet", Foot),
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
    action(Group::Render, "focus", "Focus by a click", &[], |_| {
        Some(Command::SetTool(Tool::Focus))
    }),
    action(Group::Render, "draw-region", "Draw the region to render", &[], |_| {
        Some(Command::SetTool(Tool::Region))
    }),
    action(Group::View, "boxes", "BVH boxes", &[plain(Key::B)], |context| {
        Some(Command::SetOverlay(BvhOverlay {
            shown: !context.overlay.shown,
            ..context.overlay
        }))
    }),
    action(
        Group::Render,
        "pause",
        "Pause or go on",
        &[plain(Key::Space)],
        |context| Some(Command::SetPaused(!context.paused)),
    ),
    action(Group::Render, "restart", "Start again", &[shift(Key::R)], |_| {
        Some(Command::Restart)
    }),
    action(Group::Render, "render-full", "Render full film", &[], |_| {
        Some(Command::RenderFull(FullFilm::default()))
    }),
    action(Group::Render, "stop-full", "Stop the full film", &[], |_| {
        Some(Command::StopFull)
    }),
    action(Group::Render, "denoise", "Denoise", &[plain(Key::N)], |_| {
        Some(Command::Denoise)
    }),
    action(Group::Render, "bake-lights", "Bake the light mix", &[], |_| {
        Some(Command::BakeLights)
    }),
    action(Group::Render, "take-snapshot", "Take snapshot", &[], |_| {
        Some(Command::TakeSnapshot)
    }),
    action(Group::Render, "measure", "Measure against snapshot", &[], |_| {
        Some(Command::Measure)
    }),
    action(
        Group::Window,
        "panels",
        "Show or hide panels",
        &[command(Key::B)],
        |context| Some(Command::ShowPanels(!context.panels_shown)),
    ),
    action(Group::Window, "palette", "Commands…", &[command(Key::P)], |_| {
        Some(Command::Shell(ShellCommand::ShowSheet(Sheet::Palette)))
    }),
    action(
        Group::Window,
        "shortcuts",
        "Keys and mouse",
        &[plain(Key::F1), shift(Key::Questionmark)],
        |_| Some(Command::Shell(ShellCommand::ShowSheet(Sheet::Shortcuts))),
    ),
    action(
        Group::Window,
        "preferences",
        "Preferences…",
        &[command(Key::Comma)],
        |_| Some(Command::Shell(ShellCommand::ShowSheet(Sheet::Preferences))),
    ),
    action(Group::Window, "choose-keys", "Choose keys…", &[], |_| {
        Some(Command::Shell(ShellCommand::ShowSheet(Sheet::Keys)))
    }),
    action(Group::Window, "tutorial", "Tutorial", &[], |_| {
        Some(Command::Shell(ShellCommand::ShowTutorial(Some(0))))
    }),
    action(Group::Window, "reset-layout", "Reset layout", &[], |_| {
        Some(Command::Shell(ShellCommand::ResetLayout))
    }),
    action(Group::Window, "full-screen", "Full screen", &[plain(Key::F11)], |_| {
        Some(Command::Shell(ShellCommand::ToggleFullScreen))
    }),
];

fn addition(kind: AdditionKind) -> Command {
    Command::Add(kind.into())
}
