//! Procedural textures: the plugins whose values follow from formulas, each declared once, and the types of values that
//! they alone have.
//!
//! All are extensions of the format. Other programs get pictures of them, see [`crate::scene::write::portable`].

use super::parameter_info::ParameterInfo;
use crate::color::Rgb;
use crate::document::value::{ValueError, fields, format_float, parse_float};

/// Hands the declaration of all patterns to a macro: in `texture` it makes the type, because textures and patterns hold
/// each other, and in `pattern_parameters` the rest, because references to parameters know textures.
macro_rules! with_patterns {
    ($declare:ident) => {
        $declare! {
            /// A procedural texture. Coordinates are uv, or lengths inside a box projection.
            #[derive(Clone, Debug, PartialEq)]
            pub enum Pattern {
                /// Gradient noise.
                [PluginInfo::new("noise", "noise")]
                Noise {
                    color0: Parameter<Rgb> = Rgb::ZERO.into() => Nested(LOW),
                    color1: Parameter<Rgb> = Rgb::ONE.into() => Nested(HIGH),
                    octaves: i32 = 4 => Integer(ParameterInfo::new(
                        "octaves",
                        "Octaves",
                        "How many noises, each of half the size of the one before, are added up.",
                        "1 to 16",
                    )
                    .within(1.0..=16.0)),
                    gain: f32 = 0.5 => Number(ParameterInfo::new(
                        "gain",
                        "Gain",
                        "Strength of each octave relative to the one before: small is smooth, large is rough.",
                        "0 to 1",
                    )
                    .within(0.0..=1.0)
                    .offering(0.0..=1.0)),
                    distortion: f32 = 0.0 => Number(ParameterInfo::new(
                        "distortion",
                        "Distortion",
                        "How far places are moved by another noise beforehand: lines bend as in marble.",
                        "cells of the noise",
                    )
                    .within(-1e3..=1e3)
                    .offering(0.0..=4.0)),
                    ridged: bool = false => Flag(ParameterInfo::switch(
                        "ridged",
                        "Ridges",
                        "Shows lines where the noise crosses its mean, as veins, instead of the noise.",
                    )),
                    to_uv: Affine2 = Affine2::IDENTITY => Placing(TO_UV),
                },

                /// Cells around scattered points.
                [PluginInfo::new("cells", "cells")]
                Cells {
                    color0: Parameter<Rgb> = Rgb::ZERO.into() => Nested(LOW),
                    color1: Parameter<Rgb> = Rgb::ONE.into() => Nested(HIGH),
                    value: Choice = Choice::first(&["distance", "border", "random"]) => Choice(ParameterInfo::new(
                        "value",
                        "Shows",
                        "The distance from the nearest point, what is missing to the border between two cells, or a random number for each cell.",
                        "distance, border or random",
                    )),
                    scatter: f32 = 0.8 => Number(ParameterInfo::new(
                        "scatter",
                        "Scatter",
                        "How irregular the cells are: 0 gives squares.",
                        "0 to 1",
                    )
                    .within(0.0..=1.0)
                    .offering(0.0..=1.0)),
                    to_uv: Affine2 = Affine2::IDENTITY => Placing(TO_UV),
                },

                /// Bricks, tiles and boards with joints.
                [PluginInfo::new("bricks", "bricks")]
                Bricks {
                    color0: Parameter<Rgb> = Rgb::splat(0.4).into() => Nested(ParameterInfo::new(
                        "color0",
                        "Colour 1",
                        "Each brick has a colour between this one and the other. A texture lies differently on each.",
                        "linear colour, or another texture",
                    )),
                    color1: Parameter<Rgb> = Rgb::splat(0.5).into() => Nested(ParameterInfo::new(
                        "color1",
                        "Colour 2",
                        "Each brick has a colour between the other one and this. A texture lies differently on each.",
                        "linear colour, or another texture",
                    )),
                    joint_color: Parameter<Rgb> = Rgb::splat(0.2).into() => Nested(ParameterInfo::new(
                        "joint_color",
                        "Joints",
                        "Colour of the joints.",
                        "linear colour, or another texture",
                    )),
                    width: f32 = 0.215 => Length(ParameterInfo::new(
                        "width",
                        "Width",
                        "Of a brick without its joints.",
                        "above 0",
                    )
                    .within(1e-4..=f32::MAX)),
                    height: f32 = 0.065 => Length(ParameterInfo::new(
                        "height",
                        "Height",
                        "Of a brick without its joints.",
                        "above 0",
                    )
                    .within(1e-4..=f32::MAX)),
                    joint: f32 = 0.01 => Length(ParameterInfo::new(
                        "joint",
                        "Joint",
                        "Width of the joints.",
                        "0 or more",
                    )
                    .within(0.0..=f32::MAX)),
                    bevel: f32 = 0.0 => Length(ParameterInfo::new(
                        "bevel",
                        "Bevel",
                        "Width of the strip along the edges in which the joint's colour turns into the brick's: for heights, a rounded edge.",
                        "0 or more",
                    )
                    .within(0.0..=f32::MAX)),
                    bond: Choice = Choice::first(&["running", "random", "herringbone"]) => Choice(ParameterInfo::new(
                        "bond",
                        "Bond",
                        "Rows moved by the offset, rows moved at random as floorboards, or the steps of parquet.",
                        "running, random or herringbone",
                    )),
                    offset: f32 = 0.5 => Number(ParameterInfo::new(
                        "offset",
                        "Offset",
                        "How far each row of a running bond is moved against the one below: 0 gives straight joints.",
                        "0 to 1, a share of a brick",
                    )
                    .within(0.0..=1.0)
                    .offering(0.0..=1.0)),
                    to_uv: Affine2 = Affine2::IDENTITY => Placing(TO_UV),
                },

                /// The grain of wood.
                [PluginInfo::new("wood", "wood")]
                Wood {
                    color0: Parameter<Rgb> = Rgb::new(0.55, 0.36, 0.19).into() => Nested(ParameterInfo::new(
                        "color0",
                        "Early wood",
                        "Colour of the wood that grows in spring.",
                        "linear colour, or another texture",
                    )),
                    color1: Parameter<Rgb> = Rgb::new(0.36, 0.2, 0.09).into() => Nested(ParameterInfo::new(
                        "color1",
                        "Late wood",
                        "Colour of the dark lines that grow in summer and autumn.",
                        "linear colour, or another texture",
                    )),
                    ring: f32 = 0.003 => Length(ParameterInfo::new(
                        "ring",
                        "Ring",
                        "Width of an annual ring.",
                        "above 0; 0.001 to 0.005 m in most woods",
                    )
                    .within(1e-6..=f32::MAX)),
                    waviness: f32 = 1.0 => Number(ParameterInfo::new(
                        "waviness",
                        "Waviness",
                        "How far rings deviate from circles.",
                        "widths of a ring",
                    )
                    .within(0.0..=100.0)
                    .offering(0.0..=6.0)),
                    to_uv: Affine2 = Affine2::IDENTITY => Placing(TO_UV),
                },

                /// Colours by a value.
                [PluginInfo::new("ramp", "ramp")]
                Ramp {
                    input: Option<Texture> = None => OptionalTexture(ParameterInfo::new(
                        "input",
                        "Input",
                        "The texture whose values become colours. Without one u is taken, so that colours follow each other along the surface.",
                        "a texture, or none",
                    )),
                    stops: Vec<Stop> = default_stops() => Stops(ParameterInfo::new(
                        "stops",
                        "Stops",
                        "The colours, each with the value that it belongs to. Between them colours blend.",
                        "for each the value and the linear red, green and blue, with ; between them, in ascending order",
                    )),
                    to_uv: Affine2 = Affine2::IDENTITY => Placing(TO_UV),
                },

                /// Two textures by a third.
                [PluginInfo::new("mix", "mixture")]
                Mix {
                    color0: Parameter<Rgb> = Rgb::ZERO.into() => Nested(ParameterInfo::new(
                        "color0",
                        "Colour 1",
                        "The first colour.",
                        "linear colour, or another texture",
                    )),
                    color1: Parameter<Rgb> = Rgb::ONE.into() => Nested(ParameterInfo::new(
                        "color1",
                        "Colour 2",
                        "The second colour.",
                        "linear colour, or another texture",
                    )),
                    weight: Parameter<Rgb> = Rgb::splat(0.5).into() => Nested(ParameterInfo::new(
                        "weight",
                        "Weight",
                        "How much there is of the second colour.",
                        "0 to 1, or another texture",
                    )),
                    mode: Choice = Choice::first(&["mix", "multiply", "add"]) => Choice(ParameterInfo::new(
                        "mode",
                        "Mode",
                        "The second takes the place of the first, multiplies it, or is added to it.",
                        "mix, multiply or add",
                    )),
                },

                /// A texture by the place on the shape.
                [PluginInfo::new("boxprojection", "box projection")]
                BoxProjection {
                    input: Parameter<Rgb> = Rgb::splat(0.5).into() => Nested(ParameterInfo::new(
                        "input",
                        "Texture",
                        "What is laid on the shape from the six sides of a box, in lengths of the scene, whatever uv and scale the shape has.",
                        "a texture",
                    )),
                    up: Choice = Choice::first(&["y", "z"]) => Choice(ParameterInfo::new(
                        "up",
                        "Up",
                        "The axis of the scene that is up: rows of bricks lie level.",
                        "y or z",
                    )),
                    to_uv: Affine2 = Affine2::IDENTITY => Placing(TO_UV),
                },
            }
        }
    };
}

pub(super) use with_patterns;

pub(super) const LOW: ParameterInfo = ParameterInfo::new(
    "color0",
    "Colour 1",
    "Colour where the value is 0.",
    "linear colour, or another texture",
);

pub(super) const HIGH: ParameterInfo = ParameterInfo::new(
    "color1",
    "Colour 2",
    "Colour where the value is 1.",
    "linear colour, or another texture",
);

/// One of a few names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    names: &'static [&'static str],
    chosen: &'static str,
}

impl Choice {
    /// The first of the names.
    pub(super) const fn first(names: &'static [&'static str]) -> Self {
        Self {
            names,
            chosen: names[0],
        }
    }

    /// All names.
    pub fn names(self) -> &'static [&'static str] {
        self.names
    }

    /// The chosen name.
    pub fn name(self) -> &'static str {
        self.chosen
    }

    /// The choice of another name; None if there is no such name.
    pub fn of_name(self, name: &str) -> Option<Self> {
        let chosen = self.names.iter().find(|known| **known == name)?;
        Some(Self { chosen, ..self })
    }
}

/// A colour of a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// The value with the colour.
    pub at: f32,
    /// Linear Rec. 709.
    pub color: Rgb,
}

pub(super) fn default_stops() -> Vec<Stop> {
    let stop = |at: f32| Stop {
        at,
        color: Rgb::splat(at),
    };
    vec![stop(0.0), stop(1.0)]
}

/// The most stops of a ramp.
pub(crate) const MOST_STOPS: usize = 64;

/// The text of stops in a file: four numbers for each (value, red, green, blue), with `;` between the stops.
pub fn stops_text(stops: &[Stop]) -> String {
    let text = |stop: &Stop| {
        [stop.at, stop.color.x, stop.color.y, stop.color.z]
            .map(format_float)
            .join(" ")
    };
    stops.iter().map(text).collect::<Vec<_>>().join("; ")
}

/// The reason why a text gives no stops.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StopsError {
    /// A part of the text is not a number.
    #[error(transparent)]
    Value(#[from] ValueError),
    /// A stop has more or fewer than four numbers.
    #[error("expected four numbers (value, red, green, blue), found `{0}`")]
    Numbers(String),
    /// The values do not grow.
    #[error("expected values in ascending order")]
    Order,
    /// There are no stops, or too many.
    #[error("expected 1 to {most} stops, found {0}", most = MOST_STOPS)]
    Count(usize),
}

/// Parses the text of stops.
pub fn parse_stops(text: &str) -> Result<Vec<Stop>, StopsError> {
    let mut stops: Vec<Stop> = Vec::new();
    for part in text.split(';').filter(|part| !part.trim().is_empty()) {
        let numbers = fields(part).map(parse_float).collect::<Result<Vec<f32>, _>>()?;
        let [at, red, green, blue] = numbers[..] else {
            return Err(StopsError::Numbers(part.trim().to_owned()));
        };
        if stops.last().is_some_and(|last| last.at > at) {
            return Err(StopsError::Order);
        }
        let color = Rgb::new(red, green, blue);
        stops.push(Stop { at, color });
    }
    match stops.len() {
        1..=MOST_STOPS => Ok(stops),
        count => Err(StopsError::Count(count)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_are_read_as_they_are_written() {
        let text = "0.25 0.1 0.2 0.3; 0.75 1 0.5 0";
        let stops = parse_stops(text).expect("two stops");
        assert_eq!((stops.len(), stops[1].color), (2, Rgb::new(1.0, 0.5, 0.0)));
        assert_eq!(parse_stops(&stops_text(&stops)), Ok(stops));
        assert_eq!(parse_stops("1 0 0 0; 0 1 1 1"), Err(StopsError::Order));
        assert_eq!(parse_stops("1 0 0"), Err(StopsError::Numbers("1 0 0".to_owned())));
        assert_eq!(parse_stops(" ; "), Err(StopsError::Count(0)));
        assert_eq!(parse_stops(&"0 0 0 0;".repeat(65)), Err(StopsError::Count(65)));
        assert!(matches!(parse_stops("0 0 red 0"), Err(StopsError::Value(_))));
    }
}
