//! A value of a material on its way into glTF: a constant, or a texture with what is done to its values.

use crate::color::Rgb;
use crate::scene::{Parameter, Texture};

/// A number or a colour.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Level {
    /// The same everywhere.
    Constant(Rgb),
    /// By a texture.
    Varying(Varying),
}

/// The values of a texture: `factor` times what `map` makes of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Varying {
    pub texture: Texture,
    /// Whether it stands for a number, which is the luminance of its colour.
    pub as_number: bool,
    pub map: Map,
    pub factor: Rgb,
}

/// What is done to each value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Map {
    Same,
    Root,
    Square,
    /// y of normals turns around, for what lies mirrored.
    Normals,
}

impl Map {
    pub fn apply(self, value: Rgb) -> Rgb {
        match self {
            Self::Same => value,
            Self::Root => value.max(Rgb::ZERO).powf(0.5),
            Self::Square => value * value,
            Self::Normals => Rgb::new(value.x, 1.0 - value.y, value.z),
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

    /// The level after a map, which must come before all factors.
    pub fn mapped(self, map: Map) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(map.apply(value)),
            Self::Varying(varying) => Self::Varying(Varying { map, ..varying }),
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

    /// Whether it is this number everywhere.
    pub fn is(&self, number: f32) -> bool {
        self.constant() == Some(Rgb::splat(number))
    }

    /// A mixture with the share `weight` of the other. Of a texture and something else the one with the greater share
    /// is taken.
    pub fn mixed(self, other: Self, weight: f32) -> Self {
        match (self.constant(), other.constant()) {
            (Some(a), Some(b)) => Self::Constant(a.lerp(b, weight)),
            _ if weight > 0.5 => other,
            _ => self,
        }
    }
}
