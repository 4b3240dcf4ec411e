//! Squares of two colours.

use glam::{Affine2, Vec2};

use super::Parameter;
use crate::color::Rgb;

/// Two by two squares per unit of transformed uv. For colours, `colors[0]` is at the origin; for numbers it is
/// `colors[1]`, as in Mitsuba 3.9, for which scenes are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checkerboard {
    /// The two colours, each of which may be a texture before this one in the table.
    pub colors: [Parameter<Rgb>; 2],
    /// The transform of uv before sampling.
    pub to_uv: Affine2,
}

impl Checkerboard {
    /// The colour of the square that holds `uv`.
    pub(super) fn color(&self, uv: Vec2) -> Parameter<Rgb> {
        self.colors[usize::from(self.is_odd(uv))]
    }

    /// The number of the square that holds `uv`.
    pub(super) fn number(&self, uv: Vec2) -> Parameter<Rgb> {
        self.colors[usize::from(!self.is_odd(uv))]
    }

    fn is_odd(&self, uv: Vec2) -> bool {
        let uv = self.to_uv.transform_point2(uv);
        let second_half = |x: f32| x - x.floor() > 0.5;
        second_half(uv.x) != second_half(uv.y)
    }
}
