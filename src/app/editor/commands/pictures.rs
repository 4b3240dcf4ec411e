//! Puts pictures where a material or a light has a value or another picture.

use std::path::PathBuf;

use bevy::prelude::*;

use super::things::outer_materials;
use crate::app::editor::command::texture_placing;
use crate::app::editor::session::history::Edit;
use crate::scene::{AreaLight, ChosenPicture, Emitter, Material, MaterialUsers, Shape, SquarePath};

/// The depth to which materials around a material are followed.
const DEEPEST: usize = 8;

/// Sets a picture. It is read in the same way as the one before it; other textures become a plain picture, upright on
/// the shapes that have it. Lights have one parameter that may be a picture.
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

/// The picture turned over if all shapes would show it upside down.
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
