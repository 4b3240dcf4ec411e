//! The verbs about the light you want.

use std::path::PathBuf;

use bevy::math::Vec2;
use bevy::prelude::World;

use super::error::ScriptError;
use super::names::{named, unknown};
use super::verb::verbs;
use crate::app::editor::command::light_paint::{Brush, LampChoice, LightPainting};
use crate::app::editor::command::{LightPaintCommand, SettingsEdit};
use crate::document::value::{parse_float, parse_floats, parse_rgb};
use crate::inverse_lighting::{Stroke, Wish};

verbs! {
    VERBS(world):
    "paint-light"
        "none | brighter|darker FACTOR | luminance NIT | illuminance LUX | colour R,G,B | keep, at X,Y... [radius R] [hardness H]"
        ["none"] => LightPaintCommand::SetStrokes(Vec::new()),
        words => paint(world, words)?;
    "want-picture" "none | FILE (of the same view)"
        ["none"] => LightPaintCommand::SetTarget(None),
        [file] => LightPaintCommand::SetTarget(Some(PathBuf::from(file)));
    "choose-lamp"
        "LIGHT off | LEAST MOST [colour], then [move RADIUS] [turn DEGREES] [hours FROM TO] [any-day]"
        [light, choice @ ..] => LightPaintCommand::SetLamp(named(world, light)?, lamp(choice)?);
    "solve-light" "(finds the lamps with all samples of now)" [] => LightPaintCommand::Solve;
    "place-lamps" "(searches for places, aims and times of lamps; the next line waits for it)"
        [] => LightPaintCommand::Place;
    "accept-lamps" "(gives lamps what was found)" [] => SettingsEdit::AcceptLamps;
    "discard-lamps" "(leaves lamps as they are)" [] => LightPaintCommand::Discard;
}

/// The strokes with one more.
fn paint(world: &World, words: &[&str]) -> Result<LightPaintCommand, ScriptError> {
    let at = words.iter().position(|word| *word == "at");
    let (wish, rest) = words.split_at(at.ok_or("expected `at` and places")?);
    let mut brush = Brush {
        wish: parse_wish(wish)?,
        ..Brush::default()
    };
    let mut path = Vec::new();
    let mut rest = rest[1..].iter();
    while let Some(word) = rest.next() {
        let mut number = || match rest.next() {
            Some(number) => parse_float(number).map_err(ScriptError::from),
            None => Err(format!("expected a number after `{word}`").into()),
        };
        match *word {
            "radius" => brush.radius = number()?,
            "hardness" => brush.hardness = number()?,
            place => path.push(parse_place(place)?),
        }
    }
    let stroke = brush.stroke(path);
    if !stroke.is_valid() {
        return Err("expected places, a radius above 0 and a hardness from 0 to 1".into());
    }
    let before = world.get_resource::<LightPainting>();
    let mut strokes: Vec<Stroke> = before.map(|painting| painting.strokes.to_vec()).unwrap_or_default();
    strokes.push(stroke);
    Ok(LightPaintCommand::SetStrokes(strokes))
}

fn parse_wish(words: &[&str]) -> Result<Wish, ScriptError> {
    let wish = match words {
        ["brighter", factor] => Wish::Brighter(parse_float(factor)?),
        ["darker", factor] => Wish::Darker(parse_float(factor)?),
        ["luminance", nit] => Wish::Luminance(parse_float(nit)?),
        ["illuminance", lux] => Wish::Illuminance(parse_float(lux)?),
        ["colour", color] => Wish::Color(parse_rgb(color)?),
        ["keep"] => Wish::Keep,
        [name, ..] => return Err(unknown("wish", name, Wish::ALL.iter().map(|wish| wish.name()))),
        [] => return Err("expected the light that is wanted".into()),
    };
    match wish.is_valid() {
        true => Ok(wish),
        false => Err("expected a factor of at least 1, a number of at least 0, or a colour that is not black".into()),
    }
}

fn parse_place(text: &str) -> Result<Vec2, ScriptError> {
    match parse_floats(text)?[..] {
        [x, y] => Ok(Vec2::new(x, y)),
        _ => Err(format!("expected two numbers, found `{text}`").into()),
    }
}

fn lamp(words: &[&str]) -> Result<LampChoice, ScriptError> {
    let mut choice = LampChoice::default();
    let mut rest = match words {
        ["off", rest @ ..] => {
            choice.chosen = false;
            rest
        }
        [least, most, rest @ ..] => {
            (choice.least, choice.most) = (parse_float(least)?, parse_float(most)?);
            rest
        }
        _ => return Err("expected `off`, or the least and the largest strength".into()),
    };
    loop {
        rest = match rest {
            [] => return Ok(choice),
            ["colour", rest @ ..] => {
                choice.colored = true;
                rest
            }
            ["move", radius, rest @ ..] => {
                choice.freedom.radius = parse_float(radius)?;
                rest
            }
            ["turn", degrees, rest @ ..] => {
                choice.freedom.turn = parse_float(degrees)?;
                rest
            }
            ["hours", from, to, rest @ ..] => {
                choice.freedom.hours = Some([parse_float(from)?, parse_float(to)?]);
                rest
            }
            ["any-day", rest @ ..] => {
                choice.freedom.day = true;
                rest
            }
            [word, ..] => {
                let known = ["colour", "move", "turn", "hours", "any-day"];
                return Err(unknown("freedom of lamps, or its numbers,", word, known));
            }
        };
    }
}
