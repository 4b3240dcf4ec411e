//! Places the textures of materials on surfaces.

use bevy::math::Affine2;
use bevy::prelude::*;

use super::things::outer_materials;
use super::uv_projection;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::texture_placing::has_textures;
use crate::app::editor::command::{TextureEdit, texture_placing};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::trust;
use crate::document::paths::settle;
use crate::scene::{AreaLight, ChosenPicture, Emitter, Material, MaterialUsers, Shape, SquarePath, UsesMaterial};
use std::path::PathBuf;

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: TextureEdit) -> Result<(), CommandError> {
    match command {
        TextureEdit::SetPicture {
            owner,
            parameter,
            place,
            path,
        } => {
            let path = settle(&path);
            trust::allow_chosen(edit.world, &path);
            set_picture(edit, owner, parameter, place, path);
        }
        TextureEdit::PlaceTextures { owner, before, after } => place(edit, owner, before, after)?,
        TextureEdit::ProjectTextures { shapes, projection } => uv_projection::project(edit, &shapes, projection)?,
    }
    Ok(())
}

/// Replaces the transform of all textures of a material, or of a shape's material, that have the transform `before`. An
/// error if there are none.
pub fn place(edit: &mut Edit, owner: Entity, before: Affine2, after: Affine2) -> Result<(), CommandError> {
    if !after.is_finite() {
        return Err("A texture cannot be placed by numbers that are not finite.".into());
    }
    let mut has_any = false;
    for material in material_parts(edit.world, owner) {
        let Some(mut edited) = edit.world.get::<Material>(material).cloned() else {
            continue;
        };
        let mut is_changed = false;
        edited.for_each_placing(&mut |_, to_uv| {
            if *to_uv == before {
                *to_uv = after;
                is_changed = true;
            }
        });
        if is_changed {
            has_any = true;
            edit.set(material, edited);
        }
    }
    match has_any {
        true => Ok(()),
        false => Err("There is no picture or checkerboard that is placed so.".into()),
    }
}

/// An error, with advice, unless the active thing is a shape with textures that can be placed.
pub(super) fn need_textures(world: &World) -> Result<(), CommandError> {
    let active = world.resource::<Selection>().active();
    let shape = active.filter(|active| world.get::<Shape>(*active).is_some_and(|shape| !shape.is_frame()));
    let materials = shape.into_iter().flat_map(|shape| material_parts(world, shape));
    match has_textures(materials.filter_map(|material| world.get::<Material>(material))) {
        true => Ok(()),
        false => Err("Select a shape with a picture or a checkerboard in its material: this tool places these.".into()),
    }
}

/// A material, or the material of a shape, with all nested ones.
pub(crate) fn material_parts(world: &World, owner: Entity) -> Vec<Entity> {
    let outermost = world.get::<UsesMaterial>(owner).map_or(owner, |uses| uses.0);
    let mut found = vec![outermost];
    let mut next = 0;
    while let Some(&material) = found.get(next) {
        for inner in materials_inside(world, material) {
            if !found.contains(&inner) {
                found.push(inner);
            }
        }
        next += 1;
    }
    found
}

/// The depth to which materials around a material are followed.
const DEEPEST: usize = 8;

/// Sets a picture, which keeps the parameters of the former bitmap; other textures become a plain bitmap, upright on
/// the shapes that use it. Lights have one parameter that may be a picture.
pub fn set_picture(edit: &mut Edit, owner: Entity, parameter: &str, place: SquarePath, path: PathBuf) {
    if let Some(mut edited) = edit.world.get::<Material>(owner).cloned() {
        let picture = upright(path.clone(), &shapes_of(edit.world, owner, DEEPEST));
        edited.set_picture(parameter, place, &picture);
        edit.set(owner, edited);
    }
    if let Some(mut edited) = edit.world.get::<AreaLight>(owner).cloned() {
        let shape = edit.world.get::<Shape>(owner).cloned();
        edited
            .radiance
            .set_picture_at(place, upright(path.clone(), shape.as_slice()));
        edit.set(owner, edited);
    }
    if let Some(mut edited) = edit.world.get::<Emitter>(owner).cloned() {
        edited.set_picture(place, path);
        edit.set(owner, edited);
    }
}

/// The picture flipped if all shapes would show it upside down.
fn upright(path: PathBuf, shapes: &[Shape]) -> ChosenPicture {
    let is_turned = !shapes.is_empty() && shapes.iter().all(Shape::shows_pictures_upside_down);
    ChosenPicture {
        path,
        to_uv: texture_placing::upright(is_turned),
    }
}

/// The shapes that have the material, or one that it is nested in.
fn shapes_of(world: &World, material: Entity, deepest: usize) -> Vec<Shape> {
    let users = world.get::<MaterialUsers>(material);
    let shapes = users.into_iter().flat_map(|users| users.iter());
    let mut found: Vec<Shape> = shapes.filter_map(|user| world.get::<Shape>(user).cloned()).collect();
    if let Some(deepest) = deepest.checked_sub(1) {
        for outer in outer_materials(world, material) {
            found.extend(shapes_of(world, outer, deepest));
        }
    }
    found
}
