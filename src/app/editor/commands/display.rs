//! Commands that choose how the picture and the marks over it are shown.

use bevy::prelude::*;

use super::world::{control, set_resource};
use super::{baking, finished, light_paint};
use crate::app::editor::command::DisplayCommand;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::picture::compare::Comparison;
use crate::app::editor::picture::denoiser::Denoiser;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::ViewMode;

/// Applies the command.
pub fn apply(world: &mut World, command: DisplayCommand) -> Result<(), CommandError> {
    match command {
        DisplayCommand::SetLightMix(mix) => {
            let before = world.get_resource_or_init::<LightMix>().clone();
            let mix = before.with_channels(mix);
            set_resource(world, mix.clone());
            light_paint::follow_desk(world, &before, &mix);
        }
        DisplayCommand::PaintLight(command) => light_paint::apply(world, command)?,
        DisplayCommand::ExposeAutomatically => finished::expose(world)?,
        DisplayCommand::TakeSnapshot => finished::take_snapshot(world)?,
        DisplayCommand::SetCompareView(view) => {
            baking::check_view(world, view)?;
            world.resource_mut::<Comparison>().view = view;
        }
        DisplayCommand::Measure => finished::measure(world)?,
        DisplayCommand::SetMeters(choice) => world.resource_mut::<ViewSettings>().meters = choice,
        DisplayCommand::SetEnlarging(enlarging) => world.resource_mut::<ViewSettings>().enlarging = enlarging,
        DisplayCommand::SetDisplay(display) => set_display(world, display),
        DisplayCommand::SetOverlay(overlay) => world.resource_mut::<ViewSettings>().overlay = overlay,
        DisplayCommand::ShowSafeFrame(shown) => world.resource_mut::<ViewSettings>().safe_frame = shown,
        DisplayCommand::ShowDimensions(shown) => world.resource_mut::<ViewSettings>().dimensions = shown,
        DisplayCommand::SetGrid(grid) => world.resource_mut::<ViewSettings>().grid = grid.within_range(),
        DisplayCommand::SetDenoising(denoising) => {
            if denoising && !world.resource::<Denoiser>().is_available() {
                return Err("This program was built without the denoiser (cargo feature `denoise`).".into());
            }
            world.resource_mut::<ViewSettings>().denoising = denoising;
            if let Some(mut preferences) = world.get_resource_mut::<Preferences>() {
                preferences.denoising = denoising;
            }
        }
    }
    Ok(())
}

pub fn set_display(world: &mut World, display: DisplaySettings) {
    let (least, most) = DisplaySettings::EXPOSURES.into_inner();
    let display = DisplaySettings {
        exposure: display.exposure.clamp(least, most),
        ..display
    };
    world.resource_mut::<ViewSettings>().display = display;
    let view_mode = match display.mode {
        DisplayMode::BvhSteps => ViewMode::BvhSteps,
        DisplayMode::OpticalDepth => ViewMode::OpticalDepth,
        DisplayMode::Illuminance => ViewMode::Illuminance,
        DisplayMode::Headlight => ViewMode::Headlight,
        DisplayMode::Clay => ViewMode::Clay,
        _ => ViewMode::Path,
    };
    control(world, |control| control.view_mode = view_mode);
}
