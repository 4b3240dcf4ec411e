//! How much and how to render, and how the picture is shown.

use bevy_egui::egui::{self, Ui};

use super::super::command::Command;
use super::super::display::{DisplayMode, DisplaySettings};
use super::super::model::RenderModel;
use super::super::overlay::BvhOverlay;
use super::fields;
use crate::render::tonemap::ToneMap;
use crate::scene::{AccelMethod, Sequence, Strategy};

pub fn render(
    ui: &mut Ui,
    model: &RenderModel,
    display: DisplaySettings,
    overlay: BvhOverlay,
    commands: &mut Vec<Command>,
) {
    ui.strong("Picture");
    let mut target = model.target_samples;
    if fields::integer_slider(ui, "Samples", &mut target, 1..=16384, true) {
        commands.push(Command::SetTargetSamples(target.max(1)));
    }
    let mut scale = model.resolution_scale;
    if fields::slider(ui, "Resolution", &mut scale, 0.1..=1.0) {
        commands.push(Command::SetResolutionScale(scale));
    }
    ui.add_space(6.0);
    ui.strong("Display");
    display_rows(ui, display, commands);
    overlay_rows(ui, overlay, commands);
    ui.add_space(6.0);
    ui.strong("Light transport");
    transport_rows(ui, model, commands);
}

fn display_rows(ui: &mut Ui, display: DisplaySettings, commands: &mut Vec<Command>) {
    let mut edited = display;
    let mut changed = fields::choice(ui, "Show", &mut edited.mode, &DisplayMode::ALL);
    changed |= fields::slider_with(ui, "Exposure", &mut edited.exposure, -10.0..=10.0, |slider| {
        slider.suffix(" EV")
    });
    changed |= fields::choice(ui, "Tone map", &mut edited.tone_map, &tone_maps());
    if changed {
        commands.push(Command::SetDisplay(edited));
    }
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
        commands.push(Command::SetOverlay(edited));
    }
}

fn transport_rows(ui: &mut Ui, model: &RenderModel, commands: &mut Vec<Command>) {
    let mut integrator = model.integrator;
    let mut is_bounded = integrator.max_depth.is_some();
    let mut changed = fields::checkbox(ui, "Limit depth", &mut is_bounded);
    if changed {
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
    changed |= fields::choice(ui, "Sampling", &mut integrator.strategy, &strategies);
    changed |= fields::checkbox(ui, "Hide lights", &mut integrator.hide_emitters);
    changed |= fields::checkbox(ui, "Schlick", &mut integrator.schlick);
    if changed {
        commands.push(Command::SetIntegrator(integrator));
    }
    let mut sampler = model.sampler;
    let sequences = [(Sequence::Sobol, "Sobol"), (Sequence::Independent, "independent")];
    changed = fields::choice(ui, "Sequence", &mut sampler.sequence, &sequences);
    changed |= fields::integer(ui, "Seed", &mut sampler.seed, 0..=u32::MAX);
    if changed {
        commands.push(Command::SetSampler(sampler));
    }
    let mut accel = model.accel;
    let methods = [
        (AccelMethod::Sah, "surface area"),
        (AccelMethod::Median, "median"),
        (AccelMethod::Linear, "none (slow)"),
    ];
    if fields::choice(ui, "Hierarchy", &mut accel, &methods) {
        commands.push(Command::SetAccel(accel));
    }
    ui.add_space(6.0);
    if ui
        .add(egui::Button::new("Start again").min_size(egui::vec2(120.0, 0.0)))
        .clicked()
    {
        commands.push(Command::Restart);
    }
}
