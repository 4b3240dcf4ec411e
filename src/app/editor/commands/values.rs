//! Edits that set one component of a thing. An edit of the selection makes the same change to all things of the kind.

use std::collections::HashSet;

use bevy::math::{Affine3A, Mat3A};
use bevy::prelude::*;
use bevy::reflect::PartialReflect;

use super::replacing::forget_keys;
use super::things::{need_surface, pose_of, replace, set_angles, set_pose, transform};
use super::{grouping, materials, media};
use crate::app::editor::command::ValueEdit;
use crate::app::editor::command::conversion::{emitter_turned_into, turned_into};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::lamps::PhotometricValue;
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::model::difference::rounding;
use crate::app::editor::model::gather_light::measures_of;
use crate::app::editor::session::history::{Edit, StepKind};
use crate::photometry::LightUnit;
use crate::scene::carry_over::{Vectors, carry_over};
use crate::scene::{
    AreaLight, Declared, Emitter, ExteriorMedium, InMedium, InteriorMedium, Locked, Material, Medium, MemberOf,
    Placements, Shape, ShapeKind, Solid, UsesMaterial,
};

/// The depth to which nested materials are followed.
const DEEPEST: usize = 4;

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: ValueEdit) -> Result<(), CommandError> {
    set(edit, command, &[])
}

/// Applies the edit, and makes the same change to all selected things of the kind.
pub fn edit_selection(edit: &mut Edit, command: ValueEdit) -> Result<(), CommandError> {
    let selected = edit.world.resource::<Selection>().entities().to_vec();
    set(edit, command, &selected)
}

fn set(edit: &mut Edit, command: ValueEdit, selected: &[Entity]) -> Result<(), CommandError> {
    match command {
        ValueEdit::Transform(poses) => {
            if let [(entity, after)] = poses[..] {
                carry_pose(edit, entity, after, selected);
            }
            move_to(edit, poses)?;
        }
        ValueEdit::Turn(entity, pose, angles) => {
            carry_pose(edit, entity, pose, selected);
            move_to(edit, vec![(entity, pose)])?;
            set_angles(edit, entity, Some(angles));
        }
        ValueEdit::SetShape(entity, shape) => {
            match other_roof(edit, entity, &shape) {
                Some(plugin) => set_roof(edit, plugin, entity, selected),
                None => carry(edit, entity, &shape, selected, |before, after, other| {
                    carry_over(before, after, other, Vectors::ByComponent);
                }),
            }
            replace(edit, entity, shape)?;
        }
        ValueEdit::SetMaterial(entity, material) => {
            let others = materials_like(edit.world, entity, selected);
            carry(edit, entity, &*material, &others, |before, after, other| {
                if before.plugin() == after.plugin() {
                    carry_whole(before, after, other);
                } else if other.plugin() == before.plugin() {
                    *other = turned_into(other, after.plugin());
                }
            });
            replace(edit, entity, *material)?;
            materials::check_sides(edit.world, entity)?;
        }
        ValueEdit::SetMedium(entity, medium) => {
            let others = media_like(edit.world, entity, selected);
            carry(edit, entity, &*medium, &others, carry_whole);
            media::set(edit, entity, *medium)?;
        }
        ValueEdit::SetAreaLight(entity, light) => {
            carry_light(edit, entity, light.as_ref(), selected);
            set_light(edit, entity, light)?;
        }
        ValueEdit::SetEmitter(entity, emitter) => {
            carry(edit, entity, &emitter, selected, |before, after, other| {
                if before.plugin() == after.plugin() {
                    carry_whole(before, after, other);
                } else if other.plugin() == before.plugin() {
                    *other = emitter_turned_into(other, after.plugin());
                }
            });
            replace(edit, entity, emitter)?;
        }
        ValueEdit::Shine(value, parameter, amount) => {
            shine_alike(edit, parameter, &amount, selected);
            set(edit, *value, &[])?;
        }
        ValueEdit::SetSensor(entity, sensor) => {
            carry(edit, entity, &sensor, selected, carry_whole);
            replace(edit, entity, sensor)?;
        }
        ValueEdit::SetFilm(entity, film) => {
            carry(edit, entity, &film, selected, carry_whole);
            replace(edit, entity, film)?;
        }
    }
    Ok(())
}

/// The plugin of a roof that takes the place of a roof of another form; None for other edits of shapes.
fn other_roof(edit: &Edit, entity: Entity, after: &Shape) -> Option<&'static str> {
    let (before, after) = (part_of(edit.world.get::<Shape>(entity)?)?, part_of(after)?);
    let plugin = after.plugin();
    (before.plugin() != plugin && before.roof_as(plugin).is_some()).then_some(plugin)
}

fn part_of(shape: &Shape) -> Option<&Solid> {
    let ShapeKind::Solid(part) = &shape.kind else {
        return None;
    };
    Some(part)
}

/// Gives a roof and the other selected roofs this form. They keep their lengths, and lose the key frames of those that
/// the form does not have.
fn set_roof(edit: &mut Edit, plugin: &str, entity: Entity, selected: &[Entity]) {
    let others = selected.iter().copied().filter(|other| *other != entity);
    for roof in others.chain([entity]) {
        let Some(mut shape) = edit.world.get::<Shape>(roof).cloned() else {
            continue;
        };
        let Some(part) = part_of(&shape).and_then(|part| part.roof_as(plugin)) else {
            continue;
        };
        let mut known = Vec::new();
        part.visit(&mut |info, _| known.push(info.name));
        forget_keys(edit, roof, |name| !known.contains(&name));
        shape.kind = ShapeKind::Solid(part);
        edit.set(roof, shape);
    }
}

fn move_to(edit: &mut Edit, poses: Vec<(Entity, Affine3A)>) -> Result<(), CommandError> {
    edit.kind = StepKind::Move;
    let poses = grouping::with_members(edit, poses);
    transform(edit, poses)
}

fn set_light(edit: &mut Edit, shape: Entity, light: Option<AreaLight>) -> Result<(), CommandError> {
    let Some(light) = light else {
        edit.remove::<AreaLight>(shape);
        return Ok(());
    };
    need_surface(edit, shape)?;
    if edit.world.get::<Shape>(shape).is_some_and(Shape::is_of_curves) {
        return Err("Curves cannot shine: light is not sampled on them.".into());
    }
    if edit.world.get::<MemberOf>(shape).is_some() {
        return Err("Shapes that stand there as instances cannot shine.".into());
    }
    edit.set(shape, light);
    Ok(())
}

/// Applies the coming change of a component of `entity` to the same component of others, by a function of its values
/// before and after and of the other value.
fn carry<C: Component + Clone + PartialEq>(
    edit: &mut Edit,
    entity: Entity,
    after: &C,
    others: &[Entity],
    change: impl Fn(&C, &C, &mut C),
) {
    let Some(before) = edit.world.get::<C>(entity).cloned() else {
        return;
    };
    for &other in others.iter().filter(|other| **other != entity) {
        if let Some(mut changed) = edit.world.get::<C>(other).cloned() {
            change(&before, after, &mut changed);
            edit.set(other, changed);
        }
    }
}

fn carry_whole<C: PartialReflect>(before: &C, after: &C, other: &mut C) {
    carry_over(before, after, other, Vectors::Whole);
}

/// Applies the change of a shape's emission to other shapes.
fn carry_light(edit: &mut Edit, shape: Entity, after: Option<&AreaLight>, others: &[Entity]) {
    let before = edit.world.get::<AreaLight>(shape).cloned();
    for &other in others.iter().filter(|other| **other != shape) {
        if edit.world.get::<Shape>(other).is_none_or(Shape::is_of_curves) {
            continue;
        }
        let known = edit.world.get::<AreaLight>(other).cloned();
        match (&before, after, known) {
            (_, None, _) => edit.remove::<AreaLight>(other),
            (None, Some(after), None) => edit.set(other, after.clone()),
            (Some(before), Some(after), Some(mut changed)) => {
                carry_whole(before, after, &mut changed);
                edit.set(other, changed);
            }
            (Some(_), Some(_), None) | (None, Some(_), Some(_)) => {}
        }
    }
}

/// Gives lights this amount, each by its own measures. Those that have none in the unit, or cannot be so bright, stay.
fn shine_alike(edit: &mut Edit, parameter: &str, amount: &PhotometricValue, lights: &[Entity]) {
    let is_flux = amount.amount.is_some_and(|(_, unit)| unit == LightUnit::Lumen);
    let parameter = Some(parameter).filter(|_| !is_flux);
    for &light in lights {
        let measures = measures_of(edit.world, light);
        if let Some(mut emitter) = edit.world.get::<Emitter>(light).cloned() {
            if amount.apply(&mut emitter, &measures, parameter).is_ok() {
                edit.set(light, emitter);
            }
        } else if let Some(mut area) = edit.world.get::<AreaLight>(light).cloned()
            && amount.apply(&mut area, &measures, parameter).is_ok()
        {
            edit.set(light, area);
        }
    }
}

/// Applies a change of pose: changed coordinates are set to the same number, and each thing is turned and scaled about
/// its own position.
fn carry_pose(edit: &mut Edit, entity: Entity, after: Affine3A, others: &[Entity]) {
    let others: Vec<Entity> = others.iter().copied().filter(|other| *other != entity).collect();
    let others = moved_by_themselves(edit.world, entity, others);
    let Some(before) = pose_of(edit.world, entity) else {
        return;
    };
    let middle = edit.world.get::<Shape>(entity).map_or(Vec3::ZERO, Shape::middle);
    let rounding = rounding(&before, middle);
    let turn = before.matrix3.inverse() * after.matrix3;
    let turn = if turn.is_finite() && before.matrix3 != after.matrix3 {
        turn
    } else {
        Mat3A::IDENTITY
    };
    let mut poses = Vec::new();
    for other in others {
        let stays = edit.world.get::<Locked>(other).is_some() || edit.world.get::<Placements>(other).is_some();
        let Some(mut pose) = pose_of(edit.world, other).filter(|_| !stays) else {
            continue;
        };
        pose.matrix3 *= turn;
        for axis in 0..3 {
            if (before.translation[axis] - after.translation[axis]).abs() > rounding[axis] {
                pose.translation[axis] = after.translation[axis];
            }
        }
        poses.push((other, pose));
    }
    for (other, pose) in grouping::with_members(edit, poses) {
        set_pose(edit, other, pose);
    }
}

/// The others, without members of groups among them, which move with their group, and without groups that contain the
/// thing itself.
fn moved_by_themselves(world: &mut World, thing: Entity, others: Vec<Entity>) -> Vec<Entity> {
    if others.is_empty() {
        return others;
    }
    let all = others.iter().copied().chain([thing]);
    let frames: Vec<Entity> = all.filter(|entity| grouping::is_frame(world, *entity)).collect();
    let mut left_out = HashSet::new();
    for frame in frames {
        let folder = grouping::path(world, frame);
        let mut inside = grouping::named_within(world, &folder);
        inside.retain(|entity| *entity != frame);
        match inside.contains(&thing) {
            true => _ = left_out.insert(frame),
            false => left_out.extend(inside),
        }
    }
    others.into_iter().filter(|other| !left_out.contains(other)).collect()
}

/// The materials at the same path as this one within the materials of other selected things.
fn materials_like(world: &World, material: Entity, selected: &[Entity]) -> Vec<Entity> {
    let whole = |entity: Entity| match world.get::<UsesMaterial>(entity) {
        Some(uses) => Some(uses.0),
        None => world.get::<Material>(entity).map(|_| entity),
    };
    let wholes: Vec<Entity> = selected.iter().copied().filter_map(whole).collect();
    let Some(path) = wholes.iter().find_map(|from| path_to(world, *from, material, DEEPEST)) else {
        return Vec::new();
    };
    let mut found: Vec<Entity> = wholes.iter().filter_map(|from| follow(world, *from, &path)).collect();
    found.sort();
    found.dedup();
    found.retain(|other| *other != material);
    found
}

/// The media on the same side of other selected things as this one has on its own.
fn media_like(world: &World, medium: Entity, selected: &[Entity]) -> Vec<Entity> {
    let in_place: [fn(&World, Entity) -> Option<Entity>; 4] = [
        |world, thing| world.get::<Medium>(thing).map(|_| thing),
        |world, thing| world.get::<InteriorMedium>(thing).map(|medium| medium.0),
        |world, thing| world.get::<ExteriorMedium>(thing).map(|medium| medium.0),
        |world, thing| world.get::<InMedium>(thing).map(|medium| medium.0),
    ];
    let all =
        |place: fn(&World, Entity) -> Option<Entity>| selected.iter().filter_map(move |thing| place(world, *thing));
    let place = in_place.into_iter().find(|place| all(*place).any(|it| it == medium));
    let mut found: Vec<Entity> = place.map_or(Vec::new(), |place| all(place).collect());
    found.sort();
    found.dedup();
    found.retain(|other| *other != medium);
    found
}

/// The path from one material to another nested in it.
fn path_to(world: &World, from: Entity, to: Entity, deepest: usize) -> Option<Vec<usize>> {
    if from == to {
        return Some(Vec::new());
    }
    let deepest = deepest.checked_sub(1)?;
    materials_inside(world, from)
        .into_iter()
        .enumerate()
        .find_map(|(place, inner)| {
            let mut path = path_to(world, inner, to, deepest)?;
            path.insert(0, place);
            Some(path)
        })
}

fn follow(world: &World, from: Entity, path: &[usize]) -> Option<Entity> {
    path.iter().try_fold(from, |material, place| {
        materials_inside(world, material).get(*place).copied()
    })
}
