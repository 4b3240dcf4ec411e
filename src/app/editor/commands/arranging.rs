//! Aligns and distributes the selection, by the bounds of each thing along an axis of the world.

use std::ops::Range;

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::grouping::{self, Unit};
use super::things;
use crate::app::editor::camera::solid::{Solid, solids_of_each};
use crate::app::editor::camera::{picking, rounding, sizing};
use crate::app::editor::command::arrange::{Reference, Side, Spacing};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::PackedScene;
use crate::math::Aabb;
use crate::scene::{Shape, ToWorld, world_bounds};

/// Brings one side of all things in line, along an axis from 0 to 2.
pub fn align(edit: &mut Edit, axis: usize, side: Side, to: Reference) -> Result<(), CommandError> {
    let things = extents(edit, axis)?;
    if things.len() < 2 {
        return Err("Select several things to align them.".into());
    }
    let all = things.iter().skip(1).fold(things[0].1.clone(), |all, (_, extent)| {
        all.start.min(extent.start)..all.end.max(extent.end)
    });
    let reference = match to {
        Reference::Bounds => &all,
        Reference::Active => things.last().map_or(&all, |(_, extent)| extent),
    };
    let goal = at(side, reference);
    let moves = things.iter().map(|(unit, extent)| (unit, goal - at(side, extent)));
    move_along(edit, axis, moves.collect())
}

/// Spaces things evenly along an axis from 0 to 2. The first and the last stay.
pub fn distribute(edit: &mut Edit, axis: usize, by: Spacing) -> Result<(), CommandError> {
    let mut things = extents(edit, axis)?;
    if things.len() < 3 {
        return Err("Select three things or more to distribute them.".into());
    }
    let middle = |extent: &Range<f32>| at(Side::Middle, extent);
    things.sort_by(|(_, a), (_, b)| middle(a).total_cmp(&middle(b)));
    let between = (things.len() - 1) as f32;
    let (first, last) = (things[0].1.clone(), things[things.len() - 1].1.clone());
    let sizes: f32 = things.iter().map(|(_, extent)| extent.end - extent.start).sum();
    let gap = (last.end - first.start - sizes) / between;
    let step = (middle(&last) - middle(&first)) / between;
    let mut start = first.start;
    let mut moves = Vec::new();
    for (number, (unit, extent)) in things.iter().enumerate() {
        let by = match by {
            Spacing::Gaps => start - extent.start,
            Spacing::Middles => middle(&first) + step * number as f32 - middle(extent),
        };
        start += extent.end - extent.start + gap;
        let stays = number == 0 || number + 1 == things.len();
        moves.push((unit, if stays { 0.0 } else { by }));
    }
    move_along(edit, axis, moves)
}

/// Gives each thing that is not turned off the axes of the world a size along one of them, 0 to 2, about its own
/// middle.
pub fn resize(edit: &mut Edit, axis: usize, size: f32) -> Result<(), CommandError> {
    if !(size > 0.0 && size.is_finite()) {
        return Err("A size is above 0.".into());
    }
    let units = grouping::units(edit)?;
    let all: Vec<Entity> = units.iter().flat_map(|unit| unit.all.iter().copied()).collect();
    let mut bounds = picking::bounds_of_each(edit.world.resource::<PackedScene>(), &all).into_iter();
    let mut poses = Vec::new();
    for Unit { lead, all } in units {
        let seen = bounds.by_ref().take(all.len()).flatten().reduce(Aabb::union);
        let world = &*edit.world;
        let (Some(shape), Some(pose)) = (world.get::<Shape>(lead), things::pose_of(world, lead)) else {
            continue;
        };
        let own = || world_bounds(shape, &world.get::<ToWorld>(lead)?.0, None);
        let Some(bounds) = seen.or_else(own) else {
            continue;
        };
        let mut extent = bounds.extent();
        extent[axis.min(2)] = size;
        poses.extend(sizing::scaled(&pose, &bounds, extent, Some(shape)).map(|pose| (lead, pose)));
    }
    let poses = grouping::with_members(edit, poses);
    things::transform(edit, poses)
}

fn at(side: Side, extent: &Range<f32>) -> f32 {
    match side {
        Side::Low => extent.start,
        Side::Middle => 0.5 * (extent.start + extent.end),
        Side::High => extent.end,
    }
}

/// The extent of each selected thing or group that has a place, along an axis; the active one is the last.
fn extents(edit: &mut Edit, axis: usize) -> Result<Vec<(Unit, Range<f32>)>, CommandError> {
    let units = grouping::units(edit)?;
    let all: Vec<Entity> = units.iter().flat_map(|unit| unit.all.iter().copied()).collect();
    let mut extents = extent_of_each(edit.world, &all, Vec3::AXES[axis.min(2)]).into_iter();
    let with_extent = units.into_iter().filter_map(|unit| {
        let mut own: Vec<Option<Range<f32>>> = extents.by_ref().take(unit.all.len()).collect();
        // The last of them is the group's origin, which is no part of its extent.
        if own.len() > 1 {
            own.pop();
        }
        let extent = union(own)?;
        Some((unit, extent))
    });
    Ok(with_extent.collect())
}

/// The extent of several things together.
pub fn union(extents: Vec<Option<Range<f32>>>) -> Option<Range<f32>> {
    let extents = extents.into_iter().flatten();
    extents.reduce(|all, one| all.start.min(one.start)..all.end.max(one.end))
}

/// The extent of each thing along a direction; None for an infinite thing or one without a place.
pub fn extent_of_each(world: &World, things: &[Entity], direction: Vec3) -> Vec<Option<Range<f32>>> {
    let solids = solids_of_each(world.resource::<PackedScene>(), things);
    let each = things.iter().zip(solids);
    each.map(|(thing, solids)| extent(world, *thing, &solids, direction))
        .collect()
}

fn extent(world: &World, thing: Entity, solids: &[Solid], direction: Vec3) -> Option<Range<f32>> {
    let pose = world.get::<ToWorld>(thing)?.0;
    let ends = solids
        .iter()
        .map(|solid| Some(-solid.reach(-direction)..solid.reach(direction)));
    union(ends.collect())
        .or_else(|| {
            let bounds = world_bounds(world.get::<Shape>(thing)?, &pose, None)?;
            let (middle, reach) = (
                bounds.center().dot(direction),
                0.5 * bounds.extent().dot(direction.abs()),
            );
            Some(middle - reach..middle + reach)
        })
        .or_else(|| {
            let place = Vec3::from(pose.translation).dot(direction);
            Some(place..place)
        })
}

fn move_along(edit: &mut Edit, axis: usize, moves: Vec<(&Unit, f32)>) -> Result<(), CommandError> {
    let extent = edit.world.resource::<ViewSettings>().navigation.scene_size;
    let unit = rounding::fine_unit(extent);
    let each = moves
        .into_iter()
        .flat_map(|(unit, by)| unit.all.iter().map(move |entity| (*entity, by)));
    let poses = each.filter_map(|(entity, by)| {
        let pose = things::pose_of(edit.world, entity)?;
        // Things that are in line already keep their numbers.
        let by = rounding::rounded(by, unit);
        let place = rounding::moved(pose.translation.into(), Vec3::AXES[axis.min(2)] * by, unit);
        let translation = place.into();
        Some((entity, Affine3A { translation, ..pose }))
    });
    let poses = poses.collect();
    things::transform(edit, poses)
}
