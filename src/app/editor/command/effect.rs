//! What a command does to the history and to the picture.

use super::Command;
use super::blocking::Reshaping;
use super::kept_picture::KeptPicture;
use super::shell::ShellCommand;
use crate::scene::KeyEdit;

/// The effect of a command on the history and the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// The command changes nothing in the scene.
    None,
    /// The command begins the picture anew, but leaves the scene as it is.
    View,
    /// The command is a step of the history.
    Edit,
    /// The command is a step of the history, but several of one drag are one step.
    Drag,
}

impl Command {
    /// Whether the command is recorded in the history, and whether it begins the picture anew.
    pub fn effect(&self) -> Effect {
        match self {
            Self::OnSelection(command) => command.effect(),
            Self::Transform(_)
            | Self::Turn(..)
            | Self::SetShape(..)
            | Self::SetMaterial(..)
            | Self::SetMedium(..)
            | Self::PlaceTextures { .. }
            | Self::SetAreaLight(..)
            | Self::SetEmitter(..)
            | Self::SetSensor(..)
            | Self::SetFilm(..)
            | Self::SetIntegrator(_)
            | Self::SetSampler(_)
            | Self::Key(_, KeyEdit::Move { .. })
            | Self::Reshape(.., Reshaping::Push) => Effect::Drag,
            Self::Import(_)
            | Self::UseFile(_)
            | Self::FindFile { .. }
            | Self::MoveCameraToView
            | Self::Add(_)
            | Self::Build(_)
            | Self::Reshape(.., Reshaping::Cut)
            | Self::Delete
            | Self::Duplicate
            | Self::MakeSeries(_)
            | Self::Align(..)
            | Self::Distribute(..)
            | Self::FitToView(_)
            | Self::Cut
            | Self::Paste(_)
            | Self::Rename(..)
            | Self::Reorder { .. }
            | Self::Group
            | Self::Ungroup
            | Self::PutInto { .. }
            | Self::Hide(..)
            | Self::HideOthers
            | Self::ShowAll
            | Self::Lock(..)
            | Self::Nudge(_)
            | Self::Drop
            | Self::SnapToGrid
            | Self::SetPicture { .. }
            | Self::ProjectTextures { .. }
            | Self::UseMaterial { .. }
            | Self::GiveMaterial { .. }
            | Self::UseMedium { .. }
            | Self::GiveMedium { .. }
            | Self::Fill { .. }
            | Self::FocusAt(_)
            | Self::BuildMaterial { .. }
            | Self::DropMaterial { .. }
            | Self::UsePreset { .. }
            | Self::DropPreset { .. }
            | Self::SetUnit(_)
            | Self::SetAccel(_)
            | Self::Key(..)
            | Self::AddTurntable
            | Self::BakeLights
            | Self::KeepLimits => Effect::Edit,
            Self::MoveView(_)
            | Self::FrameSelection
            | Self::FrameAll
            | Self::LookThrough(_)
            | Self::LookAlong(_)
            | Self::SwitchProjection
            | Self::RecallView(_)
            | Self::SetResolutionScale(_)
            | Self::SetResolution(_)
            | Self::RenderFull(_)
            | Self::StopFull
            | Self::SetStrategySplit(_)
            | Self::SetPathIsAuto(_)
            | Self::SetSeeing(_)
            | Self::CutOpen
            | Self::Isolate(_)
            | Self::SetLightLayers(_)
            | Self::SetTime(_)
            | Self::StepTime(_)
            | Self::Undo
            | Self::Redo
            | Self::GoTo(_)
            | Self::KeptPicture(KeptPicture::Continue)
            | Self::Restart => Effect::View,
            Self::NewScene
            | Self::OpenScene(_)
            | Self::ReloadScene
            | Self::RevertScene
            | Self::Save
            | Self::SaveScene(_)
            | Self::SaveChanged(..)
            | Self::ExportScene(_)
            | Self::Bake(_)
            | Self::SaveImage(_)
            | Self::KeptPicture(_)
            | Self::ShowDialog(_)
            | Self::Quit
            | Self::Select(..)
            | Self::SelectAll
            | Self::SelectGroup
            | Self::Pick(..)
            | Self::TurnAbout(_)
            | Self::SetSpeed(_)
            | Self::StoreView(_)
            | Self::SetGizmo(_)
            | Self::Copy
            | Self::SetPaused(_)
            | Self::SetTargetSamples(_)
            | Self::SetTimeLimit(_)
            | Self::SetNoiseTarget(_)
            | Self::SetAdaptive(_)
            | Self::SetRegion(_)
            | Self::ExposeAutomatically
            | Self::SetLightMix(_)
            | Self::TakeSnapshot
            | Self::SetCompareView(_)
            | Self::Measure
            | Self::SetDisplay(_)
            | Self::SetEnlarging(_)
            | Self::SetOverlay(_)
            | Self::SetTool(_)
            | Self::ShowSafeFrame(_)
            | Self::SetGrid(_)
            | Self::ShowDimensions(_)
            | Self::AddRuler(_)
            | Self::ClearRulers
            | Self::InspectPaths(_)
            | Self::SetDenoising(_)
            | Self::ShowPanels(_)
            | Self::SetPlaying(_)
            | Self::SetTimeline(_)
            | Self::ShowTimeline(_)
            | Self::Shell(_) => Effect::None,
        }
    }

    /// Whether the command gives one thing a value that others of its sort have, too.
    pub(crate) fn is_about_one(&self) -> bool {
        self.effect() == Effect::Drag && !self.targets().is_empty()
    }

    /// Whether the command is one of many that follow each other while the view or something in it moves.
    pub(crate) fn moves_picture(&self) -> bool {
        // What is known of the picture is multiplied by what lights become stronger.
        let is_about_light = matches!(self, Self::SetAreaLight(..) | Self::SetEmitter(..));
        matches!(self, Self::MoveView(_) | Self::SetTime(_)) || self.effect() == Effect::Drag && !is_about_light
    }

    /// Whether the command is about single pixels of the picture.
    pub(crate) fn keeps_picture(&self) -> bool {
        matches!(
            self,
            Self::SaveImage(_)
                | Self::TakeSnapshot
                | Self::Measure
                | Self::KeptPicture(KeptPicture::Keep | KeptPicture::KeepAndQuit)
        )
    }

    /// Whether the command saves the scene to its file or to another one.
    pub(crate) fn saves(&self) -> bool {
        matches!(self, Self::Save | Self::SaveScene(_) | Self::SaveChanged(..))
    }

    /// Whether edits that no file has are lost with the command.
    pub(crate) fn loses_edits(&self) -> bool {
        matches!(
            self,
            Self::NewScene
                | Self::OpenScene(_)
                | Self::RevertScene
                | Self::Quit
                | Self::Shell(ShellCommand::Recover(_))
        )
    }

    /// Whether the command as a rule begins the picture anew.
    pub(crate) fn restarts_picture(&self) -> bool {
        self.effect() != Effect::None
            && !matches!(
                self,
                Self::Rename(..)
                    | Self::PutInto { .. }
                    | Self::Group
                    | Self::Ungroup
                    | Self::Lock(..)
                    | Self::SetUnit(_)
            )
    }
}
