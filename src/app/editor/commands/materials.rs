//! Edits of materials with nested materials, which are created and removed with them.

use bevy::prelude::*;

use super::material_names::{name_after_preset, name_as_id};
use super::preset_media;
use super::things::{delete, need, need_surface, outer_materials};
use crate::app::editor::camera::picking;
use crate::app::editor::command::MaterialEdit;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::material_tree::{Inside, MaterialTree, materials_inside};
use crate::app::editor::command::presets::Preset;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::PackedScene;
use crate::scene::insert::next_order;
use crate::scene::names::free_name_for;
use crate::scene::{
    DeclaredIn, DocumentOrder, FirstNested, LengthUnit, Locked, Material, MaterialUsers, SceneId, SecondNested, Shape,
    UsesMaterial,
};

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: MaterialEdit) -> Result<(), CommandError> {
    match command {
        MaterialEdit::UseMaterial { shapes, material } => {
            if let Some(material) = material {
                need::<Material>(edit, material)?;
            }
            for shape in shapes {
                need_surface(edit, shape)?;
                match material {
                    Some(material) => edit.set(shape, UsesMaterial(material)),
                    None => edit.remove::<UsesMaterial>(shape),
                }
            }
        }
        MaterialEdit::GiveMaterial { shape } => {
            need_surface(edit, shape)?;
            let before = edit.world.get::<UsesMaterial>(shape).map(|uses| uses.0);
            let material = copy_or_grey(edit, before);
            edit.set(shape, UsesMaterial(material));
        }
        MaterialEdit::DropMaterial { material, at } => drop_at(edit, material, at)?,
        MaterialEdit::BuildMaterial { targets, tree } => build(edit, &targets, &tree)?,
        MaterialEdit::UsePreset { preset, shapes } => use_preset(edit, &preset, &shapes)?,
        MaterialEdit::DropPreset { preset, at } => {
            let shape = shape_at(edit, at)?;
            use_preset(edit, &preset, &[shape])?;
        }
    }
    Ok(())
}

/// An error where there is nothing, or nothing that may be changed.
pub fn drop_at(edit: &mut Edit, material: Entity, at: Vec2) -> Result<(), CommandError> {
    if edit.world.get::<Material>(material).is_none() {
        return Err("Only materials can be dropped into the picture.".into());
    }
    let shape = shape_at(edit, at)?;
    edit.set(shape, UsesMaterial(material));
    Ok(())
}

/// The shape at a point of the picture that can take a material; an error if there is none or it is locked.
pub fn shape_at(edit: &Edit, at: Vec2) -> Result<Entity, CommandError> {
    let found = picking::pick(edit.world.resource::<PackedScene>(), at);
    let shape = found.ok_or("There is nothing that could take the material.")?;
    if edit.world.get::<Locked>(shape).is_some() {
        return Err("What is there is locked.".into());
    }
    Ok(shape)
}

/// Gives shapes a material of the library, and its medium as their interior. A material of the scene that has the
/// preset's name and is still equal to it is reused.
pub fn use_preset(edit: &mut Edit, preset: &Preset, shapes: &[Entity]) -> Result<(), CommandError> {
    for &shape in shapes {
        need_surface(edit, shape)?;
    }
    preset_media::need_inside(edit, preset, shapes)?;
    let name = preset.id();
    let tree = preset_tree(edit.world, preset);
    let mut known = edit.world.query::<(Entity, &Material, &SceneId)>();
    let mut alike = known
        .iter(edit.world)
        .filter(|(entity, _, id)| id.0 == name && tree_of(edit.world, *entity).as_ref() == Some(&tree));
    let material = match alike.next() {
        Some((entity, ..)) => entity,
        None => made(edit, &name, &tree),
    };
    for &shape in shapes {
        edit.set(shape, UsesMaterial(material));
    }
    preset_media::fill(edit, preset, shapes);
    Ok(())
}

/// The tree of a preset with the lengths of this scene.
pub(super) fn preset_tree(world: &World, preset: &Preset) -> MaterialTree {
    let unit = world.get_resource::<LengthUnit>().copied().unwrap_or_default();
    let up = world
        .get_resource::<ViewSettings>()
        .map_or(Vec3::Y, |settings| settings.navigation.up);
    preset.tree_in(unit, up)
}

/// Materials that only these shapes use: a material that others use as well is copied, and a shape without one gets a
/// grey one.
pub fn of_their_own(edit: &mut Edit, shapes: &[Entity]) -> Vec<Entity> {
    let mut own: Vec<(Option<Entity>, Entity)> = Vec::new();
    for &shape in shapes {
        let before = edit.world.get::<UsesMaterial>(shape).map(|uses| uses.0);
        let known = own.iter().find(|(known, _)| before.is_some() && *known == before);
        let material = match known {
            Some((_, material)) => *material,
            None => {
                let material = owned(edit, before, shapes);
                own.push((before, material));
                material
            }
        };
        if before != Some(material) {
            edit.set(shape, UsesMaterial(material));
        }
    }
    own.into_iter().map(|(_, material)| material).collect()
}

/// The material itself if only these shapes use it, else a copy; a grey one for none.
fn owned(edit: &mut Edit, material: Option<Entity>, shapes: &[Entity]) -> Entity {
    let Some(material) = material else {
        return copy_or_grey(edit, None);
    };
    let users = edit.world.get::<MaterialUsers>(material);
    let is_shared = users.is_some_and(|users| users.iter().any(|user| !shapes.contains(&user)));
    let is_nested = !outer_materials(edit.world, material).is_empty();
    let copy = match is_shared || is_nested {
        true => copied(edit, material),
        false => None,
    };
    copy.unwrap_or(material)
}

/// A copy of the material with all nested ones; a grey material for none.
pub fn copy_or_grey(edit: &mut Edit, material: Option<Entity>) -> Entity {
    let copy = material.and_then(|material| copied(edit, material));
    copy.unwrap_or_else(|| made(edit, "material", &Material::default().into()))
}

/// A new material of the scene, under this name if it is free.
fn made(edit: &mut Edit, name: &str, tree: &MaterialTree) -> Entity {
    let material = spawn(edit, name);
    name_as_id(edit, material, name);
    become_tree(edit, material, tree);
    material
}

/// A copy of a material with all nested ones; None where [`tree_of`] returns None.
pub(super) fn copied(edit: &mut Edit, material: Entity) -> Option<Entity> {
    let tree = tree_of(edit.world, material)?;
    let name = edit
        .world
        .get::<Name>(material)
        .map_or("material", Name::as_str)
        .to_owned();
    Some(made(edit, &name, &tree))
}

/// The tree of a material and its nested ones; None if the entity is no material or the tree is deeper than 16, such as
/// in a cycle.
pub(super) fn tree_of(world: &World, material: Entity) -> Option<MaterialTree> {
    const DEEPEST: usize = 16;
    fn below(world: &World, material: Entity, depth: usize) -> Option<MaterialTree> {
        let inside = materials_inside(world, material).into_iter();
        let inside = inside.map(|inner| Some(below(world, inner, depth.checked_sub(1)?)?.into()));
        Some(MaterialTree {
            material: world.get::<Material>(material)?.clone(),
            inside: inside.collect::<Option<_>>()?,
        })
    }
    below(world, material, DEEPEST)
}

/// Replaces materials, or the materials of shapes, by the tree; a shape without one gets a new one. Shapes that share a
/// material still share it afterwards. An error if the tree cannot be nested in the material around.
pub fn build(edit: &mut Edit, targets: &[Entity], tree: &MaterialTree) -> Result<(), CommandError> {
    let mut done = Vec::new();
    for &target in targets {
        let material = if edit.world.get::<Material>(target).is_some() {
            target
        } else if edit.world.get::<Shape>(target).is_some_and(|shape| !shape.is_frame()) {
            match edit.world.get::<UsesMaterial>(target) {
                Some(UsesMaterial(material)) => *material,
                None => {
                    let material = spawn(edit, "material");
                    edit.set(target, UsesMaterial(material));
                    material
                }
            }
        } else {
            continue;
        };
        if !done.contains(&material) {
            become_tree(edit, material, tree);
            name_after_preset(edit, material, tree);
            done.push(material);
        }
    }
    done.into_iter()
        .try_for_each(|material| check_sides(edit.world, material))
}

/// An error where a material that refracts is inside of `twosided`: no scene file may have that.
pub fn check_sides(world: &World, material: Entity) -> Result<(), CommandError> {
    let get = |entity: Entity| world.get::<Material>(entity);
    let outer = outer_materials(world, material)
        .into_iter()
        .map(|outer| (outer, material));
    let inner = materials_inside(world, material)
        .into_iter()
        .map(|inner| (material, inner));
    for (outer, inner) in outer.chain(inner) {
        if get(outer) == Some(&Material::TwoSided)
            && let Some(refractive) = get(inner).filter(|inner| inner.refracts())
        {
            let plugin = refractive.plugin();
            return Err(format!("`{plugin}` has two sides already: `twosided` does not take it.").into());
        }
    }
    Ok(())
}

/// Replaces a material by a tree. Nested materials that are no longer used are removed.
fn become_tree(edit: &mut Edit, material: Entity, tree: &MaterialTree) {
    let before = materials_inside(edit.world, material);
    let mut moves = Vec::new();
    write_tree(edit, material, tree, &mut moves);
    for inner in before {
        remove_unused(edit, inner);
    }
    for Move { inner, from, to } in moves {
        if !materials_inside(edit.world, from).contains(&inner) {
            edit.set(inner, DeclaredIn(to));
        }
    }
}

/// A material that was written inside of `from` and may now be nested in `to`.
struct Move {
    inner: Entity,
    from: Entity,
    to: Entity,
}

fn write_tree(edit: &mut Edit, material: Entity, tree: &MaterialTree, moves: &mut Vec<Move>) {
    let mut nested = Vec::new();
    for inner in &tree.inside {
        nested.push(match inner {
            Inside::Kept(inner) => {
                let declared = edit.world.get::<DeclaredIn>(*inner).map(|declared| declared.0);
                moves.extend(
                    declared
                        .filter(|from| edit.world.get::<Material>(*from).is_some())
                        .map(|from| Move {
                            inner: *inner,
                            from,
                            to: material,
                        }),
                );
                *inner
            }
            Inside::New(tree) => {
                let entity = spawn(edit, tree.material.plugin());
                edit.set(entity, DeclaredIn(material));
                write_tree(edit, entity, tree, moves);
                entity
            }
        });
    }
    edit.set(material, tree.material.clone());
    match nested.first() {
        Some(first) => edit.set(material, FirstNested(*first)),
        None => edit.remove::<FirstNested>(material),
    }
    match nested.get(1) {
        Some(second) => edit.set(material, SecondNested(*second)),
        None => edit.remove::<SecondNested>(material),
    }
}

/// Removes a material that was declared inside of another and is nested in none any more, with its own nested ones.
fn remove_unused(edit: &mut Edit, material: Entity) {
    let is_own = edit.world.get::<DeclaredIn>(material).is_none();
    let has_users = edit
        .world
        .get::<MaterialUsers>(material)
        .is_some_and(|users| !users.is_empty());
    if is_own || has_users || !outer_materials(edit.world, material).is_empty() {
        return;
    }
    let before = materials_inside(edit.world, material);
    delete(edit, material);
    for inner in before {
        remove_unused(edit, inner);
    }
}

fn spawn(edit: &mut Edit, name: &str) -> Entity {
    let order = DocumentOrder(next_order(edit.world));
    let name = free_name_for(edit.world, name);
    edit.spawn((Material::default(), order, Name::new(name)))
}
