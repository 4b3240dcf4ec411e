//! Null-collision tracking through heterogeneous media: collisions are sampled as if the extinction were the majorant,
//! and some of them are null collisions, which have no effect (Woodcock et al. 1965; Kutz et al., Spectral and
//! Decomposition Tracking for Rendering Heterogeneous Volumes, 2017; PBR 4th ed., sections 11.2.1 and 14.2). Shadow
//! rays multiply the probabilities of null collisions: ratio tracking (Novák, Selle and Jarosz 2014).

use glam::Vec3;

use super::majorants::{MOST_TRIED, MajorantGrid};
use super::{MediumSource, Travel, Volume, Way, chance};
use crate::color::Rgb;
use crate::sampling::RandomStream;

/// The transmittance below which Russian roulette is applied to a shadow ray, and the probability that the ray
/// survives.
const FAINT: f32 = 0.1;
const GOES_ON: f32 = 0.5;

/// A tentative collision.
struct Collision {
    t: f32,
    point: Vec3,
    majorant: f32,
    /// The probability of a null collision, per channel.
    null: Rgb,
}

/// Calls `collide` with the throughput at each tentative collision until that returns a value or the segment ends. `u`
/// decides where the first collision is. Grids end with their boxes, as in Mitsuba.
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
        // Outside, where the extinction is constant, the segment may be long or infinite. The majorant then drops to
        // the largest extinction of the channels with light left.
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
            // Infinity times zero would be NaN.
            if majorant > 0.0 {
                depth -= majorant * (segment.end - t);
            }
        }
        t = segment.end;
    }
    None
}

/// Implements [`super::Medium::travel`].
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
                // Light that is not absorbed goes on to the end.
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

/// Implements [`super::Medium::transmit`].
pub(super) fn transmit(
    source: &MediumSource,
    majorants: &MajorantGrid,
    way: &Way,
    carried: &mut Rgb,
    stream: &mut RandomStream,
) -> (Rgb, f32) {
    let (mut share, mut passed) = (Rgb::ONE, 1.0);
    let scatters = source.scatters();
    // The factor by which roulette has raised surviving rays. The weights of multiple importance sampling ignore it.
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
