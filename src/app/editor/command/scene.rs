//! Edits that add entities to the scene and remove them.

use std::path::PathBuf;

use bevy::math::Affine3A;
use bevy::prelude::Entity;

use super::addition::Addition;
use super::arrange::Series;
use super::asset_kind::{AssetKind, FileUse};
use super::blocking::block::Block;
use super::blocking::{BlockKind, Reshaping};
use super::traits::Traits;
use crate::scene::Shape;

/// An edit that adds, copies or removes things, or the files that they name.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneEdit {
    /// Adds the content of a file: a mesh, a scene, a glTF, or a picture as environment.
    Import(PathBuf),
    /// Puts a file into the scene: where it was dropped, or onto the selection.
    UseFile(Box<FileUse>),
    /// Replaces the path of a missing file, and where `others` is true the paths of all other missing files that lie
    /// beside it.
    FindFile {
        /// The path in the scene.
        missing: PathBuf,
        /// The path of the file.
        found: PathBuf,
        /// Whether the other missing files are searched in the same folder.
        others: bool,
    },
    /// Adds the plugins of an XML text.
    Paste(String),
    /// Adds one thing, which becomes the selection.
    Add(Addition),
    /// Adds a box, floor or wall that was drawn, which becomes the selection.
    Build(Box<Block>),
    /// Adds a roof, one of [`crate::scene::Solid::PLUGINS`], over the selection. It becomes the selection.
    Cover(&'static str),
    /// Sets the geometry of a shape together with its pose, world from local.
    Reshape(Entity, Shape, Affine3A, Reshaping),
    /// Gives the selected shapes another geometry. Their poses, materials, names and lights stay.
    Replace(Replacement),
    /// Removes the selection.
    Delete,
    /// Does `Copy`, then `Delete`.
    Cut,
    /// Copies the selection. The copies stand beside the originals, or continue the series if the selection was copied
    /// itself, and become the selection.
    Duplicate,
    /// Makes a series of copies or instances of the selection.
    MakeSeries(Series),
}

/// The geometry that shapes get.
#[derive(Clone, Debug, PartialEq)]
pub enum Replacement {
    /// The geometry of a mesh file, or of a glTF file or a scene with a single shape.
    File(PathBuf),
    /// The geometry of another shape.
    Shape(Entity),
}

impl SceneEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Import(_) => Traits::edit("Import").of_made(),
            Self::UseFile(file) => Traits::edit(match AssetKind::of(&file.path) {
                Some(AssetKind::Picture | AssetKind::Environment) => "Use picture",
                Some(AssetKind::Scene) => "Use file",
                Some(AssetKind::Mesh | AssetKind::Volume | AssetKind::Lamp) | None => "Import",
            })
            .of_made(),
            Self::FindFile { .. } => Traits::edit("Find files"),
            Self::Paste(_) => Traits::edit("Paste").of_made(),
            Self::Add(_) => Traits::edit("Add").of_made(),
            Self::Build(block) => Traits::edit(match block.kind {
                BlockKind::Box => "Draw box",
                BlockKind::Floor => "Draw floor",
                BlockKind::Wall => "Draw wall",
            }),
            Self::Cover(_) => Traits::edit("Add").of_made(),
            Self::Reshape(shape, .., Reshaping::Push) => Traits::drag("Push face").of(&[*shape]),
            Self::Reshape(shape, .., Reshaping::Cut) => Traits::edit("Cut opening").of(&[*shape]),
            Self::Reshape(shape, .., Reshaping::Move) => Traits::drag("Move opening").of(&[*shape]),
            Self::Reshape(shape, .., Reshaping::Fill) => Traits::edit("Fill opening").of(&[*shape]),
            Self::Replace(Replacement::File(path)) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                Traits::edit("Replace").of_selection().giving_name(&name)
            }
            Self::Replace(Replacement::Shape(source)) => Traits::edit("Replace").of_selection().giving(Some(*source)),
            Self::Delete => Traits::edit("Delete").of_selection(),
            Self::Cut => Traits::edit("Cut").of_selection(),
            Self::Duplicate => Traits::edit("Duplicate").of_selection(),
            Self::MakeSeries(_) => Traits::edit("Make a series of").of_selection(),
        }
    }
}
