//! The values of parameters without a texture.

use crate::color::Rgb;

/// A parameter's value without a texture, as a colour that a new texture starts with.
pub(crate) trait PlainValue: Copy {
    fn of_color(color: Rgb) -> Self;
    fn to_color(self) -> Rgb;
}

impl PlainValue for Rgb {
    fn of_color(color: Rgb) -> Self {
        color
    }

    fn to_color(self) -> Rgb {
        self
    }
}

impl PlainValue for f32 {
    fn of_color(color: Rgb) -> Self {
        color.x
    }

    fn to_color(self) -> Rgb {
        Rgb::splat(self)
    }
}
