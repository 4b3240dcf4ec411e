//! Places the textures of materials on surfaces.

use bevy::math::Affine2;
use bevy::prelude::*;

use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::texture_placing::has_textures;
use crate::app::editor::session::history::Edit;
use crate::scene::{Material, Shape, UsesMaterial};

/// Gives all textures of a material, or of a shape's, that have one transform of uv another one. An error if there are
/// none.
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

/// An error, with what to do, unless the active thing is a shape with textures that can be placed.
pub(super) fn need_textures(world: &World) -> Result<(), CommandError> {
    let active = world.resource::<Selection>().active();
    let shape = active.filter(|active| world.get::<Shape>(*active).is_some_and(|shape| !shape.is_frame()));
    let materials = shape.into_iter().flat_map(|shape| material_parts(world, shape));
    match has_textures(materials.filter_map(|material| world.get::<Material>(material))) {
        true => Ok(()),
        false => Err("Select a shape with a picture or a checkerboard in its material: this tool places these.".into()),
    }
}

/// A material, or that of a shape, with all that are nested in it.
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
