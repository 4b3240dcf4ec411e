//! The panel of the render settings, and of the display of the picture.

use std::ops::RangeInclusive;

use bevy::math::Rect;
use bevy_egui::egui::Ui;

use super::caption::Caption;
use super::exposure::exposure_rows;
use super::section::{section, section_with};
use super::status::{auto_words, percent};
use super::{comparison, fields, layers, light_mixing, light_painting, look};
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::resolution::{Enlarging, FullFilm, Resolution};
use crate::app::editor::command::{CameraEdit, Command, DisplayCommand, RenderCommand, SettingsEdit};
use crate::app::editor::model::RenderModel;
use crate::render::tonemap::ToneMap;
use crate::render::white_balance::WhiteBalance;
use crate::scene::{AccelMethod, IntegratorSettings, PathPlugin, Sequence, Strategy};

/// Shows the settings of rendering and display.
pub fn render(
    ui: &mut Ui,
    model: &RenderModel,
    display: DisplaySettings,
    overlay: BvhOverlay,
    commands: &mut Vec<Command>,
) {
    fields::leave_scroll_bar(ui);
    section(ui, "Picture", |ui| picture_rows(ui, model, commands));
    section(ui, "Display", |ui| {
        display_rows(ui, display, commands);
        overlay_rows(ui, overlay, commands);
    });
    section(ui, "Light mixing", |ui| {
        light_mixing::light_mixing(ui, &model.mixing, display, commands);
        if model.mixing.is_on {
            light_painting::light_painting(ui, &model.painting, &model.mixing.lights, commands);
        }
    });
    section(ui, "Comparison", |ui| {
        comparison::comparison(ui, &model.comparison, commands)
    });
    section(ui, "Light transport", |ui| transport_rows(ui, model, commands));
    section_with(ui, "Layers", false, |ui| {
        layers::layer_rows(ui, model.integrator, commands)
    });
}

fn picture_rows(ui: &mut Ui, model: &RenderModel, commands: &mut Vec<Command>) {
    let mut target = model.target_samples;
    if fields::integer_slider(ui, "Samples", &mut target, 1..=16384, true) {
        commands.push(RenderCommand::SetTargetSamples(target.max(1)).into());
    }
    stopping_rows(ui, model, commands);
    let mut scale = model.resolution_scale;
    if fields::slider(ui, "Resolution", &mut scale, 0.1..=1.0) {
        commands.push(RenderCommand::SetResolutionScale(scale).into());
    }
    pixel_rows(ui, model, commands);
    let mut denoising = model.comparison.denoising;
    if fields::checkbox(ui, "Denoise", &mut denoising) {
        commands.push(DisplayCommand::SetDenoising(denoising).into());
    }
    region_rows(ui, model.region, commands);
}

/// The limits besides the samples; whichever is reached first ends the picture.
fn stopping_rows(ui: &mut Ui, model: &RenderModel, commands: &mut Vec<Command>) {
    if let Some(limit) = limit_rows(ui, "Limit time", "Seconds", model.time_limit, 60.0, 1.0..=36_000.0) {
        commands.push(RenderCommand::SetTimeLimit(limit).into());
    }
    if let Some(limit) = limit_rows(ui, "Limit noise", "Noise", model.noise_target, 0.02, 0.001..=0.5) {
        commands.push(RenderCommand::SetNoiseTarget(limit).into());
    }
    let mut adaptive = model.adaptive;
    if fields::checkbox(ui, "Adaptive", &mut adaptive) {
        commands.push(RenderCommand::SetAdaptive(adaptive).into());
    }
    let keep = fields::buttons(ui, |ui| ui.button("Save limits in the camera"));
    let hint = "Samples, Limit noise and Adaptive are those of this window: this writes them into the sampler of the camera, which the file keeps";
    if keep.on_hover_text(hint).clicked() {
        commands.push(CameraEdit::KeepLimits.into());
    }
    // The row is always there, so that those below stay where they are.
    let noise = model.noise.map_or_else(|| "not known yet".to_owned(), percent);
    fields::note(ui, "Noise now", noise);
}

/// Shows the rows for the resolution of the film, and for the enlarging of a picture of few pixels.
fn pixel_rows(ui: &mut Ui, model: &RenderModel, commands: &mut Vec<Command>) {
    let mut resolution = model.resolution;
    if fields::choice(ui, "Pixels", &mut resolution, &Resolution::LABELED) {
        commands.push(RenderCommand::SetResolution(resolution).into());
    }
    let mut enlarging = model.enlarging;
    if fields::choice(ui, "Upscaling", &mut enlarging, &Enlarging::LABELED) {
        commands.push(DisplayCommand::SetEnlarging(enlarging).into());
    }
    let button = look::primary(ui, "Render full film");
    let button = fields::buttons(ui, |ui| ui.add(button)).on_hover_text(
        "Trace all pixels of the film until the scene or the view changes. A saved picture always has all of them: if fewer are shown, they are \
         traced first, with as many samples as are shown",
    );
    if button.clicked() {
        commands.push(RenderCommand::RenderFull(FullFilm::default()).into());
    }
}

/// Shows the region of the picture that gets samples, by its edges from 0 to 1.
fn region_rows(ui: &mut Ui, region: Option<Rect>, commands: &mut Vec<Command>) {
    let mut is_on = region.is_some();
    let mut changed = fields::checkbox(ui, "Render region", &mut is_on);
    let mut edges = region.unwrap_or(Rect::new(0.25, 0.25, 0.75, 0.75));
    if region.is_some() {
        // A free view may have a region outside of the film.
        let reach = |low: f32, high: f32| low.min(0.0)..=high.max(1.0);
        let (across, down) = (reach(edges.min.x, edges.max.x), reach(edges.min.y, edges.max.y));
        changed |= fields::slider(ui, "Left", &mut edges.min.x, across.clone());
        changed |= fields::slider(ui, "Right", &mut edges.max.x, across);
        changed |= fields::slider(ui, "Top", &mut edges.min.y, down.clone());
        changed |= fields::slider(ui, "Bottom", &mut edges.max.y, down);
    }
    if changed {
        commands.push(RenderCommand::SetRegion(is_on.then_some(edges)).into());
    }
}

/// Shows a switch, and the number if it is on. Returns Some if edited.
fn limit_rows(
    ui: &mut Ui,
    switch: &str,
    name: &str,
    limit: Option<f32>,
    first: f32,
    range: RangeInclusive<f32>,
) -> Option<Option<f32>> {
    let mut is_on = limit.is_some();
    let switched = fields::checkbox(ui, switch, &mut is_on);
    let mut value = limit.unwrap_or(first);
    let changed = limit.is_some() && fields::log_slider(ui, name, &mut value, range);
    (switched || changed).then(|| is_on.then_some(value))
}

fn display_rows(ui: &mut Ui, display: DisplaySettings, commands: &mut Vec<Command>) {
    let mut edited = display;
    let mut changed = fields::choice(ui, "Show", &mut edited.mode, &DisplayMode::ALL);
    changed |= exposure_rows(ui, &mut edited.exposure);
    if fields::buttons(ui, |ui| ui.button("Expose automatically")).clicked() {
        commands.push(DisplayCommand::ExposeAutomatically.into());
    }
    changed |= fields::choice(ui, "Tone map", &mut edited.tone_map, &tone_maps());
    let white = &mut edited.white_balance;
    changed |= fields::slider_with(
        ui,
        "White",
        &mut white.temperature,
        WhiteBalance::TEMPERATURES,
        |slider| slider.logarithmic(true).fixed_decimals(0).suffix(" K"),
    );
    changed |= fields::slider(ui, "Tint", &mut white.tint, WhiteBalance::TINTS);
    if *white != WhiteBalance::default() && fields::buttons(ui, |ui| ui.button("Neutral white")).clicked() {
        *white = WhiteBalance::default();
        changed = true;
    }
    if changed {
        commands.push(DisplayCommand::SetDisplay(edited).into());
    }
}

/// Shows the clamp of bright samples, and the light that it removes from the picture.
fn clamp_rows(ui: &mut Ui, model: &RenderModel, percentile: &mut Option<f32>) -> bool {
    const FIRST: f32 = 99.9;
    let caption = Caption::from("Clamp fireflies")
        .explained("Samples that are brighter than nearly all others become as bright as the limit. There is less noise, and the picture is too dark where light is rare.");
    let mut is_clamped = percentile.is_some();
    let mut changed = fields::checkbox(ui, caption, &mut is_clamped);
    if changed {
        *percentile = is_clamped.then_some(FIRST);
    }
    if let Some(percentile) = percentile {
        let caption =
            Caption::from("Percentile").explained("The share of the samples with light that stay as they are.");
        changed |= fields::quantity(
            ui,
            caption,
            percentile,
            0.01,
            IntegratorSettings::CLAMP_PERCENTILES,
            " %",
        );
        if let Some(limit) = model.clamped {
            let text = format!("about {:.2} % of the light", 100.0 * limit.removed);
            fields::note(ui, "Removes", text);
        }
    }
    changed
}

fn tone_maps() -> Vec<(ToneMap, &'static str)> {
    ToneMap::ALL.iter().map(|&map| (map, map.name())).collect()
}

fn overlay_rows(ui: &mut Ui, overlay: BvhOverlay, commands: &mut Vec<Command>) {
    let mut edited = overlay;
    let mut changed = fields::checkbox(ui, "BVH boxes", &mut edited.shown);
    if edited.shown {
        changed |= fields::integer_slider(ui, "Depth", &mut edited.depth, 0..=24, false);
        changed |= fields::checkbox(ui, "Leaves only", &mut edited.leaves_only);
    }
    if changed {
        commands.push(DisplayCommand::SetOverlay(edited).into());
    }
}

/// Shows the choice of `auto`, and whether `path` stands for `auto`.
fn auto_rows(ui: &mut Ui, model: &RenderModel, commands: &mut Vec<Command>) {
    if model.integrator.plugin == PathPlugin::Path {
        let mut is_auto = model.path_is_auto;
        let caption = Caption::from("Automatic").explained(
            "Chooses between path, guided paths and bdpt, whichever has the least noise in this scene. This is a setting of the window: the scene keeps path, and the command line \
             renders by path.",
        );
        if fields::checkbox(ui, caption, &mut is_auto) {
            commands.push(RenderCommand::SetPathIsAuto(is_auto).into());
        }
    }
    if let Some(auto) = model.auto {
        fields::note(ui, "In use", auto_words(&auto));
    }
}

fn transport_rows(ui: &mut Ui, model: &RenderModel, commands: &mut Vec<Command>) {
    let mut integrator = model.integrator;
    let plugins = PathPlugin::ALL.map(|plugin| (plugin, plugin.name()));
    let about = "path follows light back from the camera, through empty space. volpath and volpathmis, which are the same here, scatter and absorb it in media \
                 as well. bdpt joins paths from the camera with paths from the lights: for caustics, and for lamps that are hard to find. vcm has \
                 photons beside it, for caustics that are seen through glass and water; it blurs them a little. ptracer has paths from the lights alone. auto is path, \
                 guided path or bdpt, whichever pays for the scene, as a pilot finds out.";
    let caption = Caption::from("Integrator").explained(about);
    let mut changed = fields::choice(ui, caption, &mut integrator.plugin, &plugins);
    auto_rows(ui, model, commands);
    let mut is_bounded = integrator.max_depth.is_some();
    if fields::checkbox(ui, "Limit depth", &mut is_bounded) {
        changed = true;
        integrator.max_depth = is_bounded.then_some(8);
    }
    if let Some(depth) = &mut integrator.max_depth {
        changed |= fields::integer_slider(ui, "Depth limit", depth, 1..=64, false);
    }
    changed |= fields::integer_slider(ui, "Roulette from", &mut integrator.rr_depth, 1..=64, false);
    let strategies = [
        (Strategy::Mis, "both (MIS)"),
        (Strategy::Bsdf, "bsdf only"),
        (Strategy::Light, "lights only"),
    ];
    if integrator.plugin.has_strategy() {
        changed |= fields::choice(ui, "Sampling", &mut integrator.strategy, &strategies);
        let mut split = model.strategy_split;
        let caption = Caption::from("Side by side").explained(
            "Renders the left third of the picture by sampling of BSDFs, the middle third by both and the right third by sampling of lights, to compare their noise.",
        );
        if fields::checkbox(ui, caption, &mut split) {
            commands.push(RenderCommand::SetStrategySplit(split).into());
        }
    }
    if integrator.plugin.is_guidable() {
        let caption = Caption::from("Guided paths").explained(
            "Photons are traced first, and paths go where these tell that light comes from. There is less noise where lamps are behind corners; where they are in sight it takes longer and is of no use.",
        );
        changed |= fields::checkbox(ui, caption, &mut integrator.guided);
    }
    if integrator.plugin.has_photons() {
        let mut photons = integrator.photons.unwrap_or(0);
        let caption = Caption::from("Photons").explained(
            "Paths from the lights for each sample of all pixels together. More of them make caustics less noisy; 0 means a quarter of the number of pixels.",
        );
        if fields::integer(ui, caption, &mut photons, 0..=IntegratorSettings::MOST_PHOTONS) {
            changed = true;
            integrator.photons = (photons > 0).then_some(photons);
        }
        let caption = Caption::from("Merge radius")
            .explained("Photons within this distance, in pixels, count for a place. It shrinks with the samples. A larger one is smoother and blurs more.");
        let radii = IntegratorSettings::MERGE_RADII;
        changed |= fields::quantity(ui, caption, &mut integrator.merge_radius, 0.05, radii, " px");
    }
    changed |= clamp_rows(ui, model, &mut integrator.clamp_percentile);
    changed |= fields::checkbox(ui, "Hide lights", &mut integrator.hide_emitters);
    changed |= fields::checkbox(ui, "Schlick", &mut integrator.schlick);
    if changed {
        commands.push(SettingsEdit::SetIntegrator(integrator).into());
    }
    let mut sampler = model.sampler;
    let sequences = [(Sequence::Sobol, "Sobol"), (Sequence::Independent, "independent")];
    changed = fields::choice(ui, "Sequence", &mut sampler.sequence, &sequences);
    changed |= fields::integer(ui, "Seed", &mut sampler.seed, 0..=u32::MAX);
    if changed {
        commands.push(SettingsEdit::SetSampler(sampler).into());
    }
    let mut accel = model.accel;
    let methods = [
        (AccelMethod::Sah, "surface area"),
        (AccelMethod::Median, "median"),
        (AccelMethod::Linear, "none (slow)"),
    ];
    if fields::choice(ui, "Hierarchy", &mut accel, &methods) {
        commands.push(SettingsEdit::SetAccel(accel).into());
    }
    ui.add_space(6.0);
    if fields::buttons(ui, |ui| ui.button("Start again")).clicked() {
        commands.push(RenderCommand::Restart.into());
    }
}
