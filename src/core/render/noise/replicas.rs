//! Replicas: a few pixels that are rendered a second time, with their own random numbers, to measure the noise of a
//! picture.
//!
//! How the error of a well distributed set of samples falls with their number cannot be derived from the set: over a
//! straight edge it falls in jumps. The predictions of `render/noise/mean_error.rs` are therefore compared with two
//! independent renders of the same pixels with equally many samples. Half the square of their difference has the
//! variance of either as its expectation, whatever the samples are, so that the sum over a random choice of pixels,
//! each divided by the probability of being chosen, estimates the squared error of the picture without bias (Horvitz
//! and Thompson, A generalization of sampling without replacement from a finite universe, Journal of the American
//! Statistical Association 47, 1952). The ratio of this sum to the predicted one corrects all predictions.
//!
//! Pixels are chosen once: most of them in and near noise, as estimated from the picture's first samples, and some
//! evenly over the picture. That the choice depends on samples of the picture makes no bias, since for any picture the
//! expectation over the choice is the sum over all pixels.
//!
//! Errors are relative to the likely luminance of a pixel, given the mean of both renders and the pixels around it
//! ([`crate::render::noise`]).
//!
//! A sum over few replicas that differ much is uncertain itself, and mostly too small by chance: bright replicas are
//! rare. Its reliability is measured by the number of equal replicas that would be as uncertain, the square of the sum
//! over the sum of the squares (Kish, Survey Sampling, 1965). The logarithm of the ratio is multiplied by the share of
//! the spread of true ratios in its whole spread.
//!
//! Replicas are not part of the picture. They exclude the light of splats, which comes from all pixels.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::UVec2;

use crate::color::luminance;
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::film::Film;
use crate::render::layers::Layers;
use crate::render::light_layers::LightGroups;
use crate::render::noise::{PictureNoise, around};
use crate::render::scene::RenderScene;
use crate::render::shutter::Shutter;
use crate::render::tile::{Tile, render_tile};
use crate::render::view::{Integrator, View};
use crate::sampling::hash::pcg3d;

/// One pixel in this many has a replica.
const SHARE: u32 = 50;
/// The fewest and the most replicas of a picture. Their accuracy depends on their number, not on the size of the
/// picture.
const NUMBERS: [u32; 2] = [256, 4096];
/// The share of the replicas that is spread evenly.
const EVENLY: f64 = 0.1;
/// The squared spread, from scene to scene, of the logarithm of the ratio of measured to predicted errors, if replicas
/// are many.
const SPREAD: f64 = 0.2;
/// The ratio of measured to predicted errors that is assumed if no replicas differ.
const LEAST_RATIO: f64 = 1e-6;
/// The most samples that are traced in one go.
const AT_ONCE: usize = 1024;
/// Separates the random numbers of replicas and of their choice from those of the picture.
const SEEDS: [u32; 2] = [0x7f4a_7c15, 0xbf58_476d];

/// A pixel that is rendered a second time.
#[derive(Clone, Debug, PartialEq)]
struct Replica {
    pixel: UVec2,
    /// The probability with which it was chosen.
    probability: f64,
    /// The samples so far.
    samples: u32,
    /// The sum of their luminances.
    sum: f64,
}

/// The replicas of a picture, rendered so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replicas(Vec<Replica>);

/// The samples that a replica lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The index of the replica among those of the picture.
    place: usize,
    pixel: UVec2,
    samples: Range<u32>,
}

/// The results of rendering some replicas.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplicaSums {
    /// The index of each, the end of its samples, and the sum of the new ones' luminances.
    sums: Vec<(usize, u32, f64)>,
    /// The rays that were traced.
    pub rays: u64,
}

/// Whether this integrator supports replicas. Photons are shared by all samples of a round, and others would have to be
/// traced for replicas.
pub fn has_replicas(integrator: Integrator) -> bool {
    !matches!(integrator, Integrator::Merging(..))
}

impl Replicas {
    /// Chooses pixels of these tiles of a film, in their order. `seed` is that of the picture.
    pub fn choose(film: &Film, tiles: &[Tile], seed: u32) -> Self {
        let dark = PictureNoise::of(film, tiles).dark();
        let noises: Vec<Vec<f32>> = tiles.iter().map(|tile| noise_near(film, *tile, dark)).collect();
        let pixels = noises.iter().map(Vec::len).sum::<usize>() as u32;
        let all: f64 = noises.iter().flatten().map(|&noise| f64::from(noise)).sum();
        let number = f64::from((pixels / SHARE).clamp(NUMBERS[0], NUMBERS[1]));
        let even = number / f64::from(pixels.max(1));
        let probability = |noise: f32| match all > 0.0 {
            true => (EVENLY * even + (1.0 - EVENLY) * number * f64::from(noise) / all).min(1.0),
            false => even.min(1.0),
        };
        // Along the pixels the probabilities add up, and each whole step of the sum from a random start chooses a
        // pixel.
        let [bits, ..] = pcg3d([seed, SEEDS[0], SEEDS[1]]);
        let mut sum = f64::from(bits) / 2f64.powi(32);
        let mut chosen = Vec::new();
        for (tile, noises) in tiles.iter().zip(&noises) {
            let places =
                (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| UVec2::new(tile.x + x, tile.y + y)));
            for (pixel, &noise) in places.zip(noises) {
                let probability = probability(noise);
                let next = sum + probability;
                if next.floor() > sum.floor() {
                    chosen.push(Replica {
                        pixel,
                        probability,
                        samples: 0,
                        sum: 0.0,
                    });
                }
                sum = next;
            }
        }
        Self(chosen)
    }

    /// The samples that the replicas lack compared with a film.
    pub fn missing(&self, film: &Film) -> Vec<Missing> {
        let missing = |(place, replica): (usize, &Replica)| {
            let end = film.samples(replica.pixel.x, replica.pixel.y);
            (replica.samples < end).then_some(Missing {
                place,
                pixel: replica.pixel,
                samples: replica.samples..end,
            })
        };
        self.0.iter().enumerate().filter_map(missing).collect()
    }

    /// Whether all replicas have as many samples as their pixels in a film.
    pub fn are_whole(&self, film: &Film) -> bool {
        let is_whole = |replica: &Replica| replica.samples == film.samples(replica.pixel.x, replica.pixel.y);
        self.0.iter().all(is_whole)
    }

    /// Adds the results of rendering.
    pub fn add(&mut self, rendered: &ReplicaSums) {
        for &(place, end, sum) in &rendered.sums {
            let replica = &mut self.0[place];
            replica.samples = end;
            replica.sum += sum;
        }
    }

    /// The ratio of a film's true squared error to the predicted one; `noise` is that of the tiles from which the
    /// replicas were chosen.
    pub fn correction(&self, film: &Film, noise: &PictureNoise) -> f32 {
        let squared = |replica: &Replica| {
            let [own, splatted] = film.mean_luminances(replica.pixel.x, replica.pixel.y).map(f64::from);
            let other = replica.sum / f64::from(replica.samples.max(1));
            let mean = 0.5 * (own + other) + splatted;
            let squared_error = (0.5 * (own - other)).powi(2);
            let likely = film.likely_luminance(replica.pixel, (mean as f32, squared_error as f32));
            let scale = f64::from(likely.abs().max(noise.dark()));
            match scale > 0.0 {
                true => 0.5 * ((own - other) / scale).powi(2) / replica.probability,
                false => 0.0,
            }
        };
        let found = self.0.iter().map(squared);
        let (sum, squares) = found.fold((0.0, 0.0), |(sum, squares), found| {
            (sum + found, squares + found * found)
        });
        believed(sum / noise.own_squares(), sum * sum / squares)
    }

    /// Writes the replicas.
    pub fn write(&self, to: &mut Writer) {
        to.put(self.0.len() as u32);
        for replica in &self.0 {
            to.put(replica.pixel);
            to.put(replica.samples);
            to.put([replica.probability, replica.sum]);
        }
    }

    /// Reads the replicas that [`Self::write`] has written for a picture of `size`.
    pub fn read(from: &mut Reader, size: UVec2) -> Result<Self, Damaged> {
        let mut replicas = Vec::new();
        for _ in 0..from.take::<u32>()? {
            let (pixel, samples) = (from.take::<UVec2>()?, from.take()?);
            let [probability, sum]: [f64; 2] = from.take()?;
            let is_possible = probability > 0.0 && probability <= 1.0 && sum.is_finite();
            Damaged::unless(pixel.cmplt(size).all() && is_possible)?;
            replicas.push(Replica {
                pixel,
                probability,
                samples,
                sum,
            });
        }
        Ok(Self(replicas))
    }
}

/// The relative standard error of each pixel of a tile with two or more samples, averaged with that of the pixels
/// around it: at an edge, a pixel may have missed the edge so far.
fn noise_near(film: &Film, tile: Tile, dark: f32) -> Vec<f32> {
    let noise = |(mean, squared): (f32, f32)| {
        let noise = squared.sqrt() / mean.abs().max(dark).max(f32::MIN_POSITIVE);
        if noise.is_finite() { noise } else { 0.0 }
    };
    let noises: Vec<f32> = film.mean_errors(tile).map(noise).collect();
    let place = |x: u32, y: u32| (y * tile.width + x) as usize;
    let near = |x: u32, y: u32| {
        let own_noise = noises[place(x, y)];
        let others = around(x, y, tile.width, tile.height).map(|(x, y)| noises[place(x, y)]);
        let (sum, count) = others.fold((own_noise, 1.0f32), |(sum, count), noise| (sum + noise, count + 1.0));
        0.5 * (own_noise + sum / count)
    };
    (0..tile.height)
        .flat_map(|y| (0..tile.width).map(move |x| (x, y)))
        .map(|(x, y)| near(x, y))
        .collect()
}

/// The correction from the ratio of measured to predicted errors and the effective number of replicas.
fn believed(ratio: f64, effective: f64) -> f32 {
    if !ratio.is_finite() {
        // No noise was predicted.
        return 1.0;
    }
    // If no replicas differ, their effective number is unknown.
    let effective = effective.max(1.0);
    ratio.max(LEAST_RATIO).powf(SPREAD / (SPREAD + effective.recip())) as f32
}

/// Renders the missing samples of some replicas; None if cancelled. With a shutter, samples see its moments.
pub fn render_replicas(
    scene: &RenderScene,
    view: &View,
    shutter: Option<&Shutter>,
    missing: &[Missing],
    cancel: &AtomicBool,
) -> Option<ReplicaSums> {
    let [seed, ..] = pcg3d([view.seed, SEEDS[1], SEEDS[0]]);
    let mut view = View { seed, ..view.clone() };
    // Layers take time; but with splats, some layers change which paths find light, and stay.
    if !view.integrator.splats() {
        (view.layers, view.light_groups) = (Layers::default(), LightGroups::default());
    }
    let shutter = shutter.map(|shutter| shutter.with_seed(seed));
    let mut rendered = ReplicaSums {
        sums: Vec::with_capacity(missing.len()),
        rays: 0,
    };
    for Missing { place, pixel, samples } in missing {
        let tile = Tile {
            x: pixel.x,
            y: pixel.y,
            width: 1,
            height: 1,
        };
        let mut sum = 0.0;
        for start in samples.clone().step_by(AT_ONCE) {
            let range = start..samples.end.min(start.saturating_add(AT_ONCE as u32));
            let result = match &shutter {
                Some(shutter) => shutter.render_tile(tile, range, cancel)?,
                None => render_tile(scene, &view, tile, range, cancel)?,
            };
            sum += f64::from(luminance(result.pixels[0].radiance));
            rendered.rays += result.rays;
        }
        rendered.sums.push((*place, samples.end, sum));
    }
    Some(rendered)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::render::tile::{PixelSum, TileSamples, tiles};

    const SIZE: [u32; 2] = [96, 64];

    /// A number in [0, 1) for a sample of a pixel.
    fn random(seed: u32, pixel: UVec2, sample: u32) -> f32 {
        let [bits, ..] = pcg3d([pixel.x + 1000 * pixel.y, sample, seed]);
        (bits >> 8) as f32 / (1 << 24) as f32
    }

    /// The luminance of a sample: 1, with noise in a band. There each render of a pixel also has an error that is the
    /// same in all its samples.
    fn sample(seed: u32, pixel: UVec2, sample: u32) -> f32 {
        let centered = |index: u32| random(seed, pixel, index) - 0.5;
        match pixel.x {
            32..64 => 1.0 + OFFSET * centered(u32::MAX) + SPREAD_OF_SAMPLES * centered(sample),
            _ => 1.0 + 1e-4 * centered(sample),
        }
    }

    /// The widths of both errors.
    const OFFSET: f32 = 0.1732;
    const SPREAD_OF_SAMPLES: f32 = 0.8;

    fn sums(tile: Tile, samples: Range<u32>, seed: u32) -> TileSamples {
        let pixel = |place: u32| {
            let pixel = UVec2::new(tile.x + place % tile.width, tile.y + place / tile.width);
            let mut sum = PixelSum::default();
            for luminance in samples.clone().map(|index| sample(seed, pixel, index)) {
                sum.radiance += Rgb::splat(luminance);
                sum.luminance_squared += luminance * luminance;
            }
            sum
        };
        let pixels = (0..tile.width * tile.height).map(pixel).collect();
        TileSamples::of_pixels(tile, samples.clone(), pixels)
    }

    /// A picture with `samples` samples, and the replicas chosen after 16 of them.
    fn picture(samples: u32, seed: u32) -> (Film, Replicas) {
        let all = tiles(SIZE[0], SIZE[1]);
        let mut film = Film::new(SIZE[0], SIZE[1]);
        let mut replicas = Replicas::default();
        let mut done = 0;
        while done < samples {
            let end = crate::render::passes::pass_end(done).min(samples);
            all.iter().for_each(|&tile| {
                film.add(&sums(tile, done..end, seed));
            });
            done = end;
            if done == 16 {
                replicas = Replicas::choose(&film, &all, seed);
            }
            let rendered = |missing: &Missing| {
                let samples = missing.samples.clone();
                let sum = samples
                    .map(|index| f64::from(sample(!seed, missing.pixel, index)))
                    .sum();
                (missing.place, missing.samples.end, sum)
            };
            let sums = replicas.missing(&film).iter().map(rendered).collect();
            replicas.add(&ReplicaSums { sums, rays: 0 });
        }
        (film, replicas)
    }

    #[test]
    fn replicas_find_errors_that_samples_do_not_tell() {
        const SAMPLES: u32 = 64;
        let all = tiles(SIZE[0], SIZE[1]);
        let squares = |seed| {
            let (film, replicas) = picture(SAMPLES, seed);
            assert!((200..=300).contains(&replicas.0.len()), "{}", replicas.0.len());
            assert!(replicas.are_whole(&film));
            let mut noise = PictureNoise::of(&film, &all);
            let squared = |noise: &PictureNoise| f64::from(noise.relative(0..all.len()).expect("samples")).powi(2);
            let foretold = squared(&noise);
            noise.correct(replicas.correction(&film, &noise));
            [foretold, squared(&noise)]
        };
        let of_seeds: Vec<[f64; 2]> = (1..=20).map(squares).collect();
        let mean = |place: usize| of_seeds.iter().map(|squares| squares[place]).sum::<f64>() / 20.0;
        // The variances of both errors, in a third of the pixels.
        let [offset, own] = [OFFSET, SPREAD_OF_SAMPLES].map(|width| f64::from(width).powi(2) / 12.0 / 3.0);
        let own = own / f64::from(SAMPLES);
        let [foretold, found] = [mean(0) / own, mean(1) / (own + offset)];
        assert!((foretold - 1.0).abs() < 0.05 && offset > 2.9 * own, "{foretold}");
        // Nine tenths of a factor of four are believed.
        assert!((0.85..1.03).contains(&found), "{found}");
    }

    #[test]
    fn few_replicas_are_believed_less() {
        assert!((believed(4.0, 1e9) - 4.0).abs() < 1e-4);
        assert!((believed(4.0, 5.0) - 2.0).abs() < 1e-4 && (believed(0.25, 5.0) - 0.5).abs() < 1e-4);
        // Where no noise was predicted, there is no correction.
        assert_eq!(
            [(f64::NAN, f64::NAN), (f64::INFINITY, 4.0)].map(|(a, b)| believed(a, b)),
            [1.0; 2]
        );
        assert!((believed(0.0, f64::NAN) - 0.1).abs() < 1e-4);
    }

    #[test]
    fn most_replicas_are_where_noise_is_and_some_everywhere() {
        let (_, replicas) = picture(16, 3);
        let is_noisy = |replica: &&Replica| (31..65).contains(&replica.pixel.x);
        let noisy = replicas.0.iter().filter(is_noisy).count();
        assert!(2 * noisy > replicas.0.len() && noisy < replicas.0.len(), "{noisy}");
    }

    #[test]
    fn most_pixels_of_small_pictures_have_replicas() {
        let mut film = Film::new(9, 5);
        for tile in tiles(9, 5) {
            film.add(&sums(tile, 0..1, 1));
            film.add(&sums(tile, 1..2, 1));
        }
        let replicas = Replicas::choose(&film, &tiles(9, 5), 1);
        // Fewer than half of the pixels would not be enough, and no probability is above 1.
        let is_likely = |replica: &Replica| (0.5..=1.0).contains(&replica.probability);
        assert!(
            replicas.0.len() > 45 / 2 && replicas.0.iter().all(is_likely),
            "{replicas:?}"
        );
    }

    #[test]
    fn what_is_written_is_read() {
        let (film, replicas) = picture(24, 5);
        let mut to = Writer::default();
        replicas.write(&mut to);
        let size = UVec2::from(SIZE);
        assert_eq!(Replicas::read(&mut Reader(&to.0), size), Ok(replicas.clone()));
        assert!(replicas.missing(&film).is_empty());
        assert_eq!(Replicas::read(&mut Reader(&to.0), size / 2), Err(Damaged));
        assert_eq!(Replicas::read(&mut Reader(&to.0[..100]), size), Err(Damaged));
    }
}
