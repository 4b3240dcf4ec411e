//! Commands that control the rendering of the picture.

use bevy::prelude::*;

use super::display::set_display;
use super::full_film;
use super::world::control;
use crate::app::editor::command::RenderCommand;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::view_settings::ViewSettings;

/// Applies the command.
pub fn apply(world: &mut World, command: RenderCommand) -> Result<(), CommandError> {
    match command {
        RenderCommand::SetPaused(paused) => control(world, |control| control.paused = paused),
        RenderCommand::Restart => control(world, |control| control.restart_requested = true),
        RenderCommand::SetTargetSamples(samples) => {
            control(world, |control| control.target_samples = Some(samples.max(1)))
        }
        RenderCommand::SetTimeLimit(limit) => control(world, |control| control.time_limit = limit),
        RenderCommand::SetNoiseTarget(target) => {
            // Zero is no limit, also where the file has one.
            control(world, |control| control.noise_target = Some(target.unwrap_or(0.0)));
        }
        RenderCommand::SetAdaptive(is_on) => control(world, |control| control.adaptive = Some(is_on)),
        RenderCommand::SetRegion(region) => {
            let region = region.map(|region| Rect::from_corners(region.min, region.max));
            control(world, |control| control.region = region);
        }
        RenderCommand::SetPathIsAuto(is_auto) => control(world, |control| control.path_is_auto = is_auto),
        RenderCommand::SetStrategySplit(split) => control(world, |control| control.strategy_split = split),
        RenderCommand::SetLightLayers(kept) => {
            control(world, |control| control.light_layers = kept);
            let display = world.resource::<ViewSettings>().display;
            if !kept && matches!(display.mode, DisplayMode::LightGroup(_)) {
                let mode = DisplayMode::Shaded;
                set_display(world, DisplaySettings { mode, ..display });
            }
        }
        RenderCommand::SetResolutionScale(scale) => {
            control(world, |control| control.resolution_scale = scale.clamp(0.05, 1.0));
        }
        RenderCommand::SetResolution(resolution) => full_film::set_resolution(world, resolution),
        RenderCommand::RenderFull(request) => full_film::render(world, request)?,
        RenderCommand::StopFull => full_film::stop(world),
    }
    Ok(())
}
