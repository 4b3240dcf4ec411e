//! Adds what was drawn, and changes shapes together with their poses.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::things::{check_name, replace, select_new, transform};
use crate::app::editor::command::blocking::BlockKind;
use crate::app::editor::command::blocking::block::Block;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::Edit;
use crate::scene::free_name::free_name;
use crate::scene::insert::{names, next_order};
use crate::scene::{DocumentOrder, Hidden, MemberOf, SceneId, Shape, ShapeKind, Solid, ToWorld};

pub fn build(edit: &mut Edit, mut block: Block) -> Result<(), CommandError> {
    check_name(block.name.as_deref().unwrap_or_default())?;
    if block.kind == BlockKind::Wall {
        reach_around_corners(edit.world, &mut block);
    }
    let (kind, pose) = block.shape().ok_or("What was drawn has no extent.")?;
    let order = DocumentOrder(next_order(edit.world));
    let name = free_name(&names(edit.world), block.name.as_deref().unwrap_or(block.kind.name()));
    let shape = Shape {
        kind,
        ..Shape::default()
    };
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
    transform(edit, vec![(entity, pose)])?;
    replace(edit, entity, shape)
}

/// A wall that begins or ends where another one does is longer by half a thickness, so that the corner has no notch.
fn reach_around_corners(world: &mut World, block: &mut Block) {
    let Some(direction) = (block.to - block.from).try_normalize() else {
        return;
    };
    // Members of groups are not where their poses say, and hidden walls are not seen.
    let mut shapes = world.query_filtered::<(&Shape, &ToWorld), (Without<MemberOf>, Without<Hidden>)>();
    let ends: Vec<(Vec3, f32)> = shapes
        .iter(world)
        .filter_map(|(shape, ToWorld(pose))| match shape.kind {
            ShapeKind::Solid(Solid::Wall { length, thickness, .. }) => {
                let ends = [Vec3::ZERO, Vec3::X * length].map(|end| pose.transform_point3(end));
                let thickness = thickness * Vec3::from(pose.matrix3.y_axis).length();
                let along = Vec3::from(pose.matrix3.x_axis).normalize_or_zero();
                // A wall that goes on in the same line makes no corner.
                (along.dot(direction).abs() < 0.99).then(|| ends.map(|end| (end, thickness)))
            }
            _ => None,
        })
        .flatten()
        .collect();
    // The other wall may itself reach around its corner by half its thickness.
    let reach = |place: Vec3| {
        let near = ends
            .iter()
            .filter(|(end, thickness)| end.distance(place) <= 0.51 * thickness);
        near.map(|(_, thickness)| 0.5 * thickness).fold(0.0, f32::max)
    };
    let (before, after) = (reach(block.from), reach(block.to));
    block.from -= direction * before;
    block.to += direction * after;
}
