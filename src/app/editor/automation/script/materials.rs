//! The verbs about materials.

use bevy::prelude::*;

use super::error::ScriptError;
use super::names::{all_named, material_of, named, unknown};
use super::verb::verbs;
use crate::app::editor::command::MaterialEdit;
use crate::app::editor::command::material_tree::{MaterialTree, can_wrap, materials_inside, wrappers};
use crate::app::editor::model::EditorModel;
use crate::scene::Material;

verbs! {
    VERBS(world):
    "material-of" "SHAPE (a new one of its own)" [shape] => MaterialEdit::GiveMaterial { shape: named(world, shape)? };
    "make" "MATERIAL PLUGIN (two-sided ones stay so)" [name, plugin] => make(world, name, plugin)?;
    "wrap" "MATERIAL PLUGIN (twosided, blendbsdf, mask, bumpmap, normalmap)"
        [name, plugin] => wrap(world, name, plugin)?;
    "unwrap" "MATERIAL [first|second]"
        [name, which @ ..] if which.len() <= 1 => unwrap(world, name, which.first().copied())?;
    "assign" "MATERIAL SHAPE..."
        [material, shapes @ ..] if !shapes.is_empty() => MaterialEdit::UseMaterial {
            shapes: all_named(world, shapes)?,
            material: Some(named(world, material)?),
        };
    "preset" "GROUP/NAME SHAPE... (of the library)"
        [path, shapes @ ..] if !shapes.is_empty() => preset(world, path, shapes)?;
}

fn make(world: &mut World, name: &str, plugin: &str) -> Result<MaterialEdit, ScriptError> {
    let material = Material::of_plugin(plugin);
    let material = material.ok_or_else(|| unknown("material", plugin, Material::PLUGINS))?;
    if *material.info().nested.start() > 0 {
        return Err(format!("a {plugin} has others inside: paste it as XML").into());
    }
    let thing = named(world, name)?;
    let entity = material_of(world, thing).ok_or("it has no material")?;
    let is_two_sided = world.get::<Material>(entity) == Some(&Material::TwoSided);
    let keeps_wrapper = is_two_sided && can_wrap("twosided", &material);
    let tree = MaterialTree::from(material);
    Ok(build(
        entity,
        match keeps_wrapper {
            true => tree.wrapped("twosided"),
            false => tree,
        },
    ))
}

fn preset(world: &mut World, path: &str, shapes: &[&str]) -> Result<MaterialEdit, ScriptError> {
    let shapes = all_named(world, shapes)?;
    let presets = world.resource::<EditorModel>().0.presets.clone();
    let preset = presets.iter().find(|preset| preset.path() == *path);
    let paths: Vec<String> = presets.iter().map(|preset| preset.path()).collect();
    let preset = preset.ok_or_else(|| unknown("preset", path, paths.iter().map(String::as_str)))?;
    Ok(MaterialEdit::UsePreset {
        preset: Box::new(preset.clone()),
        shapes,
    })
}

fn wrap(world: &mut World, name: &str, plugin: &str) -> Result<MaterialEdit, ScriptError> {
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

fn unwrap(world: &mut World, name: &str, which: Option<&str>) -> Result<MaterialEdit, ScriptError> {
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

fn build(target: Entity, tree: MaterialTree) -> MaterialEdit {
    MaterialEdit::BuildMaterial {
        targets: vec![target],
        tree: Box::new(tree),
    }
}
