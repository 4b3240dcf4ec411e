//! Edits of the materials that shapes have.

use bevy::prelude::{Entity, Vec2};

use super::material_tree::MaterialTree;
use super::presets::Preset;
use super::traits::Traits;

/// An edit of the materials that shapes have.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialEdit {
    /// Gives the shapes this material, or takes theirs away.
    UseMaterial {
        /// The shapes that get it.
        shapes: Vec<Entity>,
        /// The material. None removes that of the shapes.
        material: Option<Entity>,
    },
    /// Gives the material to the shape that is seen at a place of the picture.
    DropMaterial {
        /// A material of the scene.
        material: Entity,
        /// The place in the picture: (0, 0) top left, (1, 1) bottom right.
        at: Vec2,
    },
    /// Gives this shape a material of its own: a copy of the one that it has, or a grey one.
    GiveMaterial {
        /// The shape that gets it.
        shape: Entity,
    },
    /// Makes materials, or those of shapes, become the tree.
    BuildMaterial {
        /// Materials, or shapes whose materials are meant.
        targets: Vec<Entity>,
        /// The tree that each becomes.
        tree: Box<MaterialTree>,
    },
    /// Gives the shapes a material of the library. If the scene already has one like it with the same name, they get
    /// that one.
    UsePreset {
        /// The entry of the library.
        preset: Box<Preset>,
        /// The shapes that get it.
        shapes: Vec<Entity>,
    },
    /// Drops a preset onto the shape that is seen at a place of the picture.
    DropPreset {
        /// The entry of the library.
        preset: Box<Preset>,
        /// The place in the picture: (0, 0) top left, (1, 1) bottom right.
        at: Vec2,
    },
}

impl MaterialEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::UseMaterial { shapes, material } => Traits::edit("Assign material").of(shapes).giving(*material),
            Self::UsePreset { preset, shapes } => Traits::edit("Assign material").of(shapes).giving_name(&preset.name),
            Self::DropMaterial { material, .. } => Traits::edit("Assign material").of(&[*material]),
            Self::DropPreset { preset, .. } => Traits::edit("Assign material").giving_name(&preset.name),
            Self::GiveMaterial { shape } => Traits::edit("New material").of(&[*shape]),
            Self::BuildMaterial { targets, .. } => Traits::edit("Make material").of(targets),
        }
    }
}
