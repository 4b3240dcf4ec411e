//! Places the textures of materials on surfaces.

use bevy::math::Affine2;
use bevy::prelude::*;

use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::session::history::Edit;
use crate::scene::{Material, UsesMaterial};

/// Gives all textures of a material, or of a shape's, that have one transform of uv another one. An error if there are none.
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
