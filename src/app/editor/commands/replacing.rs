//! Gives the selected shapes the geometry of a mesh file, or of another shape of the scene.

use std::path::Path;

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::importing::{file_of, mesh_format, mesh_of, scene_of};
use super::things::{pose_of, selected, set_pose};
use crate::app::editor::command::SceneEdit;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::scene::Replacement;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::trust;
use crate::app::editor::words::files::extension;
use crate::scene::{AreaLight, KeyPath, Keys, Shape, ShapeKind};

/// Replaces the geometry of the selected shapes. Their poses, materials, names and lights stay.
pub fn replace(edit: &mut Edit, by: &Replacement) -> Result<(), CommandError> {
    match by {
        Replacement::Shape(source) => {
            let shape = edit.world.get::<Shape>(*source).filter(|shape| has_surface(shape));
            let shape = shape.cloned().ok_or("Its geometry cannot be that of others.")?;
            replace_all(edit, &shape, &Affine3A::IDENTITY, Some(*source))
        }
        Replacement::File(path) => {
            let path = file_of(path)?;
            let (shape, pose) = match mesh_format(&extension(&path)) {
                Some(format) => {
                    let kind = mesh_of(path.clone(), format);
                    let shape = Shape {
                        kind,
                        ..Shape::default()
                    };
                    (shape, Affine3A::IDENTITY)
                }
                None => only_shape(edit, &path)?,
            };
            replace_all(edit, &shape, &pose, None)?;
            trust::allow_chosen(edit.world, &path);
            Ok(())
        }
    }
}

/// The shape of a glTF file or a scene with no other, and its pose in the file.
fn only_shape(edit: &mut Edit, path: &Path) -> Result<(Shape, Affine3A), CommandError> {
    if !["gltf", "glb", "xml"].contains(&extension(path).as_str()) {
        let message = format!("{}: not a mesh (obj, ply, serialized, gltf, glb, xml)", path.display());
        return Err(CommandError::file(message));
    }
    let again = |path| SceneEdit::Replace(Replacement::File(path));
    let shapes = scene_of(edit, path, again)?.shapes.into_iter();
    let mut shapes: Vec<(Shape, Affine3A)> = shapes
        .map(|shape| (shape.shape, shape.to_world))
        .filter(|(shape, _)| has_surface(shape))
        .collect();
    match (shapes.pop(), shapes.len()) {
        (Some(only), 0) => Ok(only),
        (found, others) => {
            let count = others + usize::from(found.is_some());
            let message = format!(
                "{}: it has {count} shapes, and only one can take a place",
                path.display()
            );
            Err(CommandError::file(message))
        }
    }
}

fn has_surface(shape: &Shape) -> bool {
    !matches!(shape.kind, ShapeKind::Frame | ShapeKind::Instance)
}

/// `pose` is that of the new geometry in the space of the old.
fn replace_all(edit: &mut Edit, by: &Shape, pose: &Affine3A, source: Option<Entity>) -> Result<(), CommandError> {
    let mut shapes = selected(edit)?;
    shapes.retain(|entity| {
        let shape = edit.world.get::<Shape>(*entity);
        Some(*entity) != source && shape.is_some_and(has_surface)
    });
    if shapes.is_empty() {
        return Err("Select the shapes that get another geometry.".into());
    }
    if by.is_of_curves()
        && shapes
            .iter()
            .any(|entity| edit.world.get::<AreaLight>(*entity).is_some())
    {
        return Err("Curves cannot shine: light is not sampled on them.".into());
    }
    for entity in shapes {
        let new_pose = pose_of(edit.world, entity).map(|old| old * *pose);
        let before = edit
            .world
            .get::<Shape>(entity)
            .map_or(1.0, |shape| shape.lightmap_scale);
        forget_keys(edit, entity, |_| true);
        let lightmap_scale = before;
        edit.set(
            entity,
            Shape {
                lightmap_scale,
                ..by.clone()
            },
        );
        // The place of a shape may be elsewhere in its own space than before.
        if let Some(pose) = new_pose {
            set_pose(edit, entity, pose);
        }
    }
    Ok(())
}

/// Removes the key frames of a shape's own parameters that have one of these names.
pub(super) fn forget_keys(edit: &mut Edit, entity: Entity, is_lost: impl Fn(&str) -> bool) {
    let Some(keys) = edit.world.get::<Keys>(entity).cloned() else {
        return;
    };
    let is_own =
        |path: &&KeyPath| !path.as_str().contains('.') && path.as_str() != "to_world" && is_lost(path.as_str());
    let own: Vec<KeyPath> = keys.tracks().map(|(path, _)| path).filter(is_own).cloned().collect();
    if own.is_empty() {
        return;
    }
    match own.iter().fold(keys, |keys, path| keys.with(path, None)).some() {
        Some(keys) => edit.set(entity, keys),
        None => edit.remove::<Keys>(entity),
    }
}
