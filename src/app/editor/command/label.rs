//! What the history calls an edit, and the things that the edit names.

use bevy::prelude::Entity;

use super::Command;
use super::asset_kind::AssetKind;
use super::blocking::{BlockKind, Reshaping};
use crate::scene::KeyEdit;

impl Command {
    /// The label of an edit in the history. The names of its things follow there.
    pub fn label(&self) -> &'static str {
        match self {
            Self::OnSelection(command) => command.label(),
            Self::Import(_) => "Import",
            Self::UseFile(file) => match AssetKind::of(&file.path) {
                Some(AssetKind::Picture | AssetKind::Environment) => "Use picture",
                Some(AssetKind::Scene) => "Use file",
                Some(AssetKind::Mesh | AssetKind::Volume) | None => "Import",
            },
            Self::FindFile { .. } => "Find files",
            Self::MoveCameraToView => "Move camera to view",
            Self::Add(_) => "Add",
            Self::Build(block) => match block.kind {
                BlockKind::Box => "Draw box",
                BlockKind::Floor => "Draw floor",
                BlockKind::Wall => "Draw wall",
            },
            Self::Reshape(.., Reshaping::Push) => "Push face",
            Self::Reshape(.., Reshaping::Cut) => "Cut opening",
            Self::Delete => "Delete",
            Self::Duplicate => "Duplicate",
            Self::MakeSeries(_) => "Make a series of",
            Self::Align(..) => "Align",
            Self::Distribute(..) => "Distribute",
            Self::FitToView(_) => "Fit to view",
            Self::Cut => "Cut",
            Self::Paste(_) => "Paste",
            Self::Rename(..) => "Rename",
            Self::Reorder { .. } => "Reorder",
            Self::Group => "Group",
            Self::Ungroup => "Ungroup",
            Self::PutInto { .. } => "Put into folder",
            Self::Hide(_, true) => "Hide",
            Self::Hide(_, false) | Self::ShowAll => "Show",
            Self::HideOthers => "Hide others",
            Self::Lock(_, true) => "Lock",
            Self::Lock(_, false) => "Unlock",
            Self::Transform(_) | Self::Turn(..) | Self::Nudge(_) => "Move",
            Self::Drop => "Drop",
            Self::SnapToGrid => "Put onto the grid",
            Self::SetShape(..) => "Edit shape",
            Self::SetMaterial(..) => "Edit material",
            Self::SetPicture { .. } => "Choose picture",
            Self::PlaceTextures { .. } => "Place texture",
            Self::ProjectTextures { .. } => "Project texture",
            Self::UseMaterial { .. } | Self::DropMaterial { .. } => "Assign material",
            Self::UsePreset { .. } | Self::DropPreset { .. } => "Assign material",
            Self::GiveMaterial { .. } => "New material",
            Self::BuildMaterial { .. } => "Make material",
            Self::SetMedium(..) => "Edit medium",
            Self::UseMedium { .. } => "Assign medium",
            Self::GiveMedium { .. } => "New medium",
            Self::Fill { .. } => "Fill",
            Self::SetAreaLight(..) | Self::SetEmitter(..) => "Edit light",
            Self::SetSensor(..) => "Edit camera",
            Self::FocusAt(_) => "Focus",
            Self::SetFilm(..) => "Edit film",
            Self::SetIntegrator(_) => "Edit light transport",
            Self::SetSampler(_) => "Edit sampler",
            Self::SetUnit(_) => "Set unit of length",
            Self::SetAccel(_) => "Edit hierarchy",
            Self::BakeLights => "Bake light mix",
            Self::KeepLimits => "Keep limits",
            Self::AddTurntable => "Add turntable",
            Self::Key(_, KeyEdit::Set) => "Set key of",
            Self::Key(_, KeyEdit::Remove) => "Remove key of",
            Self::Key(_, KeyEdit::RemoveAll) => "Remove keys of",
            Self::Key(_, KeyEdit::Move { .. }) => "Move key of",
            Self::Key(_, KeyEdit::Interpolate(_)) => "Set interpolation of",
            _ => "",
        }
    }

    /// The entities that an edit names; empty for edits of the selection or of nothing in particular.
    pub(crate) fn targets(&self) -> Vec<Entity> {
        match self {
            Self::OnSelection(command) => command.targets(),
            Self::Key(targets, _) => {
                let mut things: Vec<Entity> = targets.iter().map(|(thing, _)| *thing).collect();
                things.dedup();
                things
            }
            Self::Transform(poses) => poses.iter().map(|(entity, _)| *entity).collect(),
            Self::SetShape(entity, _)
            | Self::Turn(entity, ..)
            | Self::Reshape(entity, ..)
            | Self::SetMaterial(entity, _)
            | Self::SetMedium(entity, _)
            | Self::GiveMedium { thing: entity, .. }
            | Self::SetAreaLight(entity, _)
            | Self::SetEmitter(entity, _)
            | Self::SetSensor(entity, _)
            | Self::SetFilm(entity, _)
            | Self::Rename(entity, _)
            | Self::GiveMaterial { shape: entity }
            | Self::DropMaterial { material: entity, .. }
            | Self::PlaceTextures { owner: entity, .. }
            | Self::SetPicture { owner: entity, .. } => vec![*entity],
            Self::Hide(entities, _)
            | Self::Lock(entities, _)
            | Self::UseMaterial { shapes: entities, .. }
            | Self::ProjectTextures { shapes: entities, .. }
            | Self::UsePreset { shapes: entities, .. }
            | Self::UseMedium { things: entities, .. }
            | Self::Fill { shapes: entities, .. }
            | Self::PutInto { things: entities, .. }
            | Self::FitToView(entities)
            | Self::BuildMaterial { targets: entities, .. }
            | Self::Reorder { moved: entities, .. } => entities.clone(),
            _ => Vec::new(),
        }
    }
}
