//! Finds the cells of texels that are hidden by objects standing on the surface.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec2;
use rayon::prelude::*;

use super::spread::Corners;
use super::texels::Texels;
use crate::accel::Tlas;
use crate::math::Ray;

/// The height above the surface at which visibility is tested, as a share of the side of a texel.
const HEIGHT: f32 = 1.0 / 32.0;

/// Removes the cells that cannot be seen from the centres of their texels. It ends soon after `cancel` is set, with
/// some of the texels done.
pub fn keep_in_sight(texels: &mut Texels, geometry: &Tlas, cancel: &AtomicBool) {
    let Texels { texels, spreads, .. } = texels;
    texels.par_iter().zip(spreads).for_each(|(texel, spread)| {
        if !spread.has_cells() || cancel.load(Ordering::Relaxed) {
            return;
        }
        let receiver = &texel.receiver;
        let lift = (HEIGHT * spread.side() + receiver.error) * receiver.geometric_normal;
        let is_seen = |part: Vec2| {
            let sight = Ray::segment(receiver.position + lift, spread.at(part) + lift);
            !geometry.occluded(&sight)
        };
        // Most texels are unobstructed: if the corners and the midpoints of the sides are visible, no more is tested.
        let mut outer = (0..9)
            .filter(|number| *number != 4)
            .map(|number| Vec2::new((number % 3) as f32, (number / 3) as f32));
        if outer.all(|part| is_seen(0.5 * part)) {
            return;
        }
        let mut seen = Corners::default();
        for (corner, _) in Corners::all().filter(|(_, part)| is_seen(*part)) {
            seen.add(corner);
        }
        spread.keep(seen);
    });
}
