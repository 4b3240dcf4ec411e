//! Verbs that place things.

use bevy::prelude::World;

use super::error::ScriptError;
use super::parse::unknown;
use crate::app::editor::command::Command;
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::snapping::{SnapTo, Snapping};
use crate::app::editor::session::view_settings::ViewSettings;

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
