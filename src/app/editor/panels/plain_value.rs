//! The values of parameters that are the same everywhere.

use crate::color::Rgb;

/// A parameter's value where it is the same everywhere, as a colour that textures begin with.
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
