//! Edits of the scene. Each goes through an [`Edit`], which remembers what was there.

use std::collections::HashSet;
use std::path::PathBuf;

use bevy::math::{Affine3A, Vec3A};
use bevy::prelude::*;

use super::{adding, materials, mixing, placing, several, view};
use crate::app::editor::command::{Command, Direction};
use crate::app::editor::history::Edit;
use crate::app::editor::selection::{Extend, Selection};
use crate::app::editor::trust;
use crate::scene::insert::{free_name, names, next_order};
use crate::scene::{
    AccelMethod, ActiveSensor, AreaLight, DeclaredIn, Declares, DocumentOrder, Emitter, FirstNested, FirstNestedIn,
    FreeView, Hidden, IntegratorSettings, Locked, Material, MaterialUsers, MemberOf, ObjectState, Placements,
    SamplerSettings, SceneId, SecondNested, SecondNestedIn, Sensor, Shape, ShapeGroup, SquarePath, ToWorld,
    UsesMaterial,
};

/// The error is a sentence for the user; the caller takes back what was done before it.
pub fn apply(edit: &mut Edit, command: Command) -> Result<(), String> {
    match command {
        Command::Import(path) => {
            adding::import(edit, &path)?;
            trust::allow_chosen(edit.world, &path);
        }
        Command::Paste(text) => adding::paste(edit, &text)?,
        Command::Add(addition) => adding::add(edit, addition)?,
        Command::Delete => delete_selection(edit)?,
        Command::Cut => {
            super::files::copy(edit.world)?;
            delete_selection(edit)?;
        }
        Command::Duplicate => duplicate(edit)?,
        Command::Rename(entity, name) => rename(edit, entity, &name)?,
        Command::Reorder { moved, before } => reorder(edit, &moved, before),
        Command::Group => group(edit)?,
        Command::PutInto { things, folder } => put_into(edit, things, folder.as_deref())?,
        Command::Hide(entities, hidden) => hide(edit, &entities, hidden),
        Command::HideOthers => {
            let selection = edit.world.resource::<Selection>().clone();
            let others = visible_things(edit.world, |entity| !selection.contains(entity));
            hide(edit, &others, true);
        }
        Command::ShowAll => {
            let mut hidden = edit.world.query_filtered::<Entity, With<Hidden>>();
            let hidden: Vec<Entity> = hidden.iter(edit.world).collect();
            hide(edit, &hidden, false);
        }
        Command::Lock(entities, locked) => {
            for entity in entities {
                if locked {
                    edit.set(entity, Locked);
                } else {
                    edit.remove::<Locked>(entity);
                }
            }
        }
        Command::MoveCameraToView => {
            let sensor = edit.world.resource::<ActiveSensor>().0;
            let (Some(sensor), Some(pose)) = (sensor, view::view_pose(edit.world)) else {
                return Err("There is no camera.".to_owned());
            };
            if let Some(lens) = edit.world.resource::<FreeView>().lens
                && let Some(seen) = edit.world.get::<Sensor>(sensor).copied()
            {
                edit.set(sensor, Sensor { lens, ..seen });
            }
            edit.set(sensor, ToWorld(pose));
            edit.world.insert_resource(FreeView::default());
        }
        Command::Nudge(direction) => placing::nudge(edit, direction)?,
        Command::Drop => placing::drop(edit)?,
        Command::Transform(poses) => transform(edit, poses)?,
        Command::SetShape(entity, shape) => replace(edit, entity, shape)?,
        Command::SetMaterial(entity, material) => {
            replace(edit, entity, *material)?;
            materials::check_sides(edit.world, entity)?;
        }
        Command::SetPicture {
            owner,
            parameter,
            place,
            path,
        } => {
            trust::allow_chosen(edit.world, &path);
            set_picture(edit, owner, parameter, place, path);
        }
        Command::UseMaterial { shapes, material } => {
            if let Some(material) = material {
                need::<Material>(edit, material)?;
            }
            for shape in shapes {
                need::<Shape>(edit, shape)?;
                match material {
                    Some(material) => edit.set(shape, UsesMaterial(material)),
                    None => edit.remove::<UsesMaterial>(shape),
                }
            }
        }
        Command::GiveMaterial { shape } => {
            need::<Shape>(edit, shape)?;
            let order = DocumentOrder(next_order(edit.world));
            let name = free_name(&names(edit.world), "material");
            let material = edit.spawn((Material::default(), order, SceneId(name.clone()), Name::new(name)));
            edit.set(shape, UsesMaterial(material));
        }
        Command::DropMaterial { material, at } => materials::drop_at(edit, material, at)?,
        Command::BuildMaterial { targets, tree } => materials::build(edit, &targets, &tree)?,
        Command::UsePreset { preset, shapes } => materials::use_preset(edit, &preset, &shapes)?,
        Command::DropPreset { preset, at } => {
            let shape = materials::shape_at(edit, at)?;
            materials::use_preset(edit, &preset, &[shape])?;
        }
        Command::SetAreaLight(entity, light) => match light {
            Some(light) => {
                need::<Shape>(edit, entity)?;
                edit.set(entity, light);
            }
            None => edit.remove::<AreaLight>(entity),
        },
        Command::SetEmitter(entity, emitter) => replace(edit, entity, emitter)?,
        Command::SetSensor(entity, sensor) => replace(edit, entity, sensor)?,
        Command::FocusAt(film) => view::focus(edit, film)?,
        Command::SetFilm(entity, film) => replace(edit, entity, film)?,
        Command::SetIntegrator(settings) => super::set_resource::<IntegratorSettings>(edit.world, settings),
        Command::SetSampler(settings) => super::set_resource::<SamplerSettings>(edit.world, settings),
        Command::SetAccel(method) => super::set_resource::<AccelMethod>(edit.world, method),
        Command::BakeLights => mixing::bake(edit)?,
        Command::OnSelection(command) => several::apply(edit, *command)?,
        // The others are no edits.
        _ => {}
    }
    Ok(())
}

/// An error unless the entity has a component of this type.
pub fn need<C: Component>(edit: &Edit, entity: Entity) -> Result<(), String> {
    match edit.world.get::<C>(entity) {
        Some(_) => Ok(()),
        None => Err("That cannot be done to this thing.".to_owned()),
    }
}

/// Another value for a component that is there.
fn replace<C: Component + PartialEq>(edit: &mut Edit, entity: Entity, value: C) -> Result<(), String> {
    need::<C>(edit, entity)?;
    edit.set(entity, value);
    Ok(())
}

pub fn selected(edit: &Edit) -> Result<Vec<Entity>, String> {
    let selection = edit.world.resource::<Selection>().entities();
    let free: Vec<Entity> = selection
        .iter()
        .copied()
        .filter(|entity| ObjectState::is_in_scene(edit.world, *entity) && edit.world.get::<Locked>(*entity).is_none())
        .collect();
    match (selection.is_empty(), free.is_empty()) {
        (true, _) => Err("Nothing is selected.".to_owned()),
        (false, true) => Err("What is selected is locked.".to_owned()),
        (false, false) => Ok(free),
    }
}

fn delete_selection(edit: &mut Edit) -> Result<(), String> {
    for entity in selected(edit)? {
        delete(edit, entity);
    }
    edit.world.insert_resource(Selection::default());
    Ok(())
}

/// With the materials that were written inside of it and that nobody else uses; whoever used it uses none then.
pub(super) fn delete(edit: &mut Edit, entity: Entity) {
    let declared: Vec<Entity> = edit
        .world
        .get::<Declares>(entity)
        .map(|declares| declares.iter().collect())
        .unwrap_or_default();
    let users: Vec<Entity> = edit
        .world
        .get::<MaterialUsers>(entity)
        .map(|users| users.iter().collect())
        .unwrap_or_default();
    for user in users {
        edit.remove::<UsesMaterial>(user);
    }
    // What it was inside of needs something in its place.
    for outer in outer_materials(edit.world, entity) {
        let is_first = edit
            .world
            .get::<FirstNested>(outer)
            .is_some_and(|nested| nested.0 == entity);
        let order = DocumentOrder(next_order(edit.world));
        let plain = edit.spawn((Material::default(), order, Name::new("diffuse")));
        edit.set(plain, DeclaredIn(outer));
        if is_first {
            edit.set(outer, FirstNested(plain));
        } else {
            edit.set(outer, SecondNested(plain));
        }
    }
    edit.delete(entity);
    for material in declared {
        let is_used = edit
            .world
            .get::<MaterialUsers>(material)
            .is_some_and(|users| !users.is_empty())
            || !outer_materials(edit.world, material).is_empty();
        if is_used {
            // It stands for itself from now on.
            edit.remove::<DeclaredIn>(material);
        } else {
            delete(edit, material);
        }
    }
}

/// The materials that this one is nested in.
pub fn outer_materials(world: &World, material: Entity) -> Vec<Entity> {
    let first = world
        .get::<FirstNestedIn>(material)
        .into_iter()
        .flat_map(|outer| outer.iter());
    let second = world
        .get::<SecondNestedIn>(material)
        .into_iter()
        .flat_map(|outer| outer.iter());
    first
        .chain(second)
        .filter(|outer| ObjectState::is_in_scene(world, *outer))
        .collect()
}

/// Copies use the same materials and groups; they are selected then.
fn duplicate(edit: &mut Edit) -> Result<(), String> {
    let mut taken = names(edit.world);
    let mut order = next_order(edit.world);
    let mut copies = Vec::new();
    // Where it can be seen that there are two.
    let aside = placing::step(edit.world, Direction::Right);
    for original in selected(edit)? {
        let mut state = ObjectState::of(edit.world, original);
        if state.placements.is_some() {
            return Err("So many instances cannot be doubled.".to_owned());
        }
        let name = state.name.as_ref().map_or("copy", |name| name.as_str());
        let name = free_name(&taken, name);
        taken.insert(name.clone());
        state.id = Some(SceneId(name.clone()));
        state.name = Some(Name::new(name));
        state.order = Some(DocumentOrder(order));
        state.declared_in = None;
        if let Some(ToWorld(pose)) = &mut state.to_world {
            pose.translation += Vec3A::from(aside);
        }
        order = order.saturating_add(1);
        let copy = edit.spawn(());
        state.write(edit.world, copy);
        copies.push(copy);
    }
    edit.world.insert_resource(Selection::of(copies));
    Ok(())
}

fn rename(edit: &mut Edit, entity: Entity, name: &str) -> Result<(), String> {
    let name = name.trim();
    if name.is_empty() {
        if edit.world.get::<ShapeGroup>(entity).is_some() {
            return Err("A group needs its name: instances refer to it.".to_owned());
        }
        edit.remove::<SceneId>(entity);
        return Ok(());
    }
    if edit.world.get::<SceneId>(entity).is_some_and(|id| id.0 == name)
        && edit
            .world
            .get::<Name>(entity)
            .is_some_and(|known| known.as_str() == name)
    {
        return Ok(());
    }
    check_name(name)?;
    let is_own = edit
        .world
        .get::<Name>(entity)
        .is_some_and(|known| known.as_str() == name);
    if !is_own && names(edit.world).contains(name) {
        return Err(format!("There is something called \"{name}\" already."));
    }
    call(edit, entity, name);
    Ok(())
}

/// What the file could not have as an id.
pub fn check_name(name: &str) -> Result<(), String> {
    match name.chars().find(|c| is_no_name(*c)) {
        Some(wrong) => Err(format!("Names cannot have {wrong:?} in them.")),
        None => Ok(()),
    }
}

/// Characters that ids cannot have.
fn is_no_name(c: char) -> bool {
    c.is_control() || "$.\"<>&".contains(c)
}

fn call(edit: &mut Edit, entity: Entity, name: &str) {
    edit.set(entity, SceneId(name.to_owned()));
    edit.set(entity, Name::new(name.to_owned()));
}

fn group(edit: &mut Edit) -> Result<(), String> {
    let members = selected(edit)?;
    let taken = names(edit.world);
    let folders = taken.iter().filter_map(|name| Some(name.split_once('/')?.0.to_owned()));
    let folder = free_name(&folders.collect::<HashSet<_>>(), "group");
    put_into(edit, members, Some(&folder))
}

/// Folders are written as the part of names before the last `/`.
fn put_into(edit: &mut Edit, things: Vec<Entity>, folder: Option<&str>) -> Result<(), String> {
    if folder.is_some_and(|folder| folder.chars().any(is_no_name)) {
        return Err("The folder's name has a character that names cannot have.".to_owned());
    }
    let mut taken = names(edit.world);
    for thing in things {
        let name = edit
            .world
            .get::<Name>(thing)
            .map_or_else(String::new, |name| name.as_str().to_owned());
        let leaf = name.rsplit('/').next().unwrap_or_default();
        let wanted = match folder {
            Some(folder) => format!("{folder}/{leaf}"),
            None => leaf.to_owned(),
        };
        if wanted != name {
            let free = free_name(&taken, &wanted);
            call(edit, thing, &free);
            taken.remove(&name);
            taken.insert(free);
        }
    }
    Ok(())
}

/// Only the places between the first and the last of those concerned are dealt out anew.
fn reorder(edit: &mut Edit, moved: &[Entity], before: Option<Entity>) {
    let mut all = edit.world.query::<(&DocumentOrder, Entity)>();
    let mut all: Vec<(DocumentOrder, Entity)> = all.iter(edit.world).map(|(order, entity)| (*order, entity)).collect();
    all.sort();
    let places: Vec<DocumentOrder> = all.iter().map(|(order, _)| *order).collect();
    let mut sequence: Vec<Entity> = all.into_iter().map(|(_, entity)| entity).collect();
    let known: HashSet<Entity> = sequence.iter().copied().collect();
    let moved = moved.iter().copied();
    let moved: Vec<Entity> = moved.filter(|it| known.contains(it) && Some(*it) != before).collect();
    let leaving: HashSet<Entity> = moved.iter().copied().collect();
    sequence.retain(|entity| !leaving.contains(entity));
    let place = before.and_then(|before| sequence.iter().position(|entity| *entity == before));
    let place = place.unwrap_or(sequence.len());
    sequence.splice(place..place, moved);
    for (entity, place) in sequence.into_iter().zip(places) {
        edit.set(entity, place);
    }
}

/// Shapes of the world and lights.
fn visible_things(world: &mut World, mut wanted: impl FnMut(Entity) -> bool) -> Vec<Entity> {
    let mut things =
        world.query_filtered::<Entity, (Or<(With<Shape>, With<Emitter>)>, Without<Hidden>, Without<MemberOf>)>();
    things.iter(world).filter(|entity| wanted(*entity)).collect()
}

fn hide(edit: &mut Edit, entities: &[Entity], hidden: bool) {
    for &entity in entities {
        let can_be = edit.world.get::<Shape>(entity).is_some() || edit.world.get::<Emitter>(entity).is_some();
        match (hidden, can_be) {
            (true, true) => edit.set(entity, Hidden),
            (true, false) => {}
            (false, _) => edit.remove::<Hidden>(entity),
        }
    }
}

pub fn transform(edit: &mut Edit, poses: Vec<(Entity, Affine3A)>) -> Result<(), String> {
    for (entity, pose) in poses {
        if edit.world.get::<Placements>(entity).is_some() {
            return Err("So many instances stay where the file has them.".into());
        }
        if edit.world.get::<Locked>(entity).is_some() {
            return Err("That is locked.".into());
        }
        edit.set(entity, ToWorld(pose));
        // The one who moves the camera wants to see from there.
        if edit.world.resource::<ActiveSensor>().0 == Some(entity) && edit.world.get::<Sensor>(entity).is_some() {
            edit.world.insert_resource(FreeView::default());
        }
    }
    Ok(())
}

/// Looked at as the picture before it; other textures become a plain picture. Lights have one parameter that may be a picture.
fn set_picture(edit: &mut Edit, owner: Entity, parameter: &str, place: SquarePath, path: PathBuf) {
    if let Some(mut edited) = edit.world.get::<Material>(owner).cloned() {
        edited.set_picture(parameter, place, &path);
        edit.set(owner, edited);
    }
    if let Some(mut edited) = edit.world.get::<AreaLight>(owner).cloned() {
        edited.radiance.set_picture_at(place, path.clone());
        edit.set(owner, edited);
    }
    if let Some(mut edited) = edit.world.get::<Emitter>(owner).cloned() {
        edited.set_picture(place, path);
        edit.set(owner, edited);
    }
}

/// Selects what an edit has made.
pub fn select_new(edit: &mut Edit, made: Vec<Entity>) {
    edit.world.resource_mut::<Selection>().extend(made, Extend::Replace);
}
