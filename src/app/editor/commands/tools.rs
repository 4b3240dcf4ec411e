//! Commands about the tools for clicks and drags in the picture.

use bevy::prelude::*;

use super::{light_paint, texturing};
use crate::app::editor::command::ToolCommand;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::ruler::MOST_RULERS;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::picture::lamp_light::LampFollower;
use crate::app::editor::picture::paths::PathInspector;
use crate::app::editor::session::view_settings::ViewSettings;

/// Applies the command.
pub fn apply(world: &mut World, command: ToolCommand) -> Result<(), CommandError> {
    match command {
        ToolCommand::SetTool(tool) => {
            if tool == Tool::PlaceTexture {
                texturing::need_textures(world)?;
            }
            if tool == Tool::PaintLight {
                // The panel has the brush and the lamps.
                light_paint::keep_lamps_apart(world);
            }
            if tool.blocks_out() {
                keep_step(world);
            }
            let before = std::mem::replace(&mut world.resource_mut::<ViewSettings>().tool, tool);
            if before == Tool::Paths && tool == Tool::Select {
                world.resource_mut::<PathInspector>().wanted = None;
            }
        }
        ToolCommand::AddRuler(ruler) => {
            let rulers = &mut world.resource_mut::<ViewSettings>().rulers;
            rulers.push(ruler);
            let dropped = rulers.len().saturating_sub(MOST_RULERS);
            rulers.drain(..dropped);
        }
        ToolCommand::ClearRulers => world.resource_mut::<ViewSettings>().rulers.clear(),
        ToolCommand::InspectPaths(wanted) => world.resource_mut::<PathInspector>().wanted = wanted,
        ToolCommand::FollowLamp(lamp) => world.resource_mut::<LampFollower>().lamp = lamp,
        ToolCommand::SetGizmo(gizmo) => set_gizmo(world, gizmo),
    }
    Ok(())
}

/// Fixes the step that suits the scene now, unless one was chosen: it stays the same while this scene grows.
fn keep_step(world: &mut World) {
    let mut settings = world.resource_mut::<ViewSettings>();
    settings.building_step = Some(settings.length_step());
}

/// Sets the gizmo. Removing the chosen step of lengths also drops the fixed one, so that the step suits the scene as it
/// is now.
fn set_gizmo(world: &mut World, gizmo: GizmoSettings) {
    let mut settings = world.resource_mut::<ViewSettings>();
    if settings.gizmo.steps.length.is_some() && gizmo.steps.length.is_none() {
        settings.building_step = None;
    }
    settings.gizmo = gizmo;
}
