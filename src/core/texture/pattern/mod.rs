//! Procedural textures: their values follow from formulas over uv.
//!
//! A pattern has coordinates of its own, those of the surface after its `to_uv`. The formulas are written for one point
//! and for sixteen, and without products that are rounded once in lanes, so that both forms give the same bits.

mod bricks;
mod cells;
mod hash;
mod mix;
mod noise;
mod ramp;
mod wood;

use glam::{Affine2, Vec2};

use super::value::{TextureValue, mixed};
use super::{Parameter, TexturePoint, TextureTable};
use crate::color::Rgb;
use crate::math::Real;

pub use bricks::{Bond, Bricks};
pub use cells::{CellValue, Cells};
pub use mix::{Mix, MixMode};
pub use noise::Noise;
pub use ramp::{Ramp, Stop};
pub use wood::Wood;

/// The steps of bump maps, as a share of the finest detail of a pattern: the error of a quotient of differences grows
/// with the square of the step, and its rounding with the inverse.
const STEP: f32 = 1.0 / 64.0;

/// The largest coordinate of a pattern: numbers beyond have no digits left for details.
const FARTHEST: f32 = 4e6;

/// The point in the coordinates of a pattern.
fn point(to_uv: &Affine2, uv: Vec2) -> [f32; 2] {
    let Vec2 { x, y } = to_uv.transform_point2(uv);
    [x, y].map(|x| if x.is_nan() { 0.0 } else { x.clamp(-FARTHEST, FARTHEST) })
}

/// The largest factor by which a map of uv stretches.
pub(super) fn stretch(to_uv: &Affine2) -> f32 {
    to_uv.matrix2.x_axis.length().max(to_uv.matrix2.y_axis.length())
}

/// The interpolation from 0 to 1 whose slope is 0 at both ends: t^2 (3 - 2 t), with t limited to [0, 1].
#[inline(always)]
fn smooth<R: Real>(t: R) -> R {
    let t = t.saturated();
    t * t * (R::splat(3.0) - R::splat(2.0) * t)
}

/// A number without sign from 0 to 1 at `x` = 0, 2, 4, ... and from 1 to 0 between: a triangle wave.
#[inline(always)]
fn triangle_wave<R: Real>(x: R) -> R {
    let half = x * R::HALF;
    let share = half - half.floor();
    R::ONE - (share + share - R::ONE).abs()
}
