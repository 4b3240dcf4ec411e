//! A material parameter during conversion to glTF: a constant, or a texture with operations on its values.

use crate::color::Rgb;
use crate::scene::{Parameter, Texture};

/// A number or a colour.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Level {
    /// A constant.
    Constant(Rgb),
    /// A texture.
    Varying(Varying),
}

/// The values of a texture after `map`, times `factor`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Varying {
    pub texture: Texture,
    /// Whether it is a number, the luminance of the texture's colour.
    pub as_number: bool,
    pub map: Map,
    pub factor: Rgb,
}

/// The operation on each value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Map {
    Same,
    Root,
    Square,
    /// Negates y of normals, for mirrored texture coordinates.
    Normals,
    /// Turns heights, times the scale, into the normals of a box projection, whose coordinates are lengths.
    Bumps {
        scale: f32,
        /// Whether y is negated.
        is_mirrored: bool,
    },
}

impl Map {
    pub fn apply(self, value: Rgb) -> Rgb {
        match self {
            Self::Same => value,
            Self::Root => value.max(Rgb::ZERO).powf(0.5),
            Self::Square => value * value,
            Self::Normals => Rgb::new(value.x, 1.0 - value.y, value.z),
            // Slopes need values beside this one.
            Self::Bumps { .. } => value,
        }
    }
}

impl Level {
    pub fn number(number: f32) -> Self {
        Self::Constant(Rgb::splat(number))
    }

    pub fn of_color(parameter: &Parameter<Rgb>) -> Self {
        match parameter {
            Parameter::Constant(color) => Self::Constant(*color),
            Parameter::Texture(texture) => Self::varying(texture, false),
        }
    }

    pub fn of_number(parameter: &Parameter<f32>) -> Self {
        match parameter {
            Parameter::Constant(number) => Self::number(*number),
            Parameter::Texture(texture) => Self::varying(texture, true),
        }
    }

    fn varying(texture: &Texture, as_number: bool) -> Self {
        Self::Varying(Varying {
            texture: texture.clone(),
            as_number,
            map: Map::Same,
            factor: Rgb::ONE,
        })
    }

    /// The level after a map, which has to be applied before all factors.
    pub fn mapped(self, map: Map) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(map.apply(value)),
            Self::Varying(varying) => {
                let map = match (varying.map, map) {
                    (Map::Bumps { scale, is_mirrored }, Map::Normals) => Map::Bumps {
                        scale,
                        is_mirrored: !is_mirrored,
                    },
                    _ => map,
                };
                Self::Varying(Varying { map, ..varying })
            }
        }
    }

    pub fn times(self, factor: Rgb) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(factor * value),
            Self::Varying(varying) => Self::Varying(Varying {
                factor: factor * varying.factor,
                ..varying
            }),
        }
    }

    pub fn constant(&self) -> Option<Rgb> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Varying(_) => None,
        }
    }

    /// Whether it is this constant.
    pub fn is(&self, number: f32) -> bool {
        self.constant() == Some(Rgb::splat(number))
    }

    /// A blend with the weight `weight` of `other`. If one of them is a texture, the one with the greater weight is
    /// taken.
    pub fn mixed(self, other: Self, weight: f32) -> Self {
        match (self.constant(), other.constant()) {
            (Some(a), Some(b)) => Self::Constant(a.lerp(b, weight)),
            _ if weight > 0.5 => other,
            _ => self,
        }
    }
}
