//! Edits of the materials that shapes have.

use bevy::prelude::{Entity, Vec2};

use super::material_tree::MaterialTree;
use super::presets::Preset;
use super::traits::Traits;

/// An edit of the materials that shapes have.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialEdit {
    /// Assigns this material to the shapes, or removes theirs.
    UseMaterial {
        /// The shapes.
        shapes: Vec<Entity>,
        /// The material. None removes that of the shapes.
        material: Option<Entity>,
    },
    /// Assigns the material to the visible shape at a point of the picture.
    DropMaterial {
        /// A material of the scene.
        material: Entity,
        /// The place in the picture: (0, 0) top left, (1, 1) bottom right.
        at: Vec2,
    },
    /// Gives this shape a material of its own: a copy of the one that it has, or a grey one.
    GiveMaterial {
        /// The shape.
        shape: Entity,
    },
    /// Replaces materials, or the materials of shapes, by the tree.
    BuildMaterial {
        /// Materials, or shapes that stand for their materials.
        targets: Vec<Entity>,
        /// The tree that replaces each.
        tree: Box<MaterialTree>,
    },
    /// Assigns a material of the library to the shapes. An equal material of the scene with the same name is reused.
    UsePreset {
        /// The entry of the library.
        preset: Box<Preset>,
        /// The shapes.
        shapes: Vec<Entity>,
    },
    /// Drops a preset onto the visible shape at a point of the picture.
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
