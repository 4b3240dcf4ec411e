//! Building parts that are given by a few numbers: walls with openings, stairs, prisms. Each stands on the plane z = 0
//! of its own space.
//!
//! These plugins are extensions of the format. The numbers are what a file holds; meshes are made from them
//! ([`super::assets::solid_mesh`]), also when `convert` writes a scene for other programs.

use std::ops::RangeInclusive;

use bevy::math::Vec3;
use bevy::reflect::Reflect;

use super::parameter_info::ParameterInfo;
use crate::document::value::{ValueError, fields, format_float, parse_float};

/// A building part.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Solid {
    /// A wall along +x from the origin, its thickness half to either side of y = 0.
    Wall {
        /// The extent along x.
        length: f32,
        /// The extent along z.
        height: f32,
        /// The extent along y.
        thickness: f32,
        /// Doors and windows.
        openings: Vec<Opening>,
    },
    /// Solid stairs that begin at y = 0, rise along +y and have their middle at x = 0.
    Stairs {
        /// The extent along x.
        width: f32,
        /// The extent along y.
        depth: f32,
        /// The extent along z.
        height: f32,
        /// The number of equal steps, from 1 to 200.
        steps: u32,
    },
    /// A regular prism, frustum or pyramid around the z axis; one of its sides faces -y.
    Prism {
        /// The distance of the lower corners from the axis.
        radius: f32,
        /// The distance of the upper corners from the axis; 0 for a pyramid.
        top_radius: f32,
        /// The extent along z.
        height: f32,
        /// The number of sides, from 3 to 256.
        sides: u32,
    },
}

/// A rectangular opening that goes through a wall. What reaches beyond the wall is ignored, and openings may overlap.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
pub struct Opening {
    /// The distance of its nearer edge from the wall's start.
    pub from: f32,
    /// The height of the lower edge above the wall's foot; 0 for a door or a French window.
    pub sill: f32,
    /// The extent along the wall, above 0.
    pub width: f32,
    /// The extent upwards, above 0.
    pub height: f32,
}

impl Opening {
    /// A door in metres.
    pub const DOOR: Self = Self {
        from: 0.5,
        sill: 0.0,
        width: 0.9,
        height: 2.1,
    };
    /// A window in metres.
    pub const WINDOW: Self = Self {
        from: 0.5,
        sill: 0.9,
        width: 1.2,
        height: 1.2,
    };

    /// A window that reaches the floor, in metres. It ends at the height of the others.
    pub const FRENCH_WINDOW: Self = Self {
        from: 0.5,
        sill: 0.0,
        width: 1.6,
        height: 2.1,
    };

    /// The opening for a wall of this height: as it is in a wall of a room in metres, and in proportion in one that is
    /// of another scale.
    pub fn in_wall(self, height: f32) -> Self {
        const ROOMS: std::ops::RangeInclusive<f32> = 2.2..=12.0;
        const USUAL: f32 = 2.5;
        let factor = if ROOMS.contains(&height) { 1.0 } else { height / USUAL };
        Self {
            from: self.from * factor,
            sill: self.sill * factor,
            width: self.width * factor,
            height: self.height * factor,
        }
    }
}

/// A parameter of a building part.
pub enum SolidValue<'s> {
    /// A length in units of the part's own space.
    Length(&'s mut f32),
    /// A whole number.
    Count(&'s mut u32),
    /// The openings of a wall.
    Openings(&'s mut Vec<Opening>),
}

/// A length with the limits of the panel; files may have smaller ones ([`file_range`]).
const fn length(name: &'static str, label: &'static str, about: &'static str) -> ParameterInfo {
    ParameterInfo::new(name, label, about, "a length above 0").within(1e-4..=f32::MAX)
}

const LENGTH: ParameterInfo = length("length", "Length", "The extent from its start to its end.");
const HEIGHT: ParameterInfo = length("height", "Height", "The extent upwards.");
const THICKNESS: ParameterInfo = length(
    "thickness",
    "Thickness",
    "The extent across, half to either side of its middle.",
);
const WIDTH: ParameterInfo = length("width", "Width", "The extent across.");
const DEPTH: ParameterInfo = length("depth", "Depth", "The extent from the first step to the back.");
const RADIUS: ParameterInfo = length("radius", "Radius", "The distance of the lower corners from the axis.");
const TOP_RADIUS: ParameterInfo = ParameterInfo::new(
    "top_radius",
    "Top radius",
    "The distance of the upper corners from the axis.",
    "0 or more; 0 is a point",
)
.within(0.0..=f32::MAX);
const STEPS: ParameterInfo =
    ParameterInfo::new("steps", "Steps", "The number of steps, all equal.", "1 to 200").within(1.0..=200.0);
const SIDES: ParameterInfo =
    ParameterInfo::new("sides", "Sides", "The number of sides.", "3 to 256").within(3.0..=256.0);
const OPENINGS: ParameterInfo = ParameterInfo::new(
    "openings",
    "Openings",
    "Doors and windows.",
    "for each the distance from the start, the height of the lower edge, the width and the height, with ; between them",
);

impl Default for Solid {
    fn default() -> Self {
        Self::Wall {
            length: 4.0,
            height: 2.5,
            thickness: 0.2,
            openings: Vec::new(),
        }
    }
}

impl Solid {
    /// The names of all plugins.
    pub const PLUGINS: [&'static str; 3] = ["wall", "stairs", "prism"];
    /// The most openings of a wall, so that the mesh of a mistyped file stays small.
    pub const MOST_OPENINGS: usize = 64;

    /// What a plugin of this name is when its file gives no parameter; None if there is no such plugin.
    pub fn of_plugin(plugin: &str) -> Option<Self> {
        match plugin {
            "wall" => Some(Self::default()),
            "stairs" => Some(Self::Stairs {
                width: 1.0,
                depth: 4.0,
                height: 2.5,
                steps: 14,
            }),
            "prism" => Some(Self::Prism {
                radius: 0.5,
                top_radius: 0.5,
                height: 1.0,
                sides: 6,
            }),
            _ => None,
        }
    }

    /// The name of its plugin.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Wall { .. } => "wall",
            Self::Stairs { .. } => "stairs",
            Self::Prism { .. } => "prism",
        }
    }

    /// Calls a function with every parameter, in the order of the file.
    pub(crate) fn visit_mut(&mut self, visit: &mut dyn FnMut(&'static ParameterInfo, SolidValue)) {
        use SolidValue::{Count, Length, Openings};
        match self {
            Self::Wall {
                length,
                height,
                thickness,
                openings,
            } => {
                visit(&LENGTH, Length(length));
                visit(&HEIGHT, Length(height));
                visit(&THICKNESS, Length(thickness));
                visit(&OPENINGS, Openings(openings));
            }
            Self::Stairs {
                width,
                depth,
                height,
                steps,
            } => {
                visit(&WIDTH, Length(width));
                visit(&DEPTH, Length(depth));
                visit(&HEIGHT, Length(height));
                visit(&STEPS, Count(steps));
            }
            Self::Prism {
                radius,
                top_radius,
                height,
                sides,
            } => {
                visit(&RADIUS, Length(radius));
                visit(&TOP_RADIUS, Length(top_radius));
                visit(&HEIGHT, Length(height));
                visit(&SIDES, Count(sides));
            }
        }
    }

    /// Calls a function with every length, those of openings as well.
    pub(crate) fn visit_lengths(&mut self, visit: &mut dyn FnMut(&mut f32)) {
        self.visit_mut(&mut |_, value| match value {
            SolidValue::Length(length) => visit(length),
            SolidValue::Count(_) => {}
            SolidValue::Openings(openings) => {
                for opening in openings {
                    let Opening {
                        from,
                        sill,
                        width,
                        height,
                    } = opening;
                    [from, sill, width, height].into_iter().for_each(&mut *visit);
                }
            }
        });
    }

    /// Two opposite corners of the box around it, in its own space.
    pub fn corners(&self) -> [Vec3; 2] {
        match *self {
            Self::Wall {
                length,
                height,
                thickness,
                ..
            } => [
                Vec3::new(0.0, -0.5 * thickness, 0.0),
                Vec3::new(length, 0.5 * thickness, height),
            ],
            Self::Stairs {
                width, depth, height, ..
            } => [Vec3::new(-0.5 * width, 0.0, 0.0), Vec3::new(0.5 * width, depth, height)],
            Self::Prism {
                radius,
                top_radius,
                height,
                ..
            } => {
                let reach = radius.max(top_radius);
                [Vec3::new(-reach, -reach, 0.0), Vec3::new(reach, reach, height)]
            }
        }
    }

    /// The part with all its lengths times this factor.
    pub fn scaled(mut self, factor: f32) -> Self {
        self.visit_mut(&mut |_, value| match value {
            SolidValue::Length(length) => *length *= factor,
            SolidValue::Count(_) => {}
            SolidValue::Openings(openings) => {
                for Opening {
                    from,
                    sill,
                    width,
                    height,
                } in openings
                {
                    for length in [from, sill, width, height] {
                        *length *= factor;
                    }
                }
            }
        });
        self
    }
}

/// The values that a file may give a length: what is above 0 for the panel may be as small as numbers are, as tiny
/// scenes need.
pub(crate) fn file_range(info: &ParameterInfo) -> RangeInclusive<f32> {
    let start = *info.range.start();
    let least = if start > 0.0 { f32::MIN_POSITIVE } else { start };
    least..=*info.range.end()
}

/// The text of openings in a file: four numbers for each (from, sill, width, height), with `;` between the openings.
pub fn openings_text(openings: &[Opening]) -> String {
    let text = |opening: &Opening| {
        let numbers = [opening.from, opening.sill, opening.width, opening.height];
        numbers.map(format_float).join(" ")
    };
    openings.iter().map(text).collect::<Vec<_>>().join("; ")
}

/// Says what is wrong with the text of openings.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpeningsError {
    /// A part of the text is not a number.
    #[error(transparent)]
    Value(#[from] ValueError),
    /// An opening has more or fewer than four numbers.
    #[error("expected four numbers (from, sill, width, height), found `{0}`")]
    Numbers(String),
    /// An opening has no extent.
    #[error("expected openings with a width and a height above 0")]
    Extent,
    /// There are more openings than a part may have.
    #[error("expected at most {most} openings, found {0}", most = Solid::MOST_OPENINGS)]
    Count(usize),
}

/// Reads the text of openings.
pub fn parse_openings(text: &str) -> Result<Vec<Opening>, OpeningsError> {
    let mut openings = Vec::new();
    for part in text.split(';').filter(|part| !part.trim().is_empty()) {
        let numbers: Vec<f32> = fields(part).map(parse_float).collect::<Result<_, _>>()?;
        let &[from, sill, width, height] = numbers.as_slice() else {
            return Err(OpeningsError::Numbers(part.trim().to_owned()));
        };
        if !(width > 0.0 && height > 0.0) {
            return Err(OpeningsError::Extent);
        }
        openings.push(Opening {
            from,
            sill,
            width,
            height,
        });
    }
    match openings.len() {
        0..=Solid::MOST_OPENINGS => Ok(openings),
        count => Err(OpeningsError::Count(count)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn openings_are_read_as_they_are_written() {
        let door = Opening {
            from: 0.5,
            sill: 0.0,
            width: 0.9,
            height: 2.1,
        };
        let window = Opening { sill: 0.9, ..door };
        assert_eq!(openings_text(&[door, window]), "0.5 0 0.9 2.1; 0.5 0.9 0.9 2.1");
        for openings in [vec![], vec![door], vec![door, window]] {
            assert_eq!(parse_openings(&openings_text(&openings)), Ok(openings));
        }
        assert_eq!(parse_openings(" 0.5, 0, 0.9, 2.1 ; "), Ok(vec![door]));
    }

    #[test]
    fn openings_that_are_none_are_refused_with_what_is_expected() {
        for text in ["1 2 3", "1 2 3 4 5", "1 2 x 4", "1 2 0 4", "1 2 3 -4", "1 2 nan 4"] {
            assert!(
                parse_openings(text).is_err_and(|error| {
                    let error = error.to_string();
                    error.starts_with("expected") || error.contains("number")
                }),
                "{text}"
            );
        }
        assert!(parse_openings(&"0 0 1 1;".repeat(65)).is_err());
    }

    #[test]
    fn lengths_scale_and_counts_do_not() {
        let stairs = Solid::of_plugin("stairs").map(|stairs| stairs.scaled(2.0));
        let expected = Solid::Stairs {
            width: 2.0,
            depth: 8.0,
            height: 5.0,
            steps: 14,
        };
        assert_eq!(stairs, Some(expected));
    }
}
