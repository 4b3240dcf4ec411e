//! Null-collision tracking through media that vary: collisions are found as if the extinction were that of the
//! majorants, and some of them are null collisions, at which nothing happens (Woodcock et al. 1965; Kutz et al.,
//! Spectral and Decomposition Tracking for Rendering Heterogeneous Volumes, 2017; PBR 4th ed., sections 11.2.1 and
//! 14.2). Shadow rays multiply the shares of null collisions: ratio tracking (Novák, Selle and Jarosz 2014).

use glam::Vec3;

use super::majorants::{MOST_TRIED, MajorantGrid};
use super::{MediumSource, Travel, Volume, Way, chance};
use crate::color::Rgb;
use crate::sampling::RandomStream;

/// The share below which a shadow ray may be given up, and the probability that it goes on.
const FAINT: f32 = 0.1;
const GOES_ON: f32 = 0.5;

/// A tentative collision.
struct Collision {
    t: f32,
    point: Vec3,
    majorant: f32,
    /// The share that is a null collision, for each colour.
    null: Rgb,
}

/// Calls `collide` with the throughput at each tentative collision until that returns something or the way ends. `u`
/// decides where the first one is. Grids end with their boxes, as in Mitsuba.
#[inline(always)]
fn track<T>(
    source: &MediumSource,
    majorants: &MajorantGrid,
    way: &Way,
    u: f32,
    throughput: &mut Rgb,
    stream: &mut RandomStream,
    mut collide: impl FnMut(&Collision, &mut Rgb, &mut RandomStream) -> Option<T>,
) -> Option<T> {
    let exponential = |u: f32| -(1.0 - u).ln();
    let mut t = 0.0;
    // The optical depth up to the next collision.
    let mut depth = exponential(u);
    for segment in majorants.walk(way) {
        let mut majorant = segment.majorant;
        // Outside, where nothing varies, a colour that is left may have a longer way than the others, or one without an
        // end.
        let is_long = segment.is_outside && majorant * (segment.end - t) > MOST_TRIED;
        if majorant > 0.0 {
            while t + depth / majorant < segment.end {
                t += depth / majorant;
                depth = exponential(stream.draw());
                let point = way.origin + way.dir * t;
                let extinction = (source.sigma_t.within_bounds_at(point) * source.scale).min(Rgb::splat(majorant));
                let null = (Rgb::splat(majorant) - extinction) / majorant;
                let collision = Collision {
                    t,
                    point,
                    majorant,
                    null,
                };
                if let Some(result) = collide(&collision, throughput, stream) {
                    return Some(result);
                }
                if is_long {
                    let is_left = throughput.cmpgt(Rgb::ZERO);
                    majorant = Rgb::select(is_left, extinction, Rgb::ZERO).max_element();
                }
            }
            // Infinity times zero is no number.
            if majorant > 0.0 {
                depth -= majorant * (segment.end - t);
            }
        }
        t = segment.end;
    }
    None
}

/// Does what [`super::Medium::travel`] says.
pub(super) fn travel(
    source: &MediumSource,
    majorants: &MajorantGrid,
    way: &Way,
    throughput: &mut Rgb,
    u: f32,
    stream: &mut RandomStream,
) -> Travel {
    let mut passed = 1.0;
    let mut emitted = Rgb::ZERO;
    let shines = source.emission != Volume::ZERO;
    let scatters = source.scatters();
    let scattered_at = track(
        source,
        majorants,
        way,
        u,
        throughput,
        stream,
        |collision, throughput, stream| {
            let Collision {
                t,
                point,
                majorant,
                null,
            } = *collision;
            if shines {
                emitted += *throughput * source.emission.within_bounds_at(point) / majorant;
            }
            if !scatters {
                *throughput *= null;
                // What is left goes to the end without further ado.
                return (*throughput == Rgb::ZERO).then_some(None);
            }
            let is_null = chance::<f32>(*throughput, null);
            if stream.draw() < is_null {
                *throughput *= null / is_null;
                passed *= is_null;
                return None;
            }
            *throughput *= source.albedo_at(point) * (Rgb::ONE - null) / (1.0 - is_null);
            Some(Some(t))
        },
    );
    Travel {
        scattered_at: scattered_at.flatten(),
        passed,
        emitted,
    }
}

/// Does what [`super::Medium::transmit`] says.
pub(super) fn transmit(
    source: &MediumSource,
    majorants: &MajorantGrid,
    way: &Way,
    carried: &mut Rgb,
    stream: &mut RandomStream,
) -> (Rgb, f32) {
    let (mut share, mut passed) = (Rgb::ONE, 1.0);
    let scatters = source.scatters();
    // What roulette has given to rays that have gone on. The weights of multiple importance sampling do not see it.
    let mut raised = 1.0;
    let u = stream.draw();
    let given_up = track(
        source,
        majorants,
        way,
        u,
        carried,
        stream,
        |collision, carried, stream| {
            if scatters {
                passed *= chance::<f32>(*carried, collision.null);
            }
            *carried *= collision.null;
            share *= collision.null;
            let largest = share.max_element() * raised;
            if *carried == Rgb::ZERO || largest == 0.0 {
                return Some(());
            }
            if largest < FAINT {
                if stream.draw() >= GOES_ON {
                    return Some(());
                }
                raised /= GOES_ON;
            }
            None
        },
    );
    match given_up {
        Some(()) => {
            *carried = Rgb::ZERO;
            (Rgb::ZERO, 0.0)
        }
        None => (share * raised, passed),
    }
}
