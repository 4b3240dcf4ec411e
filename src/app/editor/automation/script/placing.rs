//! Verbs that place things.

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::error::ScriptError;
use super::names::{count as count_of, named, unknown};
use crate::app::editor::command::arrange::{Reference, Series, Side, Spacing, Way};
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::seeing::AXES;
use crate::app::editor::command::snapping::{SnapTo, Snapping};
use crate::app::editor::command::{ArrangeEdit, Command, SceneEdit, ToolCommand, ValueEdit};
use crate::app::editor::commands::things::pose_of;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::document::value::{parse_float, parse_vec3};
use crate::scene::euler::tidied;

/// `snap TO [always] [align]`
pub fn snap(world: &World, to: &str, how: &[&str]) -> Result<Command, ScriptError> {
    let names = || SnapTo::ALL.into_iter().map(|(_, name, _)| name);
    let known = SnapTo::ALL.into_iter().find(|(_, name, _)| *name == to);
    let (to, ..) = known.ok_or_else(|| unknown("place to snap to", to, names()))?;
    if let Some(word) = how.iter().find(|word| !["always", "align"].contains(word)) {
        return Err(unknown("way to snap", word, ["always", "align"]));
    }
    let snap = Snapping {
        to,
        always: how.contains(&"always"),
        aligns: how.contains(&"align"),
    };
    let gizmo = world.resource::<ViewSettings>().gizmo;
    Ok(ToolCommand::SetGizmo(GizmoSettings { snap, ..gizmo }).into())
}

/// `align AXIS SIDE [active]`
pub fn align(words: &[&str]) -> Result<Command, ScriptError> {
    let (axis, side, to) = match words {
        [axis, side] => (axis, side, Reference::Bounds),
        [axis, side, "active"] => (axis, side, Reference::Active),
        _ => return Err("`align` takes other words".into()),
    };
    let known = Side::ALL.into_iter().find(|(_, name)| name == side);
    let (known, _) = known.ok_or_else(|| unknown("side", side, Side::ALL.into_iter().map(|(_, name)| name)))?;
    Ok(ArrangeEdit::Align(axis_of(axis)?, known, to).into())
}

/// `distribute AXIS SPACING`
pub fn distribute(words: &[&str]) -> Result<Command, ScriptError> {
    let [axis, by] = words else {
        return Err("`distribute` takes other words".into());
    };
    let known = Spacing::ALL.into_iter().find(|(_, name)| name == by);
    let names = || Spacing::ALL.into_iter().map(|(_, name)| name);
    let (known, _) = known.ok_or_else(|| unknown("spacing", by, names()))?;
    Ok(ArrangeEdit::Distribute(axis_of(axis)?, known).into())
}

/// `series COUNT along STEP [instances]` or `series COUNT around AXIS DEGREES CENTER [instances]`
pub fn series(words: &[&str]) -> Result<Command, ScriptError> {
    let (words, instances) = match words {
        [words @ .., "instances"] => (words, true),
        words => (words, false),
    };
    let (count, way) = match words {
        [count, "along", step] => (count, Way::Along(parse_vec3(step)?)),
        [count, "around", axis, degrees, center] => {
            let way = Way::Around {
                axis: axis_of(axis)?,
                degrees: parse_float(degrees)?,
                center: parse_vec3(center)?,
            };
            (count, way)
        }
        _ => return Err("`series` takes other words".into()),
    };
    Ok(SceneEdit::MakeSeries(Series {
        count: count_of(count)?,
        way,
        instances,
    })
    .into())
}

/// The number of an axis, in capitals or not.
pub(super) fn axis_of(name: &str) -> Result<usize, ScriptError> {
    let found = AXES.iter().position(|axis| axis.eq_ignore_ascii_case(name));
    found.ok_or_else(|| unknown("axis", name, AXES))
}

pub(super) fn transformed(
    world: &mut World,
    name: &str,
    change: impl FnOnce(Affine3A) -> Affine3A,
) -> Result<Command, ScriptError> {
    let entity = named(world, name)?;
    let before = pose_of(world, entity).ok_or("it has no place")?;
    let mut pose = change(before);
    if pose.matrix3 != before.matrix3 {
        pose.matrix3 = tidied(&pose.matrix3);
    }
    Ok(ValueEdit::Transform(vec![(entity, pose)]).into())
}

pub(super) fn about_origin(change: Affine3A, pose: Affine3A) -> Affine3A {
    let to_origin = Affine3A::from_translation(pose.translation.into());
    to_origin * change * to_origin.inverse() * pose
}

pub(super) fn looking(from: Vec3, at: Vec3) -> Result<Affine3A, ScriptError> {
    let forward = (at - from).try_normalize().ok_or("the two places are the same")?;
    let up = if forward.y.abs() > 0.999 { Vec3::Z } else { Vec3::Y };
    let left = up.cross(forward).normalize();
    let axes = bevy::math::Mat3::from_cols(left, forward.cross(left), forward);
    Ok(Affine3A::from_mat3_translation(axes, from))
}
