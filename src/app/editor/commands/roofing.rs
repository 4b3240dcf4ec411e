//! Puts a roof over the selection.

use bevy::math::{Affine3A, Mat3};
use bevy::prelude::*;

use super::arranging::{extent_of_each, union};
use super::grouping;
use super::things::select_new;
use crate::app::editor::camera::rounding;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::scene::insert::next_order;
use crate::scene::names::free_name_for;
use crate::scene::{DocumentOrder, SceneId, Shape, ShapeKind, Solid, ToWorld};

/// The extents of houses whose roofs have the usual overhang and thickness, in world units.
const HOUSES: std::ops::RangeInclusive<f32> = 1.5..=80.0;
const TOO_NARROW: &str = "The selection has no extent that a roof could cover.";
/// The digits of the rise of the slopes.
const DIGITS: i32 = 2;

/// Adds a roof, one of [`Solid::PLUGINS`], over the box around the selection. Its sides are parallel to the shape that
/// was selected last, and the ridge runs along the longer side.
pub fn cover(edit: &mut Edit, plugin: &'static str) -> Result<(), CommandError> {
    let units = grouping::units(edit)?;
    let lead = units.last().map(|unit| unit.lead);
    let mut covered: Vec<Entity> = units.into_iter().flat_map(|unit| unit.all).collect();
    covered.retain(|entity| edit.world.get::<Shape>(*entity).is_some_and(|shape| !shape.is_frame()));
    let up = edit.world.resource::<ViewSettings>().navigation.up;
    let along = lead.and_then(|lead| level_axis(edit.world, lead, up));
    let along = along.unwrap_or_else(|| up.any_orthonormal_vector());
    let mut axes = [along, up.cross(along), up];
    let mut spans = Vec::new();
    for axis in axes {
        let span = union(extent_of_each(edit.world, &covered, axis));
        spans.push(span.ok_or("Select walls or a floor, which the roof covers then.")?);
    }
    let size = |axis: usize| spans[axis].end - spans[axis].start;
    if !(size(0) > 0.0 && size(1) > 0.0) {
        return Err(TOO_NARROW.into());
    }
    let is_long = size(0) >= size(1);
    let (long, short) = if is_long {
        (size(0), size(1))
    } else {
        (size(1), size(0))
    };
    let middle = |axis: usize| 0.5 * (spans[axis].start + spans[axis].end);
    let place = axes[0] * middle(0) + axes[1] * middle(1) + up * spans[2].end;
    if !is_long {
        axes = [axes[1], -axes[0], up];
    }
    // A small thing in a large scene gets a roof of its own size.
    let unit = rounding::unit_of_scene(long);
    let pose = Affine3A::from_mat3_translation(
        Mat3::from_cols(axes[0], axes[1], axes[2]),
        rounding::rounded_place(place, unit),
    );
    let [long, short] = [long, short].map(|size| rounding::rounded(size, unit));
    if short <= 0.0 {
        return Err(TOO_NARROW.into());
    }
    let part = roof(plugin, long, short).ok_or_else(|| format!("There is no roof called \"{plugin}\"."))?;
    let name = free_name_for(edit.world, "roof");
    let order = DocumentOrder(next_order(edit.world));
    let shape = Shape {
        kind: ShapeKind::Solid(part),
        ..Shape::default()
    };
    let roof = edit.spawn((order, SceneId(name.clone()), Name::new(name), shape, ToWorld(pose)));
    select_new(edit, vec![roof]);
    Ok(())
}

/// The level axis of a thing that is nearest to its own x axis.
fn level_axis(world: &World, thing: Entity, up: Vec3) -> Option<Vec3> {
    let pose = world.get::<ToWorld>(thing)?.0;
    let columns = [0, 1, 2].map(|axis| Vec3::from(pose.matrix3.col(axis)));
    let level = columns.map(|column| column.reject_from_normalized(up).try_normalize());
    let is_level = |axis: &usize| columns[*axis].normalize_or_zero().dot(up).abs() < 0.5;
    let axis = (0..3).find(is_level)?;
    // A direction of the world stays one.
    level[axis].map(|axis| {
        let nearest = Vec3::AXES.into_iter().find(|known| known.dot(axis).abs() > 0.99999);
        nearest.unwrap_or(axis)
    })
}

/// A roof over a rectangle, whose slopes rise by about 35 degrees, or 15 if there is one slope.
fn roof(plugin: &str, width: f32, depth: f32) -> Option<Solid> {
    let usual = Solid::of_plugin(plugin).filter(|part| part.roof().is_some())?;
    let factor = if HOUSES.contains(&depth) { 1.0 } else { depth / 5.0 };
    let mut part = usual.scaled(factor);
    let rise = rounding::with_digits(0.35 * depth, DIGITS);
    match &mut part {
        Solid::GableRoof {
            width: w,
            depth: d,
            height,
            ..
        }
        | Solid::HipRoof {
            width: w,
            depth: d,
            height,
            ..
        } => (*w, *d, *height) = (width, depth, rise),
        Solid::ShedRoof {
            width: w,
            depth: d,
            height,
            ..
        } => (*w, *d, *height) = (width, depth, rounding::with_digits(0.27 * depth, DIGITS)),
        Solid::Wall { .. } | Solid::Stairs { .. } | Solid::Prism { .. } => return None,
    }
    Some(part)
}
