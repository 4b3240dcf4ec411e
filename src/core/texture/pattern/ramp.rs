//! Colours by a value.

use std::sync::Arc;

use glam::Affine2;

use super::*;

/// A map from a value to colours, linear between its stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    /// The texture before this one in the table whose number is looked up; without it u is, after `to_uv`.
    pub input: Option<Parameter<Rgb>>,
    /// The colours by value, in ascending order. Values beyond the first and the last stop have their colours. Without
    /// stops all is black.
    pub stops: Arc<[Stop]>,
    /// The transform of uv if there is no input.
    pub to_uv: Affine2,
}

/// A colour of a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// The value with the colour.
    pub at: f32,
    /// Linear Rec. 709.
    pub color: Rgb,
}

impl Ramp {
    /// The two stops around a value, and the share of the second.
    fn around<R: Real>(&self, value: R, meet: impl Fn(R, Stop, Stop) -> R) -> R {
        let mut found = meet(R::ZERO, self.first(), self.first());
        for pair in self.stops.windows(2) {
            let [below, above] = [pair[0], pair[1]];
            let width = above.at - below.at;
            let share = match width > 0.0 {
                true => ((value - R::splat(below.at)) * R::splat(1.0 / width)).saturated(),
                false => R::ONE,
            };
            let is_beyond = R::splat(below.at).is_at_most(value);
            found = R::select(is_beyond, meet(share, below, above), found);
        }
        found
    }

    fn first(&self) -> Stop {
        let black = Stop {
            at: 0.0,
            color: Rgb::ZERO,
        };
        self.stops.first().copied().unwrap_or(black)
    }

    /// The colour of a value.
    pub fn color<R: Real>(&self, value: R) -> [R; 3] {
        std::array::from_fn(|channel| {
            self.around(value, |share, below, above| {
                let (below, above) = (below.color[channel], above.color[channel]);
                R::splat(below) * (R::ONE - share) + R::splat(above) * share
            })
        })
    }

    /// The value at a point of a surface.
    pub(in crate::texture) fn value<V: TextureValue>(&self, table: &TextureTable, at: &TexturePoint) -> V {
        let input = match self.input {
            Some(input) => f32::nested(table, input, at),
            None => point(&self.to_uv, at.uv)[0],
        };
        V::of_color(self.color(input).into())
    }

    /// The step for derivatives without an input, in coordinates of the pattern.
    pub(in crate::texture) fn step(&self) -> f32 {
        let widest = self.gaps().fold(0.0, f32::max);
        STEP * self.gaps().fold(if widest > 0.0 { widest } else { 1.0 }, f32::min)
    }

    /// The narrowest interval between two stops, at most 1: a share of the detail of the input.
    pub(in crate::texture) fn narrowest(&self) -> f32 {
        self.gaps().fold(1.0, f32::min)
    }

    /// The intervals between stops at different values.
    fn gaps(&self) -> impl Iterator<Item = f32> + '_ {
        let gaps = self.stops.windows(2).map(|pair| pair[1].at - pair[0].at);
        gaps.filter(|gap| *gap > 0.0)
    }
}
