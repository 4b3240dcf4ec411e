//! The verbs about rendering and the finished picture.

use std::ops::RangeInclusive;

use bevy::prelude::*;

use super::assign::within;
use super::error::ScriptError;
use super::names::{all_named, named, sample_count, unknown};
use super::placing::axis_of;
use super::verb::verbs;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::inspected_paths::InspectedPaths;
use crate::app::editor::command::light_mix::{Channel, LightMix};
use crate::app::editor::command::resolution::{Enlarging, Resolution};
use crate::app::editor::command::ruler::Ruler;
use crate::app::editor::command::seeing::{CutOpen, Seeing, Walls};
use crate::app::editor::command::{DisplayCommand, RenderCommand, SettingsEdit, ToolCommand, ViewCommand};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::color::Rgb;
use crate::document::value::{parse_float, parse_floats, parse_noise, parse_rgb, parse_vec3};
use crate::engine::reasons::Grouping;
use crate::layer::Layers;
use crate::photometry::exposure;
use crate::render::tonemap::ToneMap;
use crate::render::white_balance::WhiteBalance;
use crate::scene::IntegratorSettings;

verbs! {
    VERBS(world):
    "samples" "N" [number] => RenderCommand::SetTargetSamples(sample_count(number)?);
    "show" "MODE" [mode] => show(world, mode)?;
    "exposure" "STOPS|ev100:EV|f/APERTURE,SECONDS,ISO"
        [text] => {
            let stops = exposure::parse(text).map_or_else(|| parse_float(text), Ok)?;
            let stops = within(stops, &DisplaySettings::EXPOSURES)?;
            display(world, |display| display.exposure = stops)
        };
    "tone-map" "NAME" [name] => tone_map(world, name)?;
    "white" "KELVIN [TINT]"
        [kelvin, tint @ ..] if tint.len() <= 1 => {
            let white_balance = white(kelvin, tint.first().copied())?;
            display(world, |display| display.white_balance = white_balance)
        };
    "limit-time" "SECONDS|none" [seconds] => RenderCommand::SetTimeLimit(positive(seconds)?);
    "limit-noise" "NOISE|none" [limit] => RenderCommand::SetNoiseTarget(noise(limit)?);
    "adaptive" "on|off" [word] => RenderCommand::SetAdaptive(switch(word)?);
    "resolution" "view|after-rest|full" [name] => RenderCommand::SetResolution(resolution(name)?);
    "enlarge" "smooth|sharp" [name] => DisplayCommand::SetEnlarging(enlarging(name)?);
    "region" "none | X,Y X,Y (0 to 1 from the upper left)" corners => RenderCommand::SetRegion(region(corners)?);
    "why" "none | X,Y [X,Y] [route|lamp|way|bounces|kind] (a place or two corners, 0 to 1)"
        words => ToolCommand::InspectPaths(inspected(words)?);
    "follow-light" "LAMP|none" [name] => ToolCommand::FollowLamp(match *name {
        "none" => None,
        name => Some(named(world, name)?),
    });
    "layers" "none | LAYER... (saved with EXR images)" names => layers(world, names)?;
    "choose-integrator" "on|off" [word] => RenderCommand::SetPathIsAuto(switch(word)?);
    "split-strategies" "on|off" [word] => RenderCommand::SetStrategySplit(switch(word)?);
    "show-grid" "on|off"
        [word] => DisplayCommand::SetGrid(GridSettings {
            shown: switch(word)?,
            ..world.resource::<ViewSettings>().grid
        });
    "measure-between" "FROM TO (each X,Y,Z)"
        [from, to] => ToolCommand::AddRuler(Ruler { from: parse_vec3(from)?, to: parse_vec3(to)? });
    "hide-walls" "on|off"
        [word] => {
            let walls = if switch(word)? { Walls::Hidden } else { Walls::Shown };
            seeing(world, |seen| seen.walls = walls)
        };
    "cut-plane" "none | x|y|z|-x|-y|-z AT (leaves out what is beyond)"
        words => {
            let cut = cut(words)?;
            seeing(world, |seen| seen.cut = cut)
        };
    "show-alone" "none | NAME..."
        ["none"] => ViewCommand::Isolate(Vec::new()),
        names if !names.is_empty() => ViewCommand::Isolate(all_named(world, names)?);
    "keep-lights-apart" "on|off" [word] => RenderCommand::SetLightLayers(switch(word)?);
    "mix" "none | LIGHT STRENGTH [R,G,B]"
        ["none"] => DisplayCommand::SetLightMix(LightMix::default()),
        [light, gain @ ..] => mix(world, light, gain)?;
    "denoise" "[on | off] (without a word it switches)"
        [word @ ("on" | "off")] => DisplayCommand::SetDenoising(switch(word)?);
    "compare" "off | wipe FRACTION | difference | noisy FRACTION | baked FRACTION"
        view => DisplayCommand::SetCompareView(compare_view(view)?);
}

fn show(world: &World, mode: &str) -> Result<DisplayCommand, ScriptError> {
    let mode = mode.replace('-', " ");
    let known = DisplayMode::ALL
        .iter()
        .find(|(_, name)| name.eq_ignore_ascii_case(&mode));
    let known = known.ok_or_else(|| unknown("mode", &mode, DisplayMode::ALL.iter().map(|(_, name)| *name)))?;
    Ok(display(world, |display| display.mode = known.0))
}

fn tone_map(world: &World, name: &str) -> Result<DisplayCommand, ScriptError> {
    let known = ToneMap::ALL.into_iter().find(|map| map.name() == name);
    let known = known.ok_or_else(|| unknown("tone map", name, ToneMap::ALL.iter().map(|map| map.name())))?;
    Ok(display(world, |display| display.tone_map = known))
}

fn display(world: &World, change: impl FnOnce(&mut DisplaySettings)) -> DisplayCommand {
    let mut display = world.resource::<ViewSettings>().display;
    change(&mut display);
    DisplayCommand::SetDisplay(display)
}

fn seeing(world: &World, change: impl FnOnce(&mut Seeing)) -> ViewCommand {
    let mut seeing = world.resource::<ViewSettings>().seeing;
    change(&mut seeing);
    ViewCommand::SetSeeing(seeing)
}

/// The range of a coordinate of the picture, as a share of its width or height.
const SHARE: RangeInclusive<f32> = 0.0..=1.0;

pub fn switch(text: &str) -> Result<bool, ScriptError> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err(format!("expected `on` or `off`, found `{text}`").into()),
    }
}

fn resolution(name: &str) -> Result<Resolution, ScriptError> {
    let known = Resolution::of_name(name);
    known.ok_or_else(|| format!("expected `view`, `after-rest` or `full`, found `{name}`").into())
}

fn enlarging(name: &str) -> Result<Enlarging, ScriptError> {
    let known = Enlarging::of_name(name);
    known.ok_or_else(|| format!("expected `smooth` or `sharp`, found `{name}`").into())
}

/// Parses a limit above 0; None is no limit.
pub fn positive(text: &str) -> Result<Option<f32>, ScriptError> {
    match text {
        "none" => Ok(None),
        number => Ok(Some(within(parse_float(number)?, &(f32::MIN_POSITIVE..=f32::MAX))?)),
    }
}

/// Parses a limit of noise, such as `0.02` or `2%`; None is no limit.
pub fn noise(text: &str) -> Result<Option<f32>, ScriptError> {
    match text {
        "none" => Ok(None),
        noise => Ok(Some(parse_noise(noise)?)),
    }
}

fn white(kelvin: &str, tint: Option<&str>) -> Result<WhiteBalance, ScriptError> {
    Ok(WhiteBalance {
        temperature: within(parse_float(kelvin)?, &WhiteBalance::TEMPERATURES)?,
        tint: within(parse_float(tint.unwrap_or("0"))?, &WhiteBalance::TINTS)?,
    })
}

fn region(words: &[&str]) -> Result<Option<Rect>, ScriptError> {
    match words {
        ["none"] => Ok(None),
        [from, to] => Ok(Some(Rect::from_corners(place(from)?, place(to)?))),
        _ => Err("expected `none` or two corners".into()),
    }
}

/// The paths of a place, or of the rectangle between two corners, with the grouping of their light.
fn inspected(words: &[&str]) -> Result<Option<InspectedPaths>, ScriptError> {
    let (grouping, places) = match words.split_last() {
        Some((last, places)) => match Grouping::of_name(last) {
            Some(grouping) => (grouping, places),
            None => (Grouping::default(), words),
        },
        None => (Grouping::default(), words),
    };
    let paths = match places {
        ["none"] => return Ok(None),
        [at] => InspectedPaths::at(place(at)?),
        [from, to] => InspectedPaths::between([place(from)?, place(to)?]),
        _ => return Err("expected `none`, a place or two corners".into()),
    };
    Ok(Some(InspectedPaths { grouping, ..paths }))
}

/// The settings with exactly these layers.
fn layers(world: &World, names: &[&str]) -> Result<SettingsEdit, ScriptError> {
    let layers = match names {
        [] => return Err("expected `none` or names of layers".into()),
        ["none"] => Layers::default(),
        names => Layers::parse(&names.join(",")).map_err(|error| error.to_string())?,
    };
    let integrator = world.get_resource().copied().unwrap_or_default();
    Ok(SettingsEdit::SetIntegrator(IntegratorSettings { layers, ..integrator }))
}

fn place(text: &str) -> Result<Vec2, ScriptError> {
    match parse_floats(text)?[..] {
        [x, y] => Ok(Vec2::new(within(x, &SHARE)?, within(y, &SHARE)?)),
        _ => Err(format!("expected two numbers, found `{text}`").into()),
    }
}

/// The mix with another gain of a light: strength, and colour if it is not white. Solo and mute stay.
fn mix(world: &mut World, light: &str, gain: &[&str]) -> Result<DisplayCommand, ScriptError> {
    let (strength, color) = match gain {
        [strength] => (parse_float(strength)?, Rgb::ONE),
        [strength, color] => (parse_float(strength)?, parse_rgb(color)?),
        _ => return Err("expected a strength and perhaps a colour".into()),
    };
    let light = named(world, light)?;
    let mut mix = world.resource::<LightMix>().clone();
    let channel = Channel {
        strength,
        color,
        ..mix.channel(light)
    };
    mix.set(light, channel);
    Ok(DisplayCommand::SetLightMix(mix))
}

/// Parses a cut plane; None is none.
fn cut(words: &[&str]) -> Result<Option<CutOpen>, ScriptError> {
    let (axis, at) = match words {
        ["none"] => return Ok(None),
        [axis, at] => (*axis, parse_float(at)?),
        _ => return Err("expected `none`, or an axis and a number".into()),
    };
    let (above, name) = match axis.strip_prefix('-') {
        Some(name) => (false, name),
        None => (true, axis),
    };
    let axis = axis_of(name)?;
    Ok(Some(CutOpen { axis, at, above }))
}

fn compare_view(words: &[&str]) -> Result<CompareView, ScriptError> {
    let border = |text: &str| Ok::<f32, ScriptError>(within(parse_float(text)?, &SHARE)?);
    match words {
        ["off"] => Ok(CompareView::Off),
        ["difference"] => Ok(CompareView::Difference),
        ["wipe", share] => Ok(CompareView::Wipe(border(share)?)),
        ["baked", share] => Ok(CompareView::Baked(border(share)?)),
        ["noisy", share] => Ok(CompareView::Noisy(border(share)?)),
        _ => Err("expected `off`, `wipe FRACTION`, `difference`, `noisy FRACTION` or `baked FRACTION`".into()),
    }
}
