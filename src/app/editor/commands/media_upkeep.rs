//! Keeps media right when entities are edited: volumes move with the shapes that they fill, and media go with their
//! borders.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::media::{set_side, spawn};
use super::things::{pose_in, pose_of};
use super::world::tell;
use crate::app::editor::command::media::MediumSide;
use crate::app::editor::session::history::Edit;
use crate::engine::PackedScene;
use crate::scene::medium::{InteriorOf, users_of_medium};
use crate::scene::{
    Emitter, ExteriorMedium, InMedium, IntegratorSettings, InteriorMedium, Keys, Medium, ObjectState, PathPlugin,
    Sensor, ToWorld,
};

/// Completes an edit, at its end: volumes move with the shapes that they fill, a medium without borders surrounds
/// nothing, cameras and lights that have crossed borders get the medium behind them, and the integrator traces media as
/// soon as an entity has one.
pub fn follow(edit: &mut Edit) {
    carry_volumes(edit);
    leave_borderless(edit);
    cross_borders(edit);
    let is_new = |edit: &Edit| {
        edit.touched().any(|(entity, before)| {
            let has = |now: bool, before: bool| now && !before;
            has(
                edit.world.get::<InteriorMedium>(entity).is_some(),
                before.interior.is_some(),
            ) || has(
                edit.world.get::<ExteriorMedium>(entity).is_some(),
                before.exterior.is_some(),
            ) || has(edit.world.get::<InMedium>(entity).is_some(), before.in_medium.is_some())
        })
    };
    if is_new(edit) {
        trace(edit.world, 0);
    }
}

/// Makes the integrator trace media, with paths of at least `depth` segments, and shows a message about the change.
pub fn trace(world: &mut World, depth: u32) {
    let before = world.get_resource::<IntegratorSettings>().copied().unwrap_or_default();
    let mut after = before;
    if !before.plugin.traces_media() {
        after.plugin = PathPlugin::VolPath;
    }
    after.max_depth = before.max_depth.map(|most| most.max(depth));
    if after == before {
        return;
    }
    world.insert_resource(after);
    if after.plugin != before.plugin {
        tell(
            world,
            "The integrator was changed from `path` to `volpath`, which renders fog and other media.",
        );
    }
    if after.max_depth != before.max_depth {
        let text =
            format!("Paths have up to {depth} segments now, because light is scattered often below the surface.");
        tell(world, text);
    }
}

/// A shape that has moved, with the medium inside of it.
struct Carried {
    medium: Entity,
    shape: Entity,
    before: Affine3A,
    after: Affine3A,
}

/// Moves the volumes of media with the shapes that they fill, if all these shapes have moved alike.
fn carry_volumes(edit: &mut Edit) {
    let moved = edit.touched().filter_map(|(shape, before)| {
        let medium = edit.world.get::<InteriorMedium>(shape)?;
        let [old, new] = [pose_in(before)?, pose_of(edit.world, shape)?];
        let is_carried = old != new && before.interior == Some(*medium) && edit.world.get::<Keys>(shape).is_none();
        is_carried.then_some(Carried {
            medium: medium.0,
            shape,
            before: old,
            after: new,
        })
    });
    let moved: Vec<Carried> = moved.collect();
    let edited = edit.touched().filter(|(_, before)| before.medium.is_some());
    let edited: Vec<Entity> = edited.map(|(medium, _)| medium).collect();
    let mut done: Vec<Entity> = edited;
    for first in &moved {
        if done.contains(&first.medium) {
            continue;
        }
        done.push(first.medium);
        let step = |of: &Carried| of.after * of.before.inverse();
        let own: Vec<&Carried> = moved.iter().filter(|other| other.medium == first.medium).collect();
        let users = edit.world.get::<InteriorOf>(first.medium);
        let users = users.into_iter().flat_map(|users| users.iter());
        let mut users = users.filter(|user| ObjectState::is_in_scene(edit.world, *user));
        let have_all_moved = users.all(|user| own.iter().any(|moved| moved.shape == user));
        let is_one_step = own.iter().all(|other| step(other).abs_diff_eq(step(first), ALIKE));
        if let (true, true, Some(medium)) = (have_all_moved, is_one_step, edit.world.get::<Medium>(first.medium))
            && medium.has_place()
        {
            let carried = self::moved(medium, &first.before, &first.after);
            edit.set(first.medium, carried);
        }
    }
}

/// When the last shape filled with a medium is deleted or refilled, entities in that medium get the medium that is
/// there now.
fn leave_borderless(edit: &mut Edit) {
    let emptied = edit.touched().filter_map(|(shape, before)| {
        let medium = before.interior?.0;
        let now = edit.world.get::<InteriorMedium>(shape).map(|now| now.0);
        let around = before.exterior.map(|around| around.0);
        let is_borderless = edit
            .world
            .get::<InteriorOf>(medium)
            .is_none_or(|shapes| shapes.is_empty());
        let instead = now
            .or(around)
            .filter(|medium| ObjectState::is_in_scene(edit.world, *medium));
        is_borderless.then_some((medium, instead))
    });
    let emptied: Vec<(Entity, Option<Entity>)> = emptied.collect();
    for (medium, instead) in emptied {
        let surrounded: Vec<Entity> = users_of_medium(edit.world, medium).collect();
        for thing in surrounded {
            let side = match edit.world.get::<ExteriorMedium>(thing) {
                Some(_) => MediumSide::Exterior,
                None => MediumSide::Around,
            };
            set_side(edit, thing, side, instead);
        }
    }
}

/// Updates the medium of cameras and lights that have crossed borders of media, unless borders have moved as well.
fn cross_borders(edit: &mut Edit) {
    let mut moved = Vec::new();
    for (thing, before) in edit.touched() {
        let (Some(old), Some(new)) = (pose_in(before), pose_of(edit.world, thing)) else {
            continue;
        };
        if old == new {
            continue;
        }
        let thing_now = edit.world.entity(thing);
        if thing_now.contains::<InteriorMedium>() || thing_now.contains::<ExteriorMedium>() {
            return;
        }
        let is_in_space = thing_now.contains::<Sensor>() || thing_now.contains::<Emitter>();
        let around = thing_now.get::<InMedium>().copied();
        if is_in_space && around == before.in_medium && !thing_now.contains::<Keys>() {
            moved.push((thing, around, [old, new].map(|pose| Vec3::from(pose.translation))));
        }
    }
    for (thing, before, [old, new]) in moved {
        let packed = edit.world.get_resource::<PackedScene>();
        let before = before.map(|before| before.0);
        let now = packed.map_or(before, |packed| packed.medium_at(old, before, new));
        if now != before {
            set_side(edit, thing, MediumSide::Around, now);
        }
    }
}

/// The medium at a point of world space, found by walking from a sensor and its known medium.
pub fn medium_at(world: &World, sensor: Entity, place: Vec3) -> Option<Entity> {
    let medium = world.get::<InMedium>(sensor).map(|medium| medium.0);
    match world.get::<ToWorld>(sensor) {
        Some(ToWorld(pose)) => (world.resource::<PackedScene>()).medium_at(pose.translation.into(), medium, place),
        None => medium,
    }
}

/// The largest difference of two moves that count as equal.
const ALIKE: f32 = 1e-4;

/// The medium with its volumes moved as a shape whose pose changed from `before` to `after`.
fn moved(medium: &Medium, before: &Affine3A, after: &Affine3A) -> Medium {
    let by = *after * before.inverse();
    let mut moved = medium.clone();
    let filling = *before * cube_from_unit();
    let size = filling
        .matrix3
        .to_cols_array()
        .into_iter()
        .fold(0.0f32, |most, it| most.max(it.abs()));
    moved.for_each_place(&mut |to_world| {
        // A grid that fills a cube fills it exactly, however often that is moved.
        *to_world = match to_world.abs_diff_eq(filling, ALIKE * size) {
            true => *after * cube_from_unit(),
            false => by * *to_world,
        };
    });
    moved
}

/// The space of the shape `cube` from the unit cube, which volumes fill.
pub fn cube_from_unit() -> Affine3A {
    Affine3A::from_translation(Vec3::NEG_ONE) * Affine3A::from_scale(Vec3::splat(2.0))
}

/// A copy of a medium whose volumes were moved by a step in the world, for a copy of the shape that it fills. None for
/// a homogeneous medium: the copies share it.
pub fn copied_with_place(edit: &mut Edit, medium: Entity, before: &Affine3A, after: &Affine3A) -> Option<Entity> {
    let own = edit.world.get::<Medium>(medium).filter(|medium| medium.has_place())?;
    let copy = moved(own, before, after);
    let name = edit.world.get::<Name>(medium).map_or("medium", Name::as_str).to_owned();
    Some(spawn(edit, &name, copy))
}
