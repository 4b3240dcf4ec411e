//! The verbs that move the view, and undo and redo.

use bevy::math::{Affine3A, Mat3};
use bevy::prelude::*;

use super::error::ScriptError;
use super::names::{count, named};
use super::verb::verbs;
use crate::app::editor::camera::navigation::scale_of;
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::command::{HistoryCommand, ViewCommand};
use crate::document::value::parse_vec3;

verbs! {
    VERBS(world):
    "look" "FROM AT (each X,Y,Z)"
        [from, at] => {
            // The extent that an orthographic camera sees stays the same.
            let extent = view_pose(world).map_or(Vec3::ONE, |pose| scale_of(&pose));
            let pose = looking(parse_vec3(from)?, parse_vec3(at)?)?;
            ViewCommand::MoveView(pose * Affine3A::from_scale(extent))
        };
    "look-through" "CAMERA" [camera] => ViewCommand::LookThrough(named(world, camera)?);
    "go-to" "STEP (of the history)" [step] => HistoryCommand::GoTo(count(step)? as usize);
}

fn looking(from: Vec3, at: Vec3) -> Result<Affine3A, ScriptError> {
    let forward = (at - from).try_normalize().ok_or("the two places are the same")?;
    let up = if forward.y.abs() > 0.999 { Vec3::Z } else { Vec3::Y };
    let left = up.cross(forward).normalize();
    let axes = Mat3::from_cols(left, forward.cross(left), forward);
    Ok(Affine3A::from_mat3_translation(axes, from))
}
