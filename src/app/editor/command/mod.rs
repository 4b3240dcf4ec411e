//! What the user can ask for: [`Command`], and the plain values that commands carry. Imports no other module of the editor.

pub mod addition;
pub mod axis_view;
pub mod bvh_overlay;
pub mod compare_view;
pub mod conversion;
pub mod display;
pub mod dragged;
pub mod error;
pub mod file_access;
pub mod gizmo_settings;
pub mod inspected_paths;
pub mod light_mix;
pub mod material_tree;
pub mod panel;
pub mod preferences;
pub mod presets;
pub mod recovery_offer;
pub mod selection;
pub mod shell;
pub mod stored_view;
pub mod tool;

use std::path::PathBuf;

use bevy::math::Affine3A;
use bevy::prelude::{Entity, Rect, Vec2};

use crate::scene::write::OnChange;
use crate::scene::{
    AccelMethod, AreaLight, Emitter, Film, IntegratorSettings, Material, SamplerSettings, Sensor, Shape, SquarePath,
};
use addition::Addition;
use axis_view::AxisView;
use bvh_overlay::BvhOverlay;
use compare_view::CompareView;
use display::DisplaySettings;
use gizmo_settings::GizmoSettings;
use inspected_paths::InspectedPaths;
use light_mix::LightMix;
use material_tree::MaterialTree;
use presets::Preset;
use selection::Extend;
use shell::ShellCommand;
use tool::Tool;

#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    // The file.
    NewScene,
    OpenScene(PathBuf),
    /// Reads the file of the scene again; edits stay.
    ReloadScene,
    /// Back to what the file says.
    RevertScene,
    /// To the file that is open; asks for one where there is none.
    Save,
    /// The scene is that file from then on.
    SaveScene(PathBuf),
    /// The same where others changed the file since it was read.
    SaveChanged(PathBuf, OnChange),
    /// The picture as shown for PNG, the linear radiance for EXR and HDR.
    SaveImage(PathBuf),
    /// Adds what a file holds: a mesh, a scene, a glTF, or a picture as environment.
    Import(PathBuf),
    ShowDialog(FileDialogKind),
    Quit,

    // The history.
    Undo,
    Redo,
    /// Back or forward to where so many steps are done.
    GoTo(usize),

    // What is selected.
    Select(Vec<Entity>, Extend),
    SelectAll,
    /// What is seen at a place of the picture, (0, 0) top left, (1, 1) bottom right.
    Pick(Vec2, Extend),

    // From where it is looked at. None of it edits the scene, except `MoveCameraToView`.
    FrameSelection,
    FrameAll,
    /// Flies there: world from camera.
    MoveView(Affine3A),
    /// Renders from this sensor, from where it stands.
    LookThrough(Entity),
    /// Puts the sensor in use to where the view is.
    MoveCameraToView,
    /// Along an axis of the world, onto the selection or what is ahead.
    LookAlong(AxisView),
    /// In perspective or not, with what is in the middle as large.
    SwitchProjection,
    /// Keeps the view under a number from 1 to 9.
    StoreView(usize),
    /// Goes back to a view that was kept.
    RecallView(usize),
    /// Flying speed as a multiple of the one that suits the scene's size.
    SetSpeed(f32),

    // The scene.
    Add(Addition),
    Delete,
    Duplicate,
    /// As XML text, to the clipboard.
    Copy,
    Cut,
    /// Adds the plugins of an XML text.
    Paste(String),
    /// An empty name is none.
    Rename(Entity, String),
    /// Puts things, in this order, before another of their kind, or last.
    Reorder {
        moved: Vec<Entity>,
        before: Option<Entity>,
    },
    /// Puts the selection into a folder of its own.
    Group,
    /// Into the folder of this path, or out of all.
    PutInto {
        things: Vec<Entity>,
        folder: Option<String>,
    },
    /// Hides these, or shows them again.
    Hide(Vec<Entity>, bool),
    /// Hides all shapes and lights but the selected.
    HideOthers,
    ShowAll,
    Lock(Vec<Entity>, bool),
    /// The selection by a step along an axis of the world, the one that looks most like this in the picture.
    Nudge(Direction),
    /// Each selected thing down onto what is below it.
    Drop,
    /// World from local of several things at once.
    Transform(Vec<(Entity, Affine3A)>),
    SetShape(Entity, Shape),
    SetMaterial(Entity, Box<Material>),
    /// Another picture for a texture of a material or a light, or a picture where there is none.
    SetPicture {
        owner: Entity,
        parameter: &'static str,
        place: SquarePath,
        path: PathBuf,
    },
    /// The shapes get this material, or none of their own.
    UseMaterial {
        shapes: Vec<Entity>,
        material: Option<Entity>,
    },
    /// The shape that is seen at a place of the picture, as [`Command::Pick`] has it, gets the material.
    DropMaterial {
        material: Entity,
        at: Vec2,
    },
    /// A new grey material for this shape alone.
    GiveMaterial {
        shape: Entity,
    },
    /// Materials, or those of shapes, become the tree.
    BuildMaterial {
        targets: Vec<Entity>,
        tree: Box<MaterialTree>,
    },
    /// The shapes get a material of the library: one like it that is called like it already, or a new one.
    UsePreset {
        preset: Box<Preset>,
        shapes: Vec<Entity>,
    },
    /// So does the shape that is seen at a place of the picture, as [`Command::Pick`] has it.
    DropPreset {
        preset: Box<Preset>,
        at: Vec2,
    },
    SetAreaLight(Entity, Option<AreaLight>),
    SetEmitter(Entity, Emitter),
    SetSensor(Entity, Sensor),
    /// The camera in use becomes sharp at what is seen there, (0, 0) top left, (1, 1) bottom right; a pinhole becomes a thin lens.
    FocusAt(Vec2),
    SetFilm(Entity, Film),
    /// The edit, which names one thing, and the same change to everything selected that is of the same sort.
    OnSelection(Box<Command>),
    SetIntegrator(IntegratorSettings),
    SetSampler(SamplerSettings),
    SetAccel(AccelMethod),
    /// Multiplies the lights by their strengths and colours in the mix, which is neutral then.
    BakeLights,

    // Rendering and display.
    SetPaused(bool),
    Restart,
    SetTargetSamples(u32),
    /// Seconds of rendering; None is no limit.
    SetTimeLimit(Option<f32>),
    /// Noise of the picture relative to its brightness; None is no limit.
    SetNoiseTarget(Option<f32>),
    /// The part of the picture that gets samples, (0, 0) top left, (1, 1) bottom right; None is all of it.
    SetRegion(Option<Rect>),
    SetResolutionScale(f32),
    /// Thirds of the picture by bsdf sampling, by light sampling, and by both.
    SetStrategySplit(bool),
    SetDisplay(DisplaySettings),
    /// The exposure that brings the picture to middle grey.
    ExposeAutomatically,
    /// Keeps the light of every light by itself, for mixing.
    SetLightLayers(bool),
    SetLightMix(LightMix),
    /// Keeps the picture for comparison.
    TakeSnapshot,
    SetCompareView(CompareView),
    /// Figures of the picture against the snapshot.
    Measure,
    SetOverlay(BvhOverlay),
    SetTool(Tool),
    ShowSafeFrame(bool),
    /// The paths of a pixel, or none.
    InspectPaths(Option<InspectedPaths>),
    SetGizmo(GizmoSettings),
    Denoise,
    /// Back to the picture as sampled.
    DropDenoised,
    ShowPanels(bool),
    Shell(ShellCommand),
}

/// Ways to go on the ground, as the camera sees it, and up and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    Left,
    Right,
    Ahead,
    Back,
    Up,
    Down,
}

/// What a command does to the history and the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Nothing of the scene.
    None,
    /// The picture is begun anew, but the scene stays as it is.
    View,
    /// A step of the history.
    Edit,
    /// A step, but several of one drag are one.
    Drag,
}

impl Command {
    pub fn effect(&self) -> Effect {
        match self {
            Self::OnSelection(command) => command.effect(),
            Self::Transform(_)
            | Self::SetShape(..)
            | Self::SetMaterial(..)
            | Self::SetAreaLight(..)
            | Self::SetEmitter(..)
            | Self::SetSensor(..)
            | Self::SetFilm(..)
            | Self::SetIntegrator(_)
            | Self::SetSampler(_) => Effect::Drag,
            Self::Import(_)
            | Self::MoveCameraToView
            | Self::Add(_)
            | Self::Delete
            | Self::Duplicate
            | Self::Cut
            | Self::Paste(_)
            | Self::Rename(..)
            | Self::Reorder { .. }
            | Self::Group
            | Self::PutInto { .. }
            | Self::Hide(..)
            | Self::HideOthers
            | Self::ShowAll
            | Self::Lock(..)
            | Self::Nudge(_)
            | Self::Drop
            | Self::SetPicture { .. }
            | Self::UseMaterial { .. }
            | Self::GiveMaterial { .. }
            | Self::FocusAt(_)
            | Self::BuildMaterial { .. }
            | Self::DropMaterial { .. }
            | Self::UsePreset { .. }
            | Self::DropPreset { .. }
            | Self::SetAccel(_)
            | Self::BakeLights => Effect::Edit,
            Self::MoveView(_)
            | Self::FrameSelection
            | Self::FrameAll
            | Self::LookThrough(_)
            | Self::LookAlong(_)
            | Self::SwitchProjection
            | Self::RecallView(_)
            | Self::SetResolutionScale(_)
            | Self::SetStrategySplit(_)
            | Self::SetLightLayers(_)
            | Self::Undo
            | Self::Redo
            | Self::GoTo(_)
            | Self::Restart => Effect::View,
            Self::NewScene
            | Self::OpenScene(_)
            | Self::ReloadScene
            | Self::RevertScene
            | Self::Save
            | Self::SaveScene(_)
            | Self::SaveChanged(..)
            | Self::SaveImage(_)
            | Self::ShowDialog(_)
            | Self::Quit
            | Self::Select(..)
            | Self::SelectAll
            | Self::Pick(..)
            | Self::SetSpeed(_)
            | Self::StoreView(_)
            | Self::SetGizmo(_)
            | Self::Copy
            | Self::SetPaused(_)
            | Self::SetTargetSamples(_)
            | Self::SetTimeLimit(_)
            | Self::SetNoiseTarget(_)
            | Self::SetRegion(_)
            | Self::ExposeAutomatically
            | Self::SetLightMix(_)
            | Self::TakeSnapshot
            | Self::SetCompareView(_)
            | Self::Measure
            | Self::SetDisplay(_)
            | Self::SetOverlay(_)
            | Self::SetTool(_)
            | Self::ShowSafeFrame(_)
            | Self::InspectPaths(_)
            | Self::Denoise
            | Self::DropDenoised
            | Self::ShowPanels(_)
            | Self::Shell(_) => Effect::None,
        }
    }

    /// What the history calls an edit; the name of what it is about follows where there is one.
    pub fn label(&self) -> &'static str {
        match self {
            Self::OnSelection(command) => command.label(),
            Self::Import(_) => "Import",
            Self::MoveCameraToView => "Move camera to view",
            Self::Add(_) => "Add",
            Self::Delete => "Delete",
            Self::Duplicate => "Duplicate",
            Self::Cut => "Cut",
            Self::Paste(_) => "Paste",
            Self::Rename(..) => "Rename",
            Self::Reorder { .. } => "Reorder",
            Self::Group => "Group",
            Self::PutInto { .. } => "Put into folder",
            Self::Hide(_, true) => "Hide",
            Self::Hide(_, false) | Self::ShowAll => "Show",
            Self::HideOthers => "Hide others",
            Self::Lock(_, true) => "Lock",
            Self::Lock(_, false) => "Unlock",
            Self::Transform(_) | Self::Nudge(_) => "Move",
            Self::Drop => "Drop",
            Self::SetShape(..) => "Edit shape",
            Self::SetMaterial(..) => "Edit material",
            Self::SetPicture { .. } => "Choose picture",
            Self::UseMaterial { .. } | Self::DropMaterial { .. } => "Assign material",
            Self::UsePreset { .. } | Self::DropPreset { .. } => "Assign preset",
            Self::GiveMaterial { .. } => "New material",
            Self::BuildMaterial { .. } => "Make material",
            Self::SetAreaLight(..) | Self::SetEmitter(..) => "Edit light",
            Self::SetSensor(..) => "Edit camera",
            Self::FocusAt(_) => "Focus",
            Self::SetFilm(..) => "Edit film",
            Self::SetIntegrator(_) => "Edit light transport",
            Self::SetSampler(_) => "Edit sampler",
            Self::SetAccel(_) => "Edit hierarchy",
            Self::BakeLights => "Bake light mix",
            _ => "",
        }
    }

    /// The entities that an edit names; empty for those that are about the selection or nothing in particular.
    pub(crate) fn targets(&self) -> Vec<Entity> {
        match self {
            Self::OnSelection(command) => command.targets(),
            Self::Transform(poses) => poses.iter().map(|(entity, _)| *entity).collect(),
            Self::SetShape(entity, _)
            | Self::SetMaterial(entity, _)
            | Self::SetAreaLight(entity, _)
            | Self::SetEmitter(entity, _)
            | Self::SetSensor(entity, _)
            | Self::SetFilm(entity, _)
            | Self::Rename(entity, _)
            | Self::GiveMaterial { shape: entity }
            | Self::DropMaterial { material: entity, .. }
            | Self::SetPicture { owner: entity, .. } => vec![*entity],
            Self::Hide(entities, _)
            | Self::Lock(entities, _)
            | Self::UseMaterial { shapes: entities, .. }
            | Self::UsePreset { shapes: entities, .. }
            | Self::PutInto { things: entities, .. }
            | Self::BuildMaterial { targets: entities, .. }
            | Self::Reorder { moved: entities, .. } => entities.clone(),
            _ => Vec::new(),
        }
    }

    /// Whether it gives one thing a value that others of its sort have, too.
    pub(crate) fn is_about_one(&self) -> bool {
        self.effect() == Effect::Drag && !self.targets().is_empty()
    }

    /// Whether it is one of many that follow each other while the view or something in it moves.
    pub(crate) fn moves_picture(&self) -> bool {
        matches!(self, Self::MoveView(_)) || self.effect() == Effect::Drag
    }

    /// Whether it is about the picture's very pixels.
    pub(crate) fn keeps_picture(&self) -> bool {
        matches!(self, Self::SaveImage(_) | Self::TakeSnapshot | Self::Measure)
    }

    /// Whether the picture as a rule is begun anew by it.
    pub(crate) fn restarts_picture(&self) -> bool {
        self.effect() != Effect::None
            && !matches!(
                self,
                Self::Rename(..) | Self::PutInto { .. } | Self::Group | Self::Lock(..)
            )
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileDialogKind {
    OpenScene,
    SaveScene,
    SaveImage,
    Import,
    /// A picture of all directions, to be the scene's light from everywhere.
    OpenEnvironment,
    /// The picture of the texture that this parameter of the material or the light is, or that is at a place within it.
    OpenPicture {
        owner: Entity,
        parameter: &'static str,
        place: SquarePath,
    },
}
