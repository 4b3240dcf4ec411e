//! Adds drawn blocks, and changes shapes together with their poses.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::things::{check_name, replace, select_new, transform};
use crate::app::editor::camera::rounding;
use crate::app::editor::command::blocking::BlockKind;
use crate::app::editor::command::blocking::block::Block;
use crate::app::editor::command::blocking::faces::pushed;
use crate::app::editor::command::blocking::joints::{StandingWall, joints};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::Edit;
use crate::scene::insert::next_order;
use crate::scene::names::free_name_for;
use crate::scene::{DocumentOrder, Hidden, Locked, MemberOf, SceneId, Shape, ShapeKind, Solid, ToWorld};

pub fn build(edit: &mut Edit, mut block: Block) -> Result<(), CommandError> {
    check_name(block.name.as_deref().unwrap_or_default())?;
    if block.kind == BlockKind::Wall {
        join(edit, &mut block)?;
    }
    let (kind, pose) = block.shape().ok_or("What was drawn has no extent.")?;
    let order = DocumentOrder(next_order(edit.world));
    let name = free_name_for(edit.world, block.name.as_deref().unwrap_or(block.kind.name()));
    let shape = Shape {
        kind,
        ..Shape::default()
    };
    let (shape, pose) = short(shape, pose);
    let called = (order, SceneId(name.clone()), Name::new(name));
    let entity = edit.spawn((called, shape, ToWorld(pose)));
    select_new(edit, vec![entity]);
    Ok(())
}

pub fn reshape(edit: &mut Edit, entity: Entity, shape: Shape, pose: Affine3A) -> Result<(), CommandError> {
    if let ShapeKind::Solid(Solid::Wall { openings, .. }) = &shape.kind
        && openings.len() > Solid::MOST_OPENINGS
    {
        return Err(format!("A wall has at most {} openings.", Solid::MOST_OPENINGS).into());
    }
    let (shape, pose) = short(shape, pose);
    transform(edit, vec![(entity, pose)])?;
    replace(edit, entity, shape)
}

/// The shape and pose rounded to few digits, so that a file says 9.2 where arithmetic gives 9.200001.
fn short(mut shape: Shape, mut pose: Affine3A) -> (Shape, Affine3A) {
    /// Lengths below this share of the unit are rounding residue: well above what arithmetic adds, well below what one
    /// sees.
    const RESIDUE: f32 = 1e-5;
    let own = match &mut shape.kind {
        ShapeKind::Solid(part) => {
            let [low, high] = part.corners();
            let extent = low.abs().max(high.abs()).max_element();
            let unit = rounding::unit_below(RESIDUE * extent);
            part.visit_lengths(&mut |length| {
                let short = rounding::rounded(*length, unit);
                // A length smaller than the unit is deliberate.
                if short != 0.0 {
                    *length = short;
                }
            });
            extent
        }
        _ => 1.0,
    };
    let columns = [pose.matrix3.x_axis, pose.matrix3.y_axis, pose.matrix3.z_axis];
    let extent = columns
        .map(|column| own * column.length())
        .into_iter()
        .fold(0.0, f32::max);
    let place = Vec3::from(pose.translation);
    let unit = rounding::unit_below(RESIDUE * extent.max(place.abs().max_element()));
    pose.translation = rounding::rounded_place(place, unit).into();
    (shape, pose)
}

/// Joins a new wall to existing ones at its ends.
fn join(edit: &mut Edit, block: &mut Block) -> Result<(), CommandError> {
    // The pose of a member of a group is not its place in the world, and hidden walls are not seen.
    type Free = (Without<MemberOf>, Without<Hidden>);
    let mut shapes = edit.world.query_filtered::<(Entity, &Shape, &ToWorld), Free>();
    let walls: Vec<StandingWall> = shapes
        .iter(edit.world)
        .filter_map(|(entity, shape, ToWorld(pose))| StandingWall::of(entity, &shape.kind, pose))
        .collect();
    let joints = joints(block, &walls);
    block.lengthen(joints.outwards);
    for (entity, face, by) in joints.pushes {
        if edit.world.get::<Locked>(entity).is_some() {
            continue;
        }
        let (Some(shape), Some(ToWorld(pose))) = (edit.world.get::<Shape>(entity), edit.world.get::<ToWorld>(entity))
        else {
            continue;
        };
        if let Some((kind, pose)) = pushed(&shape.kind, pose, face, by) {
            let shape = Shape { kind, ..shape.clone() };
            reshape(edit, entity, shape, pose)?;
        }
    }
    Ok(())
}
