//! Groups: folders of things, in folders if need be, with a transform of their own. A folder is the part of names
//! before a slash. Its transform is held by an entity without a surface that has the folder's name with a slash behind
//! it; moving this entity moves everything in the folder.

use std::collections::{BTreeSet, HashSet};

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::arranging;
use super::things::{call, is_no_name, pose_of, selected};
use crate::app::editor::camera::rounding;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::{Extend, Selection};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::scene::folders::folders_of;
use crate::scene::free_name::free_name;
use crate::scene::insert::{names, next_order};
use crate::scene::{DocumentOrder, Locked, MemberOf, Placements, SceneId, Shape, ShapeKind, ToWorld};

/// Puts the selection into a new group, inside the innermost group that contains all of it. The new group becomes
/// active.
pub fn group(edit: &mut Edit) -> Result<(), CommandError> {
    let members = selected(edit)?;
    let outer = common_folder(edit.world, &members);
    let wanted = joined(outer.as_deref(), "group");
    let folder = free_name(&folders_of(&names(edit.world)), &wanted);
    let middle = middle(edit.world, &members);
    put_into(edit, members.clone(), Some(&folder))?;
    let Some(middle) = middle else {
        return Ok(());
    };
    let shape = Shape {
        kind: ShapeKind::Frame,
        ..Shape::default()
    };
    let name = format!("{folder}/");
    let order = DocumentOrder(next_order(edit.world));
    let pose = ToWorld(Affine3A::from_translation(middle));
    let frame = edit.spawn((shape, order, SceneId(name.clone()), Name::new(name), pose));
    let all = members.into_iter().chain([frame]);
    edit.world.insert_resource(Selection::of(all));
    edit.world.resource_mut::<Requests>().nameless_group = Some(frame);
    Ok(())
}

/// Moves the members of the selected groups into the group around, and deletes the selected groups.
pub fn ungroup(edit: &mut Edit) -> Result<(), CommandError> {
    let frames: Vec<Entity> = selected(edit)?
        .into_iter()
        .filter(|entity| is_frame(edit.world, *entity))
        .collect();
    // A group inside another one goes with it.
    let paths: Vec<String> = frames.iter().map(|frame| path(edit.world, *frame)).collect();
    let is_inner = |path: &String| paths.iter().any(|outer| path.starts_with(&format!("{outer}/")));
    let outermost: Vec<(Entity, String)> = frames
        .into_iter()
        .zip(paths.iter().cloned())
        .filter(|(_, path)| !is_inner(path))
        .collect();
    if outermost.is_empty() {
        return Err("No group is selected.".into());
    }
    let mut freed = Vec::new();
    for (frame, folder) in outermost {
        let outer = folder.rsplit_once('/').map(|(outer, _)| outer.to_owned());
        let inside = named_within(edit.world, &folder);
        edit.delete(frame);
        let inside: Vec<Entity> = inside.into_iter().filter(|entity| *entity != frame).collect();
        take_out(edit, &inside, &folder, outer.as_deref());
        freed.extend(inside);
    }
    edit.world.insert_resource(Selection::of(freed));
    Ok(())
}

/// Puts things into a folder; groups keep their members.
pub fn put_into(edit: &mut Edit, things: Vec<Entity>, folder: Option<&str>) -> Result<(), CommandError> {
    if folder.is_some_and(|folder| folder.chars().any(is_no_name)) {
        return Err("The folder's name has a character that names cannot have.".into());
    }
    let frames: Vec<String> = things
        .iter()
        .filter(|thing| is_frame(edit.world, **thing))
        .map(|frame| path(edit.world, *frame))
        .collect();
    let carried: HashSet<Entity> = frames
        .iter()
        .flat_map(|frame| named_within(edit.world, frame))
        .collect();
    for frame in &frames {
        // A group inside another one that is moved as well goes with that one.
        if frames.iter().any(|outer| frame.starts_with(&format!("{outer}/"))) {
            continue;
        }
        let leaf = frame.rsplit('/').next().unwrap_or_default();
        if folder.is_some_and(|folder| folder == frame || folder.starts_with(&format!("{frame}/"))) {
            return Err("A group cannot be put into itself.".into());
        }
        rename_folder(edit, frame, &joined(folder, leaf));
    }
    let mut taken = names(edit.world);
    for thing in things {
        let name = name_of(edit.world, thing);
        if carried.contains(&thing) {
            continue;
        }
        let leaf = name.rsplit('/').next().unwrap_or_default();
        let wanted = joined(folder, leaf);
        if wanted != name {
            let free = free_name(&taken, &wanted);
            call(edit, thing, &free);
            taken.remove(&name);
            taken.insert(free);
        }
    }
    Ok(())
}

/// Moves things out of a folder that is dissolved. Folders inside it keep their names, with a number added if a name is
/// taken.
fn take_out(edit: &mut Edit, things: &[Entity], from: &str, to: Option<&str>) {
    let mut folders = BTreeSet::new();
    let mut direct = Vec::new();
    for thing in things {
        let name = name_of(edit.world, *thing);
        let Some(rest) = name.strip_prefix(from).and_then(|rest| rest.strip_prefix('/')) else {
            continue;
        };
        match rest.split_once('/') {
            Some((folder, _)) => _ = folders.insert(folder.to_owned()),
            None => direct.push((*thing, name.clone(), joined(to, rest))),
        }
    }
    let mut taken = names(edit.world);
    for (thing, name, wanted) in direct {
        let free = free_name(&taken, &wanted);
        call(edit, thing, &free);
        taken.remove(&name);
        taken.insert(free);
    }
    for folder in folders {
        rename_folder(edit, &joined(Some(from), &folder), &joined(to, &folder));
    }
}

/// Renames a folder and everything in it. If there is a folder of that name already, it gets a number.
pub fn rename_folder(edit: &mut Edit, from: &str, to: &str) {
    if from == to {
        return;
    }
    let own = format!("{from}/");
    let mut others = names(edit.world);
    others.retain(|name| !name.starts_with(&own));
    let to = free_name(&folders_of(&others), to);
    for thing in named_within(edit.world, from) {
        let name = name_of(edit.world, thing);
        if let Some(rest) = name.strip_prefix(from) {
            call(edit, thing, &format!("{to}{rest}"));
        }
    }
}

/// Adds the poses of the members of moved groups, unless these are moved themselves.
pub fn with_members(edit: &mut Edit, mut poses: Vec<(Entity, Affine3A)>) -> Vec<(Entity, Affine3A)> {
    let frames = poses.iter().filter(|(entity, _)| is_frame(edit.world, *entity));
    let frames: Vec<(Entity, Affine3A)> = frames.copied().collect();
    let extent = edit.world.resource::<ViewSettings>().navigation.scene_size;
    let unit = rounding::fine_unit(extent);
    for (frame, now) in frames {
        let Some(ToWorld(before)) = edit.world.get::<ToWorld>(frame).copied() else {
            continue;
        };
        let change = now * before.inverse();
        let known: HashSet<Entity> = poses.iter().map(|(entity, _)| *entity).collect();
        let is_move = now.matrix3 == before.matrix3;
        let by = rounding::sum_of_places(now.translation.into(), (-before.translation).into());
        for member in members(edit.world, frame) {
            let Some(pose) = pose_of(edit.world, member) else {
                continue;
            };
            if known.contains(&member) || !change.is_finite() {
                continue;
            }
            let moved = if is_move { pose } else { change * pose };
            let place = match is_move {
                true => rounding::moved(pose.translation.into(), by, unit),
                false => rounding::rounded_place(moved.translation.into(), unit),
            };
            let translation = place.into();
            poses.push((member, Affine3A { translation, ..moved }));
        }
    }
    poses
}

/// Things that stay together when each selected thing is placed by itself: a thing alone, or a group with all that is
/// in it.
pub struct Unit {
    /// The thing itself, or the transform of the group.
    pub lead: Entity,
    /// The thing, or everything in the group with its transform last.
    pub all: Vec<Entity>,
}

/// The selected groups and ungrouped things, in the order of the selection.
pub fn units(edit: &mut Edit) -> Result<Vec<Unit>, CommandError> {
    let selected = selected(edit)?;
    Ok(units_of(edit.world, selected))
}

/// The groups among these things with all members, and the ungrouped things.
pub fn units_of(world: &mut World, things: Vec<Entity>) -> Vec<Unit> {
    let frames = things.iter().copied().filter(|entity| is_frame(world, *entity));
    let frames: Vec<Entity> = frames.collect();
    let insides: Vec<HashSet<Entity>> = frames
        .iter()
        .map(|frame| members(world, *frame).into_iter().collect())
        .collect();
    // Groups inside other groups are part of these.
    let is_part = |entity: &Entity| insides.iter().any(|inside| inside.contains(entity));
    let leads = things.into_iter().filter(|entity| !is_part(entity));
    let units = leads.map(|lead| {
        let inside = frames
            .iter()
            .position(|frame| *frame == lead)
            .map(|place| &insides[place]);
        let mut all: Vec<Entity> = inside.into_iter().flatten().copied().collect();
        all.sort();
        all.push(lead);
        Unit { lead, all }
    });
    units.collect()
}

/// Selects the whole innermost group around the active thing that is not fully selected yet; its transform becomes
/// active.
pub fn select_group(world: &mut World) -> Result<(), CommandError> {
    let selection = world.resource::<Selection>().clone();
    let active = selection.active().ok_or("Nothing is selected.")?;
    let name = name_of(world, active);
    let mut folders: Vec<&str> = name.match_indices('/').map(|(end, _)| &name[..end]).collect();
    while let Some(folder) = folders.pop() {
        let mut inside = named_within(world, folder);
        inside.retain(|thing| world.get::<ToWorld>(*thing).is_some());
        if inside.iter().any(|thing| !selection.contains(*thing)) {
            let own = format!("{folder}/");
            inside.sort_by_key(|thing| name_of(world, *thing) == own);
            world.resource_mut::<Selection>().extend(inside, Extend::Replace);
            return Ok(());
        }
    }
    Err("It is in no further group.".into())
}

/// Whether the entity is the transform of a folder.
pub fn is_frame(world: &World, entity: Entity) -> bool {
    world.get::<Shape>(entity).is_some_and(Shape::is_frame)
}

/// The path of the folder whose transform this is.
pub fn path(world: &World, frame: Entity) -> String {
    name_of(world, frame).trim_end_matches('/').to_owned()
}

/// The members that move with a group: everything in its folder that has a place and is not locked.
pub fn members(world: &mut World, frame: Entity) -> Vec<Entity> {
    let mut inside = named_within(world, &path(world, frame));
    let moves = |entity: &Entity| {
        *entity != frame
            && world.get::<ToWorld>(*entity).is_some()
            && world.get::<Locked>(*entity).is_none()
            && world.get::<Placements>(*entity).is_none()
            && world.get::<MemberOf>(*entity).is_none()
    };
    inside.retain(moves);
    inside
}

/// These things, and everything in the groups whose frames are among them. Members stand before their frame, as they
/// are selected.
pub fn whole_groups(world: &mut World, things: Vec<Entity>) -> Vec<Entity> {
    let mut whole = Vec::new();
    let mut known = HashSet::new();
    for thing in things {
        let inside = match is_frame(world, thing) {
            true => named_within(world, &path(world, thing)),
            false => Vec::new(),
        };
        whole.extend(
            inside
                .into_iter()
                .filter(|member| *member != thing && known.insert(*member)),
        );
        if known.insert(thing) {
            whole.push(thing);
        }
    }
    whole
}

/// The things in a folder and in folders inside it, in the order of the file.
pub fn named_within(world: &mut World, folder: &str) -> Vec<Entity> {
    let start = format!("{folder}/");
    let mut things = world.query::<(&DocumentOrder, Entity, &Name)>();
    let found = things.iter(world).filter(|(.., name)| name.starts_with(&start));
    let mut found: Vec<(DocumentOrder, Entity)> = found.map(|(order, entity, _)| (*order, entity)).collect();
    found.sort();
    found.into_iter().map(|(_, entity)| entity).collect()
}

/// The innermost folder that all of these are in.
fn common_folder(world: &World, things: &[Entity]) -> Option<String> {
    let folder = |thing: &Entity| -> Vec<String> {
        let name = name_of(world, *thing);
        let whole = name.trim_end_matches('/');
        let folder = whole.rsplit_once('/').map_or("", |(folder, _)| folder);
        folder
            .split('/')
            .filter(|part| !part.is_empty())
            .map(str::to_owned)
            .collect()
    };
    let common = things.iter().map(folder).reduce(|common, other| {
        let same = common.iter().zip(&other).take_while(|(one, two)| one == two);
        same.map(|(part, _)| part.clone()).collect()
    });
    common.filter(|parts| !parts.is_empty()).map(|parts| parts.join("/"))
}

/// The middle of the bounds of things; None if none has a place.
fn middle(world: &World, things: &[Entity]) -> Option<Vec3> {
    let mut middle = Vec3::ZERO;
    for axis in 0..3 {
        let all = arranging::union(arranging::extent_of_each(world, things, Vec3::AXES[axis]))?;
        middle[axis] = 0.5 * (all.start + all.end);
    }
    let unit = rounding::unit_of_scene(world.resource::<ViewSettings>().navigation.scene_size);
    Some(rounding::rounded_place(middle, unit))
}

fn joined(folder: Option<&str>, leaf: &str) -> String {
    match folder {
        Some(folder) => format!("{folder}/{leaf}"),
        None => leaf.to_owned(),
    }
}

fn name_of(world: &World, thing: Entity) -> String {
    world
        .get::<Name>(thing)
        .map_or_else(String::new, |name| name.as_str().to_owned())
}
