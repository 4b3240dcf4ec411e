//! Places and aims of lamps, and the hour of the sun, for the light that is wanted: the search over what may change.

use std::sync::atomic::AtomicBool;

use super::lamp_freedom::{FreeLamp, LampChange};
use crate::inverse_lighting::{
    Fit, LampLimits, Limit, Painting, PixelLight, Places, Target, Tried, Unsolvable, place, solve,
};
use crate::render::lamps_alone::{Quantity, light_of_pixels};
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The most pixels of each quantity that are rendered at a place.
pub const MOST_PIXELS: usize = 4096;
/// The usual number of samples of all pixels together at a place.
pub const SAMPLES: usize = 1 << 17;
/// The fewest and the most samples of a pixel.
const SAMPLES_OF_PIXEL: [usize; 2] = [4, 256];

/// Everything that the search needs: it is a copy, so that the scene may change meanwhile.
#[derive(Clone, Debug)]
pub struct LampSearch {
    /// The scene.
    pub scene: RenderScene,
    /// The view of the picture.
    pub view: View,
    /// The lamps that may change, and the number of each among those of `limits`.
    pub free: Vec<(FreeLamp, usize)>,
    /// All lamps whose strengths are unknown, and those that may change.
    pub limits: Vec<LampLimits>,
    /// What is wanted.
    pub targets: Vec<Target>,
    /// The light of the lamps as they are.
    pub light: PixelLight,
    /// The samples of all pixels together at a place, of each quantity and lamp.
    pub samples: usize,
}

/// The best changes.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundLamps {
    /// The change of each lamp of [`LampSearch::free`].
    pub changes: Vec<LampChange>,
    /// Whether each of these lamps is at a limit.
    pub at_limit: Vec<bool>,
    /// The strengths.
    pub fit: Fit,
    /// The root mean squared relative error with the best strengths before, and after the change.
    pub errors: [f64; 2],
    /// The number of places that were tried.
    pub tried: usize,
}

/// The reason why a search has ended without an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoPlace {
    /// It was cancelled.
    #[error("the search was cancelled")]
    Cancelled,
    /// There is nothing to go by.
    #[error("{0}")]
    Unsolvable(#[from] Unsolvable),
}

impl LampSearch {
    /// Searches on the threads of the current `rayon` pool; the result does not depend on their number. `watch` gets
    /// the share of the work that is done, from 0 to 1, and the error so far.
    pub fn run(mut self, cancel: &AtomicBool, watch: &mut dyn FnMut(f64, f64)) -> Result<FoundLamps, NoPlace> {
        let ranges: Vec<_> = self.free.iter().flat_map(|(lamp, _)| lamp.ranges()).collect();
        let mut painting = Painting::default();
        let targets = std::mem::take(&mut self.targets);
        painting.set(targets, [self.view.width, self.view.height], self.limits.len());
        let mut try_at = |values: &[f64]| -> Result<_, NoPlace> {
            let Some(changes) = self.relight(values, cancel)? else {
                return Ok(None);
            };
            painting.forget();
            painting.observe(&self.light, || false);
            let observations = painting.observations();
            let fit = solve(&observations, &self.limits)?;
            Ok(Some(Tried {
                residuals: observations.residuals(&fit.gains),
                found: (changes, fit),
            }))
        };
        let placed = place(&ranges, &mut try_at, watch)?.ok_or(Unsolvable::NoPaint)?;
        let (changes, fit) = placed.found;
        let mut limits: &[Option<Limit>] = &placed.limits;
        let mut at_limit = Vec::new();
        for (lamp, _) in &self.free {
            let (own, others) = limits.split_at(lamp.ranges().len());
            at_limit.push(own.iter().any(Option::is_some));
            limits = others;
        }
        Ok(FoundLamps {
            changes,
            at_limit,
            fit,
            errors: [placed.error_before, placed.error],
            tried: placed.tried,
        })
    }

    /// Renders the lamps after these changes. Ok(None) if a lamp cannot be so.
    fn relight(&mut self, values: &[f64], cancel: &AtomicBool) -> Result<Option<Vec<LampChange>>, NoPlace> {
        let mut values = values;
        let mut changes = Vec::new();
        for (lamp, number) in &self.free {
            let (own, others) = values.split_at(lamp.ranges().len());
            values = others;
            let change = lamp.change(own);
            let Some(scene) = lamp.alone(&self.scene, &change) else {
                return Ok(None);
            };
            let render = |places: &mut Places, quantity| {
                let pixels = places.pixels();
                let [least, most] = SAMPLES_OF_PIXEL;
                let samples = (self.samples / pixels.len().max(1)).clamp(least, most);
                let light = light_of_pixels(&scene, &self.view, quantity, pixels, samples as u32, cancel);
                places.set_light(*number, &light.ok_or(NoPlace::Cancelled)?);
                Ok::<_, NoPlace>(())
            };
            render(&mut self.light.radiance, Quantity::Radiance)?;
            render(&mut self.light.irradiance, Quantity::Irradiance)?;
            changes.push(change);
        }
        Ok(Some(changes))
    }
}
