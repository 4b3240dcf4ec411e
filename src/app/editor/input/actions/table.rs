//! The actions of the menus *File*, *Edit*, *Add*, *Render* and *Window*: names, labels, keys, and the command of each.

use bevy_egui::egui::Key;

use super::action::{Action, ActionContext, Group, action, alt, command, command_shift, plain, shift};
use crate::app::editor::command::addition::AdditionKind;
use crate::app::editor::command::blocking::{BlockKind, OpeningKind};
use crate::app::editor::command::gizmo_settings::{Axes, GizmoSettings, Mode};
use crate::app::editor::command::media::Filling;
use crate::app::editor::command::resolution::FullFilm;
use crate::app::editor::command::selection::{Alike, Extend};
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{BakeCommand, KeptPicture};
use crate::app::editor::command::{
    CameraEdit, Command, DisplayCommand, FileCommand, FileDialogKind, HistoryCommand, MediumEdit, OutlineEdit,
    RenderCommand, SceneEdit, SelectionCommand, SettingsEdit, TimeEdit, ToolCommand,
};
use crate::scene::{LengthUnit, LightUnits};

macro_rules! gizmo_mode {
    ($name:literal, $label:literal, $key:expr, $mode:ident) => {
        action(Group::Edit, $name, $label, &[plain($key)], |context| {
            Some(
                ToolCommand::SetGizmo(GizmoSettings {
                    mode: Mode::$mode,
                    is_hidden: false,
                    ..context.gizmo
                })
                .into(),
            )
        })
    };
}

macro_rules! tool {
    ($name:literal, $label:literal, $key:expr, $tool:ident $(($kind:expr))?) => {
        action(Group::Add, $name, $label, &[shift($key)], |context| {
            let tool = Tool::$tool $(($kind))?;
            Some(ToolCommand::SetTool(if context.tool == tool { Tool::Select } else { tool }).into())
        })
    };
}

macro_rules! unit {
    ($name:literal, $label:literal, $unit:ident) => {
        action(Group::Edit, $name, $label, &[], |_| {
            Some(SettingsEdit::SetUnit(LengthUnit::$unit).into())
        })
    };
}

macro_rules! light_units {
    ($name:literal, $label:literal, $units:ident) => {
        action(Group::Edit, $name, $label, &[], |_| {
            Some(SettingsEdit::SetLightUnits(LightUnits::$units).into())
        })
    };
}

/// The menu *File*.
pub const FILE: &[Action] = &[
    action(Group::File, "new", "New scene", &[command(Key::N)], |_| {
        Some(FileCommand::NewScene.into())
    }),
    action(Group::File, "start-page", "Start page", &[], |_| {
        Some(ShellCommand::ShowSheet(Sheet::Start).into())
    }),
    action(Group::File, "open", "Open…", &[command(Key::O)], |_| {
        Some(FileCommand::ShowDialog(FileDialogKind::OpenScene).into())
    }),
    action(
        Group::File,
        "reload",
        "Reload, keeping edits",
        &[plain(Key::F5)],
        |_| Some(FileCommand::ReloadScene.into()),
    ),
    action(Group::File, "revert", "Revert to the file", &[], |context| {
        context.can_revert.then_some(Command::from(FileCommand::RevertScene))
    }),
    action(Group::File, "recover", "Recover…", &[], |_| {
        Some(ShellCommand::ShowRecovery.into())
    }),
    action(Group::File, "import", "Import…", &[command(Key::I)], |_| {
        Some(FileCommand::ShowDialog(FileDialogKind::Import).into())
    }),
    action(Group::File, "missing-files", "Missing files…", &[], |context| {
        let list = Command::Shell(ShellCommand::ShowSheet(Sheet::Missing));
        context.has_missing.then_some(list)
    }),
    action(Group::File, "save", "Save", &[command(Key::S)], |_| {
        Some(FileCommand::Save.into())
    }),
    action(Group::File, "save-as", "Save as…", &[command_shift(Key::S)], |_| {
        Some(FileCommand::ShowDialog(FileDialogKind::SaveScene).into())
    }),
    action(Group::File, "export", "Export to glTF…", &[], |_| {
        Some(FileCommand::ShowDialog(FileDialogKind::ExportScene).into())
    }),
    action(Group::File, "bake-lightmaps", "Bake lightmaps…", &[], |_| {
        Some(ShellCommand::ShowSheet(Sheet::Bake).into())
    }),
    action(Group::File, "stop-bake", "Stop the bake", &[], |_| {
        Some(BakeCommand::Stop.into())
    }),
    action(Group::File, "discard-bake", "Discard the bake", &[], |_| {
        Some(BakeCommand::Discard.into())
    }),
    action(Group::File, "save-image", "Save image…", &[plain(Key::F12)], |_| {
        Some(FileCommand::ShowDialog(FileDialogKind::SaveImage).into())
    }),
    action(
        Group::File,
        "keep-picture",
        "Keep the picture to resume it",
        &[],
        |_| Some(KeptPicture::Keep.into()),
    ),
    action(
        Group::File,
        "continue-picture",
        "Resume the kept picture",
        &[],
        |context| context.with_kept_picture(KeptPicture::Continue),
    ),
    action(
        Group::File,
        "discard-picture",
        "Remove the kept picture",
        &[],
        |context| context.with_kept_picture(KeptPicture::Discard),
    ),
    action(Group::File, "quit", "Quit", &[command(Key::Q)], |_| {
        Some(FileCommand::Quit.into())
    }),
];

/// The menu *Edit*.
pub const EDIT: &[Action] = &[
    action(Group::Edit, "undo", "Undo", &[command(Key::Z)], |_| {
        Some(HistoryCommand::Undo.into())
    }),
    action(
        Group::Edit,
        "redo",
        "Redo",
        &[command_shift(Key::Z), command(Key::Y)],
        |_| Some(HistoryCommand::Redo.into()),
    ),
    action(Group::Edit, "duplicate", "Duplicate", &[command(Key::D)], |context| {
        context.with_selection(SceneEdit::Duplicate)
    }),
    action(Group::Edit, "delete", "Delete", &[plain(Key::Delete)], |context| {
        context.with_selection(SceneEdit::Delete)
    }),
    action(Group::Edit, "group", "Group", &[command(Key::G)], |context| {
        context.with_selection(OutlineEdit::Group)
    }),
    action(Group::Edit, "ungroup", "Ungroup", &[command_shift(Key::G)], |context| {
        context.with_selection(OutlineEdit::Ungroup)
    }),
    action(
        Group::Edit,
        "select-group",
        "Select the group",
        &[shift(Key::G)],
        |context| context.with_selection(SelectionCommand::SelectGroup),
    ),
    action(
        Group::Edit,
        "select-all",
        "Select everything",
        &[command(Key::A)],
        |_| Some(SelectionCommand::SelectAll.into()),
    ),
    action(
        Group::Edit,
        "select-same-material",
        "Select everything of the same material",
        &[],
        |context| context.with_selection(SelectionCommand::SelectAlike(Alike::Material)),
    ),
    action(
        Group::Edit,
        "select-same-type",
        "Select everything of the same type",
        &[],
        |context| context.with_selection(SelectionCommand::SelectAlike(Alike::Type)),
    ),
    action(
        Group::Edit,
        "select-none",
        "Select nothing",
        &[plain(Key::Escape)],
        |context| match context.tool {
            Tool::Select => context.with_selection(SelectionCommand::Select(Vec::new(), Extend::Replace)),
            _ => Some(ToolCommand::SetTool(Tool::Select).into()),
        },
    ),
    action(Group::Edit, "hide", "Hide", &[plain(Key::H)], |context| {
        context.with_selection(OutlineEdit::Hide(context.selection.entities().to_vec(), true))
    }),
    action(
        Group::Edit,
        "hide-others",
        "Hide the others",
        &[command(Key::H)],
        |context| context.with_selection(OutlineEdit::HideOthers),
    ),
    action(Group::Edit, "show-all", "Show everything", &[alt(Key::H)], |_| {
        Some(OutlineEdit::ShowAll.into())
    }),
    gizmo_mode!("gizmo-move", "Move with the gizmo", Key::G, Move),
    gizmo_mode!("gizmo-rotate", "Rotate with the gizmo", Key::R, Rotate),
    gizmo_mode!("gizmo-scale", "Scale with the gizmo", Key::T, Scale),
    action(Group::Edit, "gizmo-hide", "Select without handles", &[], |context| {
        Some(
            ToolCommand::SetGizmo(GizmoSettings {
                is_hidden: true,
                ..context.gizmo
            })
            .into(),
        )
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
            Some(ToolCommand::SetGizmo(settings).into())
        },
    ),
    unit!("unit-none", "Unit: none", None),
    unit!("unit-m", "Unit: metres", Metre),
    unit!("unit-cm", "Unit: centimetres", Centimetre),
    unit!("unit-mm", "Unit: millimetres", Millimetre),
    unit!("unit-in", "Unit: inches", Inch),
    unit!("unit-ft", "Unit: feet", Foot),
    light_units!("light-units-radiometric", "Light: watts and radiance", Radiometric),
    light_units!(
        "light-units-photometric",
        "Light: lumens, candela, lux and nits",
        Photometric
    ),
];

/// The menu *Add*.
pub const ADD: &[Action] = &[
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
    action(Group::Add, "add-gableroof", "Gable roof", &[], |_| {
        Some(addition(AdditionKind::Solid("gableroof")))
    }),
    action(Group::Add, "add-hiproof", "Hip roof", &[], |_| {
        Some(addition(AdditionKind::Solid("hiproof")))
    }),
    action(Group::Add, "add-shedroof", "Shed roof", &[], |_| {
        Some(addition(AdditionKind::Solid("shedroof")))
    }),
    action(Group::Add, "add-fog", "Fog in the whole scene", &[], |_| {
        Some(addition(AdditionKind::Fog))
    }),
    action(Group::Add, "add-fog-box", "Fog box", &[], |_| {
        Some(addition(AdditionKind::FogBox))
    }),
    action(Group::Add, "fill-fog", "Fill with fog", &[], |context| {
        filled(context, Filling::Fog)
    }),
    action(Group::Add, "fill-smoke", "Fill with smoke", &[], |context| {
        filled(context, Filling::Smoke)
    }),
    tool!("draw-box", "Draw a box", Key::B, Draw(BlockKind::Box)),
    tool!("draw-floor", "Draw a floor", Key::F, Draw(BlockKind::Floor)),
    tool!("draw-wall", "Draw a wall", Key::L, Draw(BlockKind::Wall)),
    tool!("cut-door", "Cut a door", Key::O, Cut(OpeningKind::Door)),
    tool!("cut-window", "Cut a window", Key::I, Cut(OpeningKind::Window)),
    action(Group::Add, "cover-roof", "Roof over the selection", &[], |context| {
        context.with_selection(SceneEdit::Cover("gableroof"))
    }),
    tool!("push-faces", "Push and pull faces", Key::P, Push),
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
        Some(FileCommand::ShowDialog(FileDialogKind::OpenEnvironment).into())
    }),
    action(Group::Add, "add-ies", "IES lamp…", &[], |_| {
        Some(FileCommand::ShowDialog(FileDialogKind::Import).into())
    }),
    action(Group::Add, "add-sunsky", "Sun and sky", &[], |_| {
        Some(addition(AdditionKind::Emitter("sunsky")))
    }),
    action(Group::Add, "add-reflectionprobe", "Reflection probe", &[], |_| {
        Some(addition(AdditionKind::Emitter("reflectionprobe")))
    }),
    action(Group::Add, "add-irradiancevolume", "Irradiance volume", &[], |_| {
        Some(addition(AdditionKind::Emitter("irradiancevolume")))
    }),
    action(Group::Add, "add-illuminancemeter", "Measuring point", &[], |_| {
        Some(addition(AdditionKind::Emitter("illuminancemeter")))
    }),
    action(Group::Add, "add-illuminancegrid", "Measuring grid", &[], |_| {
        Some(addition(AdditionKind::Emitter("illuminancegrid")))
    }),
    action(Group::Add, "add-markerpoint", "Marker", &[], |_| {
        Some(addition(AdditionKind::Emitter("markerpoint")))
    }),
    action(Group::Add, "add-markerbox", "Box marker", &[], |_| {
        Some(addition(AdditionKind::Emitter("markerbox")))
    }),
    action(Group::Add, "add-markersphere", "Sphere marker", &[], |_| {
        Some(addition(AdditionKind::Emitter("markersphere")))
    }),
    action(Group::Add, "add-markerpath", "Path", &[], |_| {
        Some(addition(AdditionKind::Emitter("markerpath")))
    }),
    action(Group::Add, "add-camera", "Camera at the view", &[], |_| {
        Some(addition(AdditionKind::Camera))
    }),
    action(Group::Add, "add-turntable", "Turntable", &[], |_| {
        Some(TimeEdit::AddTurntable.into())
    }),
];

/// The menu *Render*.
pub const RENDER: &[Action] = &[
    action(Group::Render, "focus", "Focus by a click", &[], |_| {
        Some(ToolCommand::SetTool(Tool::Focus).into())
    }),
    action(Group::Render, "draw-region", "Draw the region to render", &[], |_| {
        Some(ToolCommand::SetTool(Tool::Region).into())
    }),
    action(Group::Render, "pause", "Pause", &[plain(Key::Space)], |context| {
        Some(RenderCommand::SetPaused(!context.paused).into())
    }),
    action(Group::Render, "restart", "Start again", &[shift(Key::R)], |_| {
        Some(RenderCommand::Restart.into())
    }),
    action(Group::Render, "render-full", "Render full film", &[], |_| {
        Some(RenderCommand::RenderFull(FullFilm::default()).into())
    }),
    action(Group::Render, "stop-full", "Stop the full film", &[], |_| {
        Some(RenderCommand::StopFull.into())
    }),
    action(Group::Render, "denoise", "Denoise", &[plain(Key::N)], |context| {
        Some(DisplayCommand::SetDenoising(!context.denoising).into())
    }),
    action(Group::Render, "keep-limits", "Save limits in the camera", &[], |_| {
        Some(CameraEdit::KeepLimits.into())
    }),
    action(Group::Render, "bake-lights", "Bake the light mix", &[], |_| {
        Some(SettingsEdit::BakeLights.into())
    }),
    action(Group::Render, "take-snapshot", "Take snapshot", &[], |_| {
        Some(DisplayCommand::TakeSnapshot.into())
    }),
    action(Group::Render, "measure", "Measure against snapshot", &[], |_| {
        Some(DisplayCommand::Measure.into())
    }),
];

/// The menu *Window*.
pub const WINDOW: &[Action] = &[
    action(Group::Window, "panels", "Panels", &[command(Key::B)], |context| {
        Some(ShellCommand::ShowPanels(!context.panels_shown).into())
    }),
    action(Group::Window, "palette", "Commands…", &[command(Key::P)], |_| {
        Some(ShellCommand::ShowSheet(Sheet::Palette).into())
    }),
    action(
        Group::Window,
        "shortcuts",
        "Keys and mouse",
        &[plain(Key::F1), shift(Key::Questionmark)],
        |_| Some(ShellCommand::ShowSheet(Sheet::Shortcuts).into()),
    ),
    action(
        Group::Window,
        "preferences",
        "Preferences…",
        &[command(Key::Comma)],
        |_| Some(ShellCommand::ShowSheet(Sheet::Preferences).into()),
    ),
    action(Group::Window, "choose-keys", "Choose keys…", &[], |_| {
        Some(ShellCommand::ShowSheet(Sheet::Keys).into())
    }),
    action(Group::Window, "tutorial", "Tutorial", &[], |_| {
        Some(ShellCommand::ShowTutorial(Some(0)).into())
    }),
    action(Group::Window, "reset-layout", "Reset layout", &[], |_| {
        Some(ShellCommand::ResetLayout.into())
    }),
    action(Group::Window, "full-screen", "Full screen", &[plain(Key::F11)], |_| {
        Some(ShellCommand::ToggleFullScreen.into())
    }),
];

fn filled(context: &ActionContext, with: Filling) -> Option<Command> {
    let shapes = context.selection.entities().to_vec();
    context.with_selection(MediumEdit::Fill { shapes, with })
}

fn addition(kind: AdditionKind) -> Command {
    Command::from(SceneEdit::Add(kind.into()))
}
