//! Motion blur: the samples of a picture are spread over moments of the time in which the shutter is open.
//!
//! Each moment is a scene and a view of its own, and a sample sees one of them: the accumulation buffer of Haeberli and
//! Akeley, "The Accumulation Buffer: Hardware Support for High-Quality Rendering", 1990. So everything can move, and
//! rays cost as much as in a still scene. The moments are the centres of equal parts of the open time. Objects that
//! move by more than a pixel between moments show as many edges.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::clamp::{BrightnessLimit, Clamp};
use super::guide::Guide;
use super::scene::RenderScene;
use super::tile::{Tile, TileSamples, render_tile};
use super::view::View;

/// The scene and the view at one moment.
pub type Moment = (RenderScene, View);

/// The moments over which samples are spread, ordered so that any first few samples are well spread.
#[derive(Clone, Debug)]
pub struct Shutter {
    moments: Arc<[Moment]>,
    /// The guides of their scenes.
    guides: Arc<[Guide]>,
}

impl Shutter {
    /// The most moments: with more, packing them would take longer than tracing their samples.
    pub const MOST: u32 = 64;

    /// The shutter over moments in the order of time; None if there are none. `guide` is the guide of `scene`, and may
    /// be learnt already.
    pub fn new(moments: &[Moment], (scene, guide): (&RenderScene, &Guide)) -> Option<Self> {
        let first = moments.first()?;
        let photons = first.1.photons.clone();
        let moment = |place: usize| {
            let (scene, view) = moments[place].clone();
            // A cache for each moment would keep the photons of many finished samples.
            let photons = photons.clone();
            // A clamp caches few limits, and each moment has one.
            let clamp = view.clamp.map(|clamp| Clamp::new(clamp.percentile));
            let view = View { photons, clamp, ..view };
            (scene, view)
        };
        let moments: Vec<Moment> = spread_order(moments.len()).into_iter().map(moment).collect();
        // Moments with the same scene share its guide: all of them if only the camera moves.
        let mut guides: Vec<Guide> = Vec::new();
        for moment in &moments {
            let before = moments
                .iter()
                .zip(&guides)
                .find(|(before, _)| before.0.is_same(&moment.0));
            let known = before.map(|(_, guide)| guide.clone());
            let known = known.or_else(|| moment.0.is_same(scene).then(|| guide.clone()));
            guides.push(known.unwrap_or_default());
        }
        let shutter = Self {
            moments: moments.into(),
            guides: guides.into(),
        };
        Some(shutter.with_method_of(&first.1))
    }

    /// The same moments with the integrator of another view, and with its guiding.
    pub fn with_method_of(&self, other: &View) -> Self {
        let moment = |((scene, view), guide): (&Moment, &Guide)| {
            let view = View {
                integrator: other.integrator,
                guide: other.guide.as_ref().map(|_| guide.clone()),
                ..view.clone()
            };
            (scene.clone(), view)
        };
        Self {
            moments: self.moments.iter().zip(&*self.guides).map(moment).collect(),
            guides: self.guides.clone(),
        }
    }

    /// The same moments with other random numbers.
    pub fn with_seed(&self, seed: u32) -> Self {
        let moment = |(scene, view): &Moment| (scene.clone(), View { seed, ..view.clone() });
        Self {
            moments: self.moments.iter().map(moment).collect(),
            guides: self.guides.clone(),
        }
    }

    /// The number of moments.
    pub fn moments(&self) -> usize {
        self.moments.len()
    }

    /// The number of moments for this many samples per pixel: as many, or, beyond [`Self::MOST`], such that each gets
    /// about as many samples.
    pub fn moments_for(samples: u32) -> u32 {
        samples.div_ceil(samples.div_ceil(Self::MOST).max(1)).max(1)
    }

    /// The centres of `moments` equal parts of the time from `open` to `close`.
    pub fn times(open: f64, close: f64, moments: u32) -> impl Iterator<Item = f64> {
        let part = (close - open) / f64::from(moments);
        (0..moments).map(move |moment| open + (f64::from(moment) + 0.5) * part)
    }

    /// The brightness limit at the first moment; None without a clamp, and until the limit is known.
    pub fn clamped(&self) -> Option<BrightnessLimit> {
        self.moments.first()?.1.clamp.as_ref()?.found()
    }

    /// The guides of the moments.
    pub fn guides(&self) -> impl Iterator<Item = &Guide> {
        self.guides.iter()
    }

    /// Whether these are the same moments.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.moments, &other.moments)
    }

    /// Renders samples as [`render_tile`] does, each at its moment.
    pub fn render_tile(&self, tile: Tile, samples: Range<u32>, cancel: &AtomicBool) -> Option<TileSamples> {
        let mut whole: Option<TileSamples> = None;
        for sample in samples {
            let (scene, view) = &self.moments[sample as usize % self.moments.len()];
            let one = render_tile(scene, view, tile, sample..sample + 1, cancel)?;
            match &mut whole {
                Some(whole) => whole.append(&one),
                None => whole = Some(one),
            }
        }
        whole
    }
}

/// The numbers below `count` in the order of the van der Corput sequence in base 2 (Niederreiter, "Random Number
/// Generation and Quasi-Monte Carlo Methods", 1992, section 3.1), whose first members are always far apart.
fn spread_order(count: usize) -> Vec<usize> {
    let mut by_value: Vec<u32> = (0..count as u32).collect();
    by_value.sort_unstable_by_key(|&index| index.reverse_bits());
    let mut order = vec![0; count];
    for (rank, index) in by_value.into_iter().enumerate() {
        order[index as usize] = rank;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_visits_every_moment_and_is_spread_from_the_start() {
        assert_eq!(spread_order(8), [0, 4, 2, 6, 1, 5, 3, 7]);
        for count in [1, 2, 5, 48, 63, 64] {
            let mut all = spread_order(count);
            // The first half leaves no gap of more than three moments.
            let mut half = all[..count.div_ceil(2)].to_vec();
            half.sort_unstable();
            assert!(half.windows(2).all(|pair| pair[1] - pair[0] <= 3), "{count}: {half:?}");
            all.sort_unstable();
            assert!(all.into_iter().eq(0..count));
        }
    }

    #[test]
    fn moments_are_the_middles_of_equal_parts() {
        let times: Vec<f64> = Shutter::times(1.0, 2.0, 4).collect();
        assert_eq!(times, [1.125, 1.375, 1.625, 1.875]);
        assert_eq!(
            [1, 16, 64, 100, 256, 1000].map(Shutter::moments_for),
            [1, 16, 64, 50, 64, 63]
        );
    }
}
