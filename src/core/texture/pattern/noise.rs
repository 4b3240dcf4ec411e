//! Gradient noise: Perlin, Improving Noise, SIGGRAPH 2002, in two dimensions.

use glam::Affine2;

use super::hash::hash;
use super::*;
use crate::math::Word;

/// Noise between two colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The colours at the values 0 and 1, each of which may be a texture before this one in the table.
    pub colors: [Parameter<Rgb>; 2],
    /// The number of noises of halved size that are added up, from 1 to [`Self::MOST_OCTAVES`].
    pub octaves: u32,
    /// The factor on the amplitude from one octave to the next, at least 0.
    pub gain: f32,
    /// The distance by which points are moved before the noise is looked up, in its lattice cells. It bends lines as in
    /// marble.
    pub distortion: f32,
    /// Whether the value is 1 along the lines where the noise is 0, and falls off to both sides.
    pub ridged: bool,
    /// The transform of uv; the lattice of the first octave has one cell per unit.
    pub to_uv: Affine2,
}

/// The factor that brings gradient noise in the plane to [-1, 1]: with unit gradients its extremes are at the middle of
/// a cell, the root of one half.
const TO_UNIT: f32 = std::f32::consts::SQRT_2;

/// The cosine and sine of pi / 8: gradients point between the axes and the diagonals, where no lines of the lattice
/// run.
const GRADIENT: [f32; 2] = [0.923_879_5, 0.382_683_43];

/// The seeds of the noises that move points.
const DISTORTIONS: [u32; 2] = [101, 102];

impl Noise {
    /// The most octaves: the last one is finer than the rounding of its coordinates.
    pub const MOST_OCTAVES: u32 = 16;

    /// The value in [0, 1] at a point of the pattern, with the mean 1/2 unless it is ridged.
    pub fn share<R: Real>(&self, [x, y]: [R; 2]) -> R {
        let mut at = [x, y];
        if self.distortion != 0.0 {
            let [dx, dy] = DISTORTIONS.map(|seed| R::splat(self.distortion) * gradient_noise([x, y], seed));
            at = [x + dx, y + dy];
        }
        let noise = fractal(at, self.octaves, self.gain);
        let value = match self.ridged {
            true => R::ONE - noise.abs(),
            false => R::HALF + R::HALF * noise,
        };
        value.saturated()
    }

    /// The value at a point of a surface.
    pub(in crate::texture) fn value<V: TextureValue>(&self, table: &TextureTable, at: &TexturePoint) -> V {
        let share = self.share(point(&self.to_uv, at.uv));
        mixed(table, self.colors, share, at)
    }

    /// The step for derivatives, in coordinates of the pattern.
    pub(in crate::texture) fn step(&self) -> f32 {
        // Below the least step values of the last octaves would differ by rounding.
        (STEP / (1_u32 << (self.octaves.clamp(1, Self::MOST_OCTAVES) - 1)) as f32).max(1e-5)
    }
}

/// The sum of octaves, scaled so that its variance is that of one.
pub(super) fn fractal<R: Real>(at: [R; 2], octaves: u32, gain: f32) -> R {
    let (mut sum, mut squares) = (R::ZERO, 0.0);
    let (mut amplitude, mut frequency) = (1.0, 1.0);
    for octave in 0..octaves.clamp(1, Noise::MOST_OCTAVES) {
        let noise = gradient_noise(at.map(|x| x * R::splat(frequency)), octave);
        sum += R::splat(amplitude) * noise;
        squares += amplitude * amplitude;
        amplitude *= gain;
        frequency *= 2.0;
    }
    sum * R::splat(1.0 / f32::sqrt(squares))
}

/// Noise in [-1, 1] that is 0 at the corners of the lattice, with the random gradients of a seed.
#[inline(always)]
pub(super) fn gradient_noise<R: Real>([x, y]: [R; 2], seed: u32) -> R {
    let (left, low) = (x.floor(), y.floor());
    let (dx, dy) = (x - left, y - low);
    let slope = |i: f32, j: f32| {
        let (i, j) = (R::splat(i), R::splat(j));
        along_gradient(hash([left + i, low + j], seed), dx - i, dy - j)
    };
    let (tx, ty) = (fade(dx), fade(dy));
    let between = |a: R, b: R, t: R| a + (b - a) * t;
    let lower = between(slope(0.0, 0.0), slope(1.0, 0.0), tx);
    let upper = between(slope(0.0, 1.0), slope(1.0, 1.0), tx);
    R::splat(TO_UNIT) * between(lower, upper, ty)
}

/// The dot product of an offset with one of eight gradients.
#[inline(always)]
fn along_gradient<R: Real>(word: R::Word, dx: R, dy: R) -> R {
    let bit = |place: u32| R::is_at_least((word >> place) & R::Word::splat(1), 1);
    let [long, short] = GRADIENT.map(R::splat);
    let is_along_x = bit(0);
    let (x, y) = (R::select(is_along_x, long, short), R::select(is_along_x, short, long));
    R::select(bit(1), x * dx, -(x * dx)) + R::select(bit(2), y * dy, -(y * dy))
}

/// The polynomial 6 t^5 - 15 t^4 + 10 t^3, whose first and second derivatives are 0 at 0 and 1.
#[inline(always)]
fn fade<R: Real>(t: R) -> R {
    t * t * t * (t * (t * R::splat(6.0) - R::splat(15.0)) + R::splat(10.0))
}
