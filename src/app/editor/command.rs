//! What the user can do. A panel, a key, a click and a test all say it with these words; `commands` is where they come true.
//!
//! Commands that edit the scene carry the whole new value, so that applying one twice is the same as once.

use std::path::PathBuf;

use bevy::math::Affine3A;
use bevy::prelude::{Entity, Vec2};

use super::display::DisplaySettings;
use super::overlay::BvhOverlay;
use crate::scene::{
    AccelMethod, AreaLight, Emitter, Film, IntegratorSettings, Material, SamplerSettings, Sensor, Shape,
};

#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    // The file.
    OpenScene(PathBuf),
    ReloadScene,
    SaveScene(PathBuf),
    /// The picture as shown for PNG, the linear radiance for EXR and HDR.
    SaveImage(PathBuf),
    ShowDialog(FileDialogKind),
    Quit,

    // What is looked at, and from where.
    Select(Option<Entity>),
    /// Selects what is seen at a place of the picture, (0, 0) top left, (1, 1) bottom right.
    Pick(Vec2),
    FrameSelection,
    FrameAll,
    /// The pose of the camera in use: world from camera.
    MoveCamera(Affine3A),
    /// Renders from this sensor.
    LookThrough(Entity),
    /// Flying speed as a multiple of the one that suits the scene's size.
    SetSpeed(f32),

    // The scene.
    SetToWorld(Entity, Affine3A),
    SetShape(Entity, Shape),
    SetMaterial(Entity, Box<Material>),
    /// Another picture for a texture of a material or a light.
    SetPicture {
        owner: Entity,
        parameter: &'static str,
        path: PathBuf,
    },
    UseMaterial {
        shape: Entity,
        material: Option<Entity>,
    },
    /// A new grey material for this shape alone.
    GiveMaterial {
        shape: Entity,
    },
    SetAreaLight(Entity, Option<AreaLight>),
    SetEmitter(Entity, Emitter),
    SetSensor(Entity, Sensor),
    SetFilm(Entity, Film),
    SetIntegrator(IntegratorSettings),
    SetSampler(SamplerSettings),
    SetAccel(AccelMethod),

    // Rendering and display.
    SetPaused(bool),
    Restart,
    SetTargetSamples(u32),
    SetResolutionScale(f32),
    SetDisplay(DisplaySettings),
    SetOverlay(BvhOverlay),
    Denoise,
    /// Back to the picture as sampled.
    DropDenoised,
    ShowPanels(bool),
}

impl Command {
    /// Whether the picture as a rule is begun anew by it.
    pub fn restarts_picture(&self) -> bool {
        match self {
            Self::MoveCamera(_)
            | Self::FrameSelection
            | Self::FrameAll
            | Self::LookThrough(_)
            | Self::SetToWorld(..)
            | Self::SetShape(..)
            | Self::SetMaterial(..)
            | Self::SetPicture { .. }
            | Self::UseMaterial { .. }
            | Self::GiveMaterial { .. }
            | Self::SetAreaLight(..)
            | Self::SetEmitter(..)
            | Self::SetSensor(..)
            | Self::SetFilm(..)
            | Self::SetIntegrator(_)
            | Self::SetSampler(_)
            | Self::SetAccel(_)
            | Self::SetResolutionScale(_)
            | Self::Restart => true,
            Self::OpenScene(_)
            | Self::ReloadScene
            | Self::SaveScene(_)
            | Self::SaveImage(_)
            | Self::ShowDialog(_)
            | Self::Quit
            | Self::Select(_)
            | Self::Pick(_)
            | Self::SetSpeed(_)
            | Self::SetPaused(_)
            | Self::SetTargetSamples(_)
            | Self::SetDisplay(_)
            | Self::SetOverlay(_)
            | Self::Denoise
            | Self::DropDenoised
            | Self::ShowPanels(_) => false,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileDialogKind {
    OpenScene,
    SaveScene,
    SaveImage,
    /// The picture of the texture that this parameter of the material or the light is.
    OpenPicture {
        owner: Entity,
        parameter: &'static str,
    },
}
