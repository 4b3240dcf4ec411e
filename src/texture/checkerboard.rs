//! Squares of two colours.

use glam::{Affine2, Vec2};

use super::Parameter;
use crate::color::Rgb;

/// Two by two squares per unit of transformed uv, `colors[0]` at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checkerboard {
    pub colors: [Parameter<Rgb>; 2],
    pub to_uv: Affine2,
}

impl Checkerboard {
    /// The colour of the square that `uv` lies in.
    pub(super) fn square(&self, uv: Vec2) -> Parameter<Rgb> {
        let uv = self.to_uv.transform_point2(uv);
        let second_half = |x: f32| x - x.floor() > 0.5;
        self.colors[usize::from(second_half(uv.x) != second_half(uv.y))]
    }
}
