//! The words of scripts about rendering and the finished picture.

use std::ops::RangeInclusive;

use bevy::prelude::*;

use super::assign::within;
use super::error::ScriptError;
use super::names::named;
use super::placing::axis_of;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::light_mix::{Channel, LightMix};
use crate::app::editor::command::resolution::{Enlarging, Resolution};
use crate::app::editor::command::seeing::CutOpen;
use crate::app::editor::command::{Command, DisplayCommand, SettingsEdit};
use crate::color::Rgb;
use crate::document::value::{parse_float, parse_floats, parse_noise, parse_rgb};
use crate::layer::Layers;
use crate::render::white_balance::WhiteBalance;
use crate::scene::IntegratorSettings;

/// A part of the width or the height of the picture.
const SHARE: RangeInclusive<f32> = 0.0..=1.0;

pub fn switch(text: &str) -> Result<bool, ScriptError> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err(format!("expected `on` or `off`, found `{text}`").into()),
    }
}

pub fn resolution(name: &str) -> Result<Resolution, ScriptError> {
    let known = Resolution::ALL.into_iter().find(|(_, known, _)| *known == name);
    let known = known.ok_or_else(|| format!("expected `view`, `after-rest` or `full`, found `{name}`"))?;
    Ok(known.0)
}

pub fn enlarging(name: &str) -> Result<Enlarging, ScriptError> {
    let known = Enlarging::ALL.into_iter().find(|(_, known)| *known == name);
    let known = known.ok_or_else(|| format!("expected `smooth` or `sharp`, found `{name}`"))?;
    Ok(known.0)
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

/// `KELVIN [TINT]`
pub fn white(kelvin: &str, tint: Option<&str>) -> Result<WhiteBalance, ScriptError> {
    Ok(WhiteBalance {
        temperature: within(parse_float(kelvin)?, &WhiteBalance::TEMPERATURES)?,
        tint: within(parse_float(tint.unwrap_or("0"))?, &WhiteBalance::TINTS)?,
    })
}

pub fn region(words: &[&str]) -> Result<Option<Rect>, ScriptError> {
    match words {
        ["none"] => Ok(None),
        [from, to] => Ok(Some(Rect::from_corners(place(from)?, place(to)?))),
        _ => Err("expected `none` or two corners".into()),
    }
}

/// The settings with these layers alone.
pub fn layers(world: &World, names: &[&str]) -> Result<Command, ScriptError> {
    let layers = match names {
        [] => return Err("expected `none` or names of layers".into()),
        ["none"] => Layers::default(),
        names => Layers::parse(&names.join(",")).map_err(|error| error.to_string())?,
    };
    let integrator = world.get_resource().copied().unwrap_or_default();
    Ok(SettingsEdit::SetIntegrator(IntegratorSettings { layers, ..integrator }).into())
}

fn place(text: &str) -> Result<Vec2, ScriptError> {
    match parse_floats(text)?[..] {
        [x, y] => Ok(Vec2::new(within(x, &SHARE)?, within(y, &SHARE)?)),
        _ => Err(format!("expected two numbers, found `{text}`").into()),
    }
}

/// The mix with another gain of a light: strength, and colour if it is not white. Solo and mute stay.
pub fn mix(world: &mut World, light: &str, gain: &[&str]) -> Result<Command, ScriptError> {
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
    Ok(DisplayCommand::SetLightMix(mix).into())
}

/// Parses a cut plane; None is none.
pub fn cut(words: &[&str]) -> Result<Option<CutOpen>, ScriptError> {
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

pub fn compare_view(words: &[&str]) -> Result<CompareView, ScriptError> {
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
