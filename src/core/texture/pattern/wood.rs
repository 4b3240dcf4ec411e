//! The grain of sawn wood: the rings of a trunk where a board cuts them.

use glam::Affine2;

use super::hash::{hash, unit};
use super::noise::gradient_noise;
use super::*;

/// Annual rings on a board, which u runs along.
///
/// A ring is a circle around the pith, and its wood darkens from spring to autumn. The board lies beside the pith, at a
/// distance that changes along it as trunks bend and taper: arches follow in its middle and lines at its edges. Beside
/// the trunk lies its mirror image, and so on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wood {
    /// The colours of early and late wood, each of which may be a texture before this one in the table.
    pub colors: [Parameter<Rgb>; 2],
    /// The width of a ring, above 0.
    pub ring: f32,
    /// How far rings deviate from circles, in their widths.
    pub waviness: f32,
    /// The transform of uv before the look-up.
    pub to_uv: Affine2,
}

/// The radius of the trunk, the length along which its bend changes, and the extents of waves of a ring along the board
/// and across, in rings.
const TRUNK: f32 = 60.0;
const BEND: f32 = 250.0;
const WAVE: [f32; 2] = [40.0, 8.0];

/// The distance of the board from the pith, and how much it changes, in rings.
const DEPTH: [f32; 2] = [14.0, 18.0];

/// The share of a ring at which late wood ends and the next spring begins.
const AUTUMN: f32 = 0.86;

/// The seeds of bends, waves and the darkness of years.
const BENDS: u32 = 401;
const WAVES: u32 = 402;
const YEARS: u32 = 403;

impl Wood {
    /// The value from 0 in early wood to 1 in the darkest late wood, at a point of the pattern.
    pub fn share<R: Real>(&self, at: [R; 2]) -> R {
        let [x, y] = at.map(|x| x * R::splat(1.0 / self.ring));
        let trunk = R::splat(1.0 / TRUNK) * y;
        let across = triangle_wave(trunk) * R::splat(TRUNK);
        let bend = gradient_noise([x * R::splat(1.0 / BEND), (trunk * R::HALF).floor()], BENDS);
        let depth = R::splat(DEPTH[0]) + R::splat(DEPTH[1]) * bend;
        let wave = gradient_noise([x * R::splat(1.0 / WAVE[0]), y * R::splat(1.0 / WAVE[1])], WAVES);
        let radius = (across * across + depth * depth).sqrt() + R::splat(self.waviness) * wave;
        let year = radius.floor();
        let share = radius - year;
        let rise = share * R::splat(1.0 / AUTUMN);
        let fall = (R::ONE - share) * R::splat(1.0 / (1.0 - AUTUMN));
        let season = rise.min(fall);
        let darkness = R::HALF + R::HALF * unit::<R>(hash([year, R::ZERO], YEARS));
        (season * season * darkness).saturated()
    }

    /// The value at a point of a surface.
    pub(in crate::texture) fn value<V: TextureValue>(&self, table: &TextureTable, at: &TexturePoint) -> V {
        let share = self.share(point(&self.to_uv, at.uv));
        mixed(table, self.colors, share, at)
    }

    /// The step for derivatives, in coordinates of the pattern.
    pub(in crate::texture) fn step(&self) -> f32 {
        STEP * self.ring
    }
}
