//! The verbs that put materials into others and take them out again.

use bevy::prelude::*;

use super::error::ScriptError;
use super::names::{material_of, named, unknown};
use crate::app::editor::command::material_tree::{MaterialTree, can_wrap, materials_inside, wrappers};
use crate::app::editor::command::{Command, MaterialEdit};
use crate::scene::Material;

/// `wrap MATERIAL PLUGIN`
pub fn wrap(world: &mut World, name: &str, plugin: &str) -> Result<Command, ScriptError> {
    let names = || wrappers().map(|wrapper| wrapper.name);
    if !names().any(|name| name == plugin) {
        return Err(unknown("material around others", plugin, names()));
    }
    let thing = named(world, name)?;
    let entity = material_of(world, thing).ok_or("it has no material")?;
    let material = world.get::<Material>(entity).ok_or("it has no material")?;
    if !can_wrap(plugin, material) {
        return Err(format!("a {} cannot be in {plugin}", material.plugin()).into());
    }
    let tree = MaterialTree::of(material, &materials_inside(world, entity));
    Ok(build(entity, tree.wrapped(plugin)))
}

/// `unwrap MATERIAL [first|second]`
pub fn unwrap(world: &mut World, name: &str, which: Option<&str>) -> Result<Command, ScriptError> {
    let index = match which {
        None | Some("first") => 0,
        Some("second") => 1,
        Some(other) => return Err(unknown("part", other, ["first", "second"])),
    };
    let thing = named(world, name)?;
    let entity = material_of(world, thing).ok_or("it has no material")?;
    let inside = materials_inside(world, entity);
    let inner = *inside.get(index).ok_or("it has no such material inside")?;
    let material = world.get::<Material>(inner).ok_or("it has no such material inside")?;
    Ok(build(
        entity,
        MaterialTree::of(material, &materials_inside(world, inner)),
    ))
}

fn build(target: Entity, tree: MaterialTree) -> Command {
    Command::from(MaterialEdit::BuildMaterial {
        targets: vec![target],
        tree: Box::new(tree),
    })
}
