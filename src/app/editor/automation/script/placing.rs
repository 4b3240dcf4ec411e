//! Verbs that place things.

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::error::ScriptError;
use super::names::{count as count_of, named, unknown};
use super::verb::verbs;
use crate::app::editor::camera::rounding;
use crate::app::editor::command::arrange::{Reference, Series, Side, Spacing, Way};
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::seeing::AXES;
use crate::app::editor::command::snapping::{SnapTo, Snapping};
use crate::app::editor::command::{ArrangeEdit, SceneEdit, ToolCommand, ValueEdit};
use crate::app::editor::commands::things::pose_of;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::document::value::{parse_float, parse_vec3};
use crate::scene::euler::tidied;
use bevy::math::Quat;

verbs! {
    VERBS(world):
    "move" "NAME X,Y,Z (by)" [name, by] => shifted(world, name, parse_vec3(by)?)?;
    "rotate" "NAME X,Y,Z DEGREES (about its origin)"
        [name, axis, degrees] => rotated(world, name, parse_vec3(axis)?, degrees)?;
    "scale" "NAME FACTOR (about its origin)"
        [name, factor] => {
            let factor = Affine3A::from_scale(Vec3::splat(parse_float(factor)?));
            transformed(world, name, |pose| about_origin(factor, pose))?
        };
    "align" "X|Y|Z low|middle|high [active] (what is selected)"
        [axis, side] => align(axis, side, Reference::Bounds)?,
        [axis, side, "active"] => align(axis, side, Reference::Active)?;
    "distribute" "X|Y|Z gaps|middles (what is selected)" [axis, by] => distribute(axis, by)?;
    "resize" "X|Y|Z LENGTH (what is selected)"
        [axis, length] => ArrangeEdit::Resize(axis_of(axis)?, parse_float(length)?);
    "series" "COUNT along X,Y,Z [instances] | COUNT around X|Y|Z DEGREES X,Y,Z (the center) [instances]"
        [count, "along", step, how @ ..] if is_series(how) => series(count, Way::Along(parse_vec3(step)?), how)?,
        [count, "around", axis, degrees, center, how @ ..] if is_series(how) => {
            series(count, around(axis, degrees, center)?, how)?
        };
    "snap" "increments|grid|vertices|edges|faces [always] [align]" [to, how @ ..] => snap(world, to, how)?;
}

fn shifted(world: &mut World, name: &str, by: Vec3) -> Result<ValueEdit, ScriptError> {
    transformed(world, name, |pose| Affine3A {
        translation: rounding::sum_of_places(pose.translation.into(), by).into(),
        ..pose
    })
}

fn rotated(world: &mut World, name: &str, axis: Vec3, degrees: &str) -> Result<ValueEdit, ScriptError> {
    let axis = axis.try_normalize().ok_or("the axis has no length")?;
    let turn = Affine3A::from_quat(Quat::from_axis_angle(axis, parse_float(degrees)?.to_radians()));
    transformed(world, name, |pose| about_origin(turn, pose))
}

fn snap(world: &World, to: &str, how: &[&str]) -> Result<ToolCommand, ScriptError> {
    let names = SnapTo::ALL.map(SnapTo::name);
    let to = SnapTo::of_name(to).ok_or_else(|| unknown("place to snap to", to, names))?;
    if let Some(word) = how.iter().find(|word| !["always", "align"].contains(word)) {
        return Err(unknown("way to snap", word, ["always", "align"]));
    }
    let snap = Snapping {
        to,
        always: how.contains(&"always"),
        aligns: how.contains(&"align"),
    };
    let gizmo = world.resource::<ViewSettings>().gizmo;
    Ok(ToolCommand::SetGizmo(GizmoSettings { snap, ..gizmo }))
}

fn align(axis: &str, side: &str, to: Reference) -> Result<ArrangeEdit, ScriptError> {
    let known = Side::of_name(side).ok_or_else(|| unknown("side", side, Side::ALL.map(Side::name)))?;
    Ok(ArrangeEdit::Align(axis_of(axis)?, known, to))
}

fn distribute(axis: &str, by: &str) -> Result<ArrangeEdit, ScriptError> {
    let known = Spacing::of_name(by).ok_or_else(|| unknown("spacing", by, Spacing::ALL.map(Spacing::name)))?;
    Ok(ArrangeEdit::Distribute(axis_of(axis)?, known))
}

/// Whether the only word is `instances`, if any.
fn is_series(how: &[&str]) -> bool {
    matches!(how, [] | ["instances"])
}

fn around(axis: &str, degrees: &str, center: &str) -> Result<Way, ScriptError> {
    Ok(Way::Around {
        axis: axis_of(axis)?,
        degrees: parse_float(degrees)?,
        center: parse_vec3(center)?,
    })
}

fn series(count: &str, way: Way, how: &[&str]) -> Result<SceneEdit, ScriptError> {
    Ok(SceneEdit::MakeSeries(Series {
        count: count_of(count)?,
        way,
        instances: !how.is_empty(),
    }))
}

/// The index of an axis, in either case.
pub(super) fn axis_of(name: &str) -> Result<usize, ScriptError> {
    let found = AXES.iter().position(|axis| axis.eq_ignore_ascii_case(name));
    found.ok_or_else(|| unknown("axis", name, AXES))
}

fn transformed(
    world: &mut World,
    name: &str,
    change: impl FnOnce(Affine3A) -> Affine3A,
) -> Result<ValueEdit, ScriptError> {
    let entity = named(world, name)?;
    let before = pose_of(world, entity).ok_or("it has no place")?;
    let mut pose = change(before);
    if pose.matrix3 != before.matrix3 {
        pose.matrix3 = tidied(&pose.matrix3);
    }
    Ok(ValueEdit::Transform(vec![(entity, pose)]))
}

fn about_origin(change: Affine3A, pose: Affine3A) -> Affine3A {
    let to_origin = Affine3A::from_translation(pose.translation.into());
    to_origin * change * to_origin.inverse() * pose
}
