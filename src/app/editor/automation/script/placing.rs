//! Verbs that place things.

use bevy::prelude::World;

use super::error::ScriptError;
use super::parse::{count as count_of, unknown};
use crate::app::editor::command::Command;
use crate::app::editor::command::arrange::{Reference, Series, Side, Spacing, Way};
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::seeing::AXES;
use crate::app::editor::command::snapping::{SnapTo, Snapping};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::document::value::{parse_float, parse_vec3};

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
    Ok(Command::SetGizmo(GizmoSettings { snap, ..gizmo }))
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
    Ok(Command::Align(axis_of(axis)?, known, to))
}

/// `distribute AXIS SPACING`
pub fn distribute(words: &[&str]) -> Result<Command, ScriptError> {
    let [axis, by] = words else {
        return Err("`distribute` takes other words".into());
    };
    let known = Spacing::ALL.into_iter().find(|(_, name)| name == by);
    let names = || Spacing::ALL.into_iter().map(|(_, name)| name);
    let (known, _) = known.ok_or_else(|| unknown("spacing", by, names()))?;
    Ok(Command::Distribute(axis_of(axis)?, known))
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
    Ok(Command::MakeSeries(Series {
        count: count_of(count)?,
        way,
        instances,
    }))
}

/// The number of an axis, in capitals or not.
pub(super) fn axis_of(name: &str) -> Result<usize, ScriptError> {
    let found = AXES.iter().position(|axis| axis.eq_ignore_ascii_case(name));
    found.ok_or_else(|| unknown("axis", name, AXES))
}
