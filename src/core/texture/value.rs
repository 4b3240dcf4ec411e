//! Values of textures: colours, or numbers.

use std::ops::{Add, Mul};

use super::{Parameter, TexturePoint, TextureTable};
use crate::color::Rgb;

/// A colour, linear Rec. 709, or a number.
pub(crate) trait TextureValue: Copy + Add<Output = Self> + Mul<Output = Self> + Mul<f32, Output = Self> {
    /// The value of a colour; the number of a colour is its mean.
    fn of_color(color: Rgb) -> Self;

    /// The value of a nested parameter at a point.
    fn nested(table: &TextureTable, parameter: Parameter<Rgb>, at: &TexturePoint) -> Self;
}

impl TextureValue for Rgb {
    fn of_color(color: Rgb) -> Self {
        color
    }

    fn nested(table: &TextureTable, parameter: Parameter<Rgb>, at: &TexturePoint) -> Self {
        table.color(parameter, at)
    }
}

impl TextureValue for f32 {
    fn of_color(color: Rgb) -> Self {
        color.element_sum() / 3.0
    }

    fn nested(table: &TextureTable, parameter: Parameter<Rgb>, at: &TexturePoint) -> Self {
        match parameter {
            Parameter::Constant(color) => Self::of_color(color),
            Parameter::Texture(id) => table.float_of(id, at),
        }
    }
}

/// The two parameters in the shares `1 - share` and `share`.
pub(super) fn mixed<V: TextureValue>(
    table: &TextureTable,
    [first, second]: [Parameter<Rgb>; 2],
    share: f32,
    at: &TexturePoint,
) -> V {
    if share <= 0.0 {
        V::nested(table, first, at)
    } else if share >= 1.0 {
        V::nested(table, second, at)
    } else {
        V::nested(table, first, at) * (1.0 - share) + V::nested(table, second, at) * share
    }
}
