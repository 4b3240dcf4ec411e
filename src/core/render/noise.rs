//! Estimates the noise of a whole picture as one number, at which rendering may stop.
//!
//! Errors are relative to the *likely* luminance of a pixel. Its own mean alone would hide rare bright samples, which
//! raise the mean that their error is relative to: one sample of ten times the true luminance in sixteen pixels would
//! count for a third of its error. So the mean is drawn towards that of the pixels around it, by the share of its
//! squared error in the sum of that and the squared local contrast (empirical Bayes: Efron and Morris, Stein's
//! estimation rule and its competitors, Journal of the American Statistical Association 68, 1973). Without noise, and
//! at edges, it is unchanged.

pub mod adaptive;
pub mod blocks;
pub(super) mod mean_error;
pub mod replicas;

use rayon::prelude::*;

use super::film::Film;
use super::tile::Tile;

/// Pixels darker than this share of the picture's mean are judged as if they had that luminance, because noise is
/// invisible in almost black areas.
pub const DARK: f32 = 0.1;

/// The likely luminance of a pixel, from its own mean and the estimated square of its standard error, and from those of
/// the pixels `around` it.
pub(super) fn likely_luminance((own, squared_error): (f32, f32), around: impl Iterator<Item = (f32, f32)>) -> f32 {
    let (mut count, mut sum, mut squares, mut errors) = (0.0, 0.0, 0.0, 0.0);
    for (mean, squared_error) in around {
        // Relative to the pixel's own mean, to lose few digits where all means are nearly equal.
        let beside = mean - own;
        count += 1.0;
        sum += beside;
        squares += beside * beside;
        errors += squared_error;
    }
    if count < 2.0 {
        return own;
    }
    let towards = sum / count;
    // The squared contrast of the means around beyond their errors, or of this one beyond three of its own.
    let contrast = ((squares - sum * towards) / (count - 1.0) - errors / count)
        .max(towards * towards - 9.0 * squared_error)
        .max(0.0);
    let drawn = towards * squared_error / (contrast + squared_error);
    if drawn.is_finite() { own + drawn } else { own }
}

/// The positions of the pixels around (x, y) in a tile of this size.
pub(super) fn around(x: u32, y: u32, width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let near = |at: u32, size: u32| at.saturating_sub(1)..=(at + 1).min(size - 1);
    near(y, height)
        .flat_map(move |row| near(x, width).map(move |column| (column, row)))
        .filter(move |&place| place != (x, y))
}

/// The noise of a picture, updated tile by tile as samples arrive, because reading all pixels again would take longer
/// than a frame.
#[derive(Clone, Debug)]
pub struct PictureNoise {
    tiles: Vec<TileNoise>,
    whole: TileNoise,
    correction: f32,
}

/// Sums over the pixels with two or more samples.
#[derive(Clone, Copy, Debug, Default)]
struct TileNoise {
    pixels: u64,
    /// The sum of the luminances' magnitudes.
    light: f64,
    /// The sum of the squared standard errors relative to the luminance.
    squares: f64,
    /// The part of `squares` from splats.
    by_splats: f64,
}

/// The pixels of a tile, and the part of its noise that does not depend on the threshold for dark pixels.
struct LitTile {
    tile: Tile,
    /// The mean luminances and their squared errors.
    pixels: Vec<(f32, f32)>,
    noise: TileNoise,
}

impl LitTile {
    fn of(film: &Film, tile: Tile) -> Self {
        let pixels: Vec<(f32, f32)> = film.mean_errors(tile).collect();
        let noise = TileNoise {
            pixels: pixels.len() as u64,
            light: pixels.iter().map(|(mean, _)| f64::from(mean.abs())).sum(),
            ..TileNoise::default()
        };
        Self { tile, pixels, noise }
    }

    /// The complete noise, if pixels below the luminance `dark` count as dark.
    fn measured(&self, film: &Film, dark: f32) -> TileNoise {
        let (tile, pixels) = (self.tile, &self.pixels);
        let is_whole = pixels.len() == (tile.width * tile.height) as usize;
        let scale = |place: usize| {
            let own = pixels[place];
            let (x, y) = (place as u32 % tile.width, place as u32 / tile.width);
            let around = around(x, y, tile.width, tile.height).map(|(x, y)| pixels[(y * tile.width + x) as usize]);
            let likely = if is_whole { likely_luminance(own, around) } else { own.0 };
            likely.abs().max(dark)
        };
        let scales: Vec<f32> = (0..pixels.len()).map(scale).collect();
        let relative = |(squared_error, scale): (f32, &f32)| f64::from(squared_error / scale.powi(2));
        let by_splats = match film.has_splats() {
            true => film.splat_variances(tile).zip(&scales).map(relative).sum(),
            false => 0.0,
        };
        TileNoise {
            squares: pixels.iter().map(|pixel| pixel.1).zip(&scales).map(relative).sum(),
            by_splats,
            ..self.noise
        }
    }
}

impl PictureNoise {
    /// The noise of a picture of this many tiles without samples.
    pub fn new(tiles: usize) -> Self {
        Self {
            tiles: vec![TileNoise::default(); tiles],
            whole: TileNoise::default(),
            correction: 1.0,
        }
    }

    /// The noise of these tiles of a film: the same bits in whatever order their samples came.
    pub fn of(film: &Film, tiles: &[Tile]) -> Self {
        let mut noise = Self::new(tiles.len());
        let lit: Vec<LitTile> = tiles.par_iter().map(|&tile| LitTile::of(film, tile)).collect();
        lit.iter()
            .enumerate()
            .for_each(|(index, tile)| noise.replace(index, tile.noise));
        // The threshold for dark pixels is known only after a first pass over all tiles.
        if noise.whole.light > 0.0 {
            let dark = noise.dark();
            let measured = lit.par_iter().map(|tile| tile.measured(film, dark));
            noise.tiles = measured.collect();
        }
        noise
    }

    /// Sets the ratio of the true squared errors to those estimated from the pixels' own samples, see
    /// [`crate::render::noise::replicas`]; 1 initially.
    pub fn correct(&mut self, correction: f32) {
        self.correction = correction;
    }

    /// The ratio set by [`Self::correct`].
    pub fn correction(&self) -> f32 {
        self.correction
    }

    /// The luminance below which pixels are judged as if they had it.
    pub(super) fn dark(&self) -> f32 {
        match self.whole.pixels {
            0 => 0.0,
            pixels => DARK * (self.whole.light / pixels as f64) as f32,
        }
    }

    /// The sum over all pixels of the squared standard errors relative to the luminance, as estimated from their own
    /// samples.
    pub(super) fn own_squares(&self) -> f64 {
        self.tiles.iter().map(|tile| tile.squares - tile.by_splats).sum()
    }

    /// Updates the noise from the film's current data of a tile, the one at `index` among the picture's. The current
    /// picture decides which pixels are dark.
    pub fn update(&mut self, index: usize, film: &Film, tile: Tile) {
        let lit = LitTile::of(film, tile);
        self.replace(index, lit.noise);
        if self.whole.light > 0.0 {
            self.tiles[index] = lit.measured(film, self.dark());
        }
    }

    fn replace(&mut self, index: usize, new: TileNoise) {
        let old = std::mem::replace(&mut self.tiles[index], new);
        self.whole.pixels += new.pixels - old.pixels;
        self.whole.light += new.light - old.light;
    }

    /// The root mean square over the pixels of the estimated standard error of a pixel's luminance relative to that
    /// luminance; 0.01 is noise of one in a hundred. It does not depend on the exposure or the unit of light, and
    /// falls with the root of the samples.
    ///
    /// The mean is over the pixels of the tiles at `indices` with two or more samples; None if there are none, or all
    /// are black.
    pub fn relative(&self, indices: impl IntoIterator<Item = usize>) -> Option<f32> {
        let (mut pixels, mut light, mut squares, mut own) = (0.0, 0.0, 0.0, 0.0);
        for tile in indices.into_iter().map(|index| &self.tiles[index]) {
            pixels += tile.pixels as f64;
            light += tile.light;
            squares += tile.squares;
            own += tile.squares - tile.by_splats;
        }
        squares += f64::from(self.correction - 1.0) * own;
        (light > 0.0).then(|| (squares / pixels).sqrt() as f32)
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::*;
    use crate::color::{Rgb, luminance};
    use crate::render::tile::{PixelSum, TileSamples, tiles};
    use crate::sampling::hash::pcg3d;

    /// A sample of every pixel, with a luminance of `mean` (1 +- `spread`), uniformly distributed.
    fn noisy(tile: Tile, sample: u32, mean: f32, spread: f32) -> TileSamples {
        let pixel = |place: u32| {
            let [bits, ..] = pcg3d([tile.x + 100 * tile.y, place, sample]);
            let radiance = Rgb::splat(mean * (1.0 + spread * (bits as f32 / 2f32.powi(31) - 1.0)));
            PixelSum {
                radiance,
                luminance_squared: luminance(radiance).powi(2),
                ..PixelSum::default()
            }
        };
        let pixels = (0..tile.width * tile.height).map(pixel).collect();
        TileSamples::of_pixels(tile, sample..sample + 1, pixels)
    }

    fn film(samples: Range<u32>, mean: f32, spread: f32) -> Film {
        let mut film = Film::new(64, 40);
        for tile in tiles(64, 40) {
            for sample in samples.clone() {
                film.add(&noisy(tile, sample, mean, spread));
            }
        }
        film
    }

    fn measured(film: &Film) -> PictureNoise {
        let all = tiles(64, 40);
        let mut noise = PictureNoise::new(all.len());
        all.iter()
            .zip(0..)
            .for_each(|(&tile, index)| noise.update(index, film, tile));
        noise
    }

    #[test]
    fn a_rare_bright_sample_is_not_the_light_that_its_error_is_relative_to() {
        let dark: Vec<(f32, f32)> = (0..8).map(|pixel| (1.0 + 0.01 * (pixel % 3) as f32, 1e-4)).collect();
        let likely = |own| likely_luminance(own, dark.iter().copied());
        // A rare bright sample: one of 160 in sixteen.
        let bright = likely((10.0, 100.0));
        assert!((bright - 1.01).abs() < 0.01, "{bright}");
        // A lamp, which has little noise.
        let lamp = likely((10.0, 1e-4));
        assert!((lamp - 10.0).abs() < 0.01, "{lamp}");
        // Without noise, and where all are alike, the mean is unchanged.
        assert_eq!(likely((10.0, 0.0)), 10.0);
        assert_eq!(likely_luminance((2.0, 0.0), [(2.0, 0.0); 8].into_iter()), 2.0);
        assert_eq!(likely_luminance((2.0, 1.0), [(1.0, 0.0)].into_iter()), 2.0);
        // At the edge between a dark and a bright half both are unchanged.
        let edge = [1.0, 1.0, 1.0, 10.0, 10.0, 10.0, 1.0, 10.0].map(|mean| (mean, 0.01));
        let beside_edge = likely_luminance((10.0, 0.1), edge.into_iter());
        assert!((beside_edge - 10.0).abs() < 0.1, "{beside_edge}");
    }

    #[test]
    fn pixels_around_another_are_within_the_tile() {
        let around = |x, y| around(x, y, 4, 3).collect::<Vec<_>>();
        assert_eq!(around(0, 0), [(1, 0), (0, 1), (1, 1)]);
        assert_eq!(around(3, 1), [(2, 0), (3, 0), (2, 1), (2, 2), (3, 2)]);
        assert_eq!(around(1, 1).len(), 8);
    }

    #[test]
    fn noise_is_the_spread_over_the_root_of_the_samples() {
        let all = tiles(64, 40);
        for (count, mean, spread) in [(16, 1.0, 0.5), (64, 1.0, 0.5), (64, 1e-3, 0.5), (64, 5.0, 0.1)] {
            let noise = measured(&film(0..count, mean, spread))
                .relative(0..all.len())
                .expect("samples");
            // The deviation of a uniform distribution is spread / sqrt 3. Pixels are divided by means that have an
            // error of their own, which over 2560 pixels amounts to a few percent.
            let expected = spread / (3.0 * count as f32).sqrt();
            assert!((noise / expected - 1.0).abs() < 0.05, "{noise} {expected}");
        }
    }

    #[test]
    fn only_what_is_asked_for_and_measured_counts() {
        let all = tiles(64, 40);
        let relative = |film: &Film, tiles: Range<usize>| measured(film).relative(tiles);
        assert_eq!(relative(&film(0..1, 1.0, 0.5), 0..4), None);
        assert_eq!(relative(&film(0..4, 0.0, 0.5), 0..4), None);
        assert_eq!(relative(&film(0..4, 1.0, 0.5), 0..0), None);
        let mut film = film(0..4, 1.0, 0.0);
        let mut noise = measured(&film);
        let quiet = noise.relative(0..all.len()).expect("samples");
        film.add(&TileSamples {
            tile: all[0],
            samples: 4..5,
            pixels: vec![
                PixelSum {
                    radiance: Rgb::splat(9.0),
                    luminance_squared: 81.0,
                    ..PixelSum::default()
                };
                (all[0].width * all[0].height) as usize
            ],
            blocks: None,
            layers: Default::default(),
            first_hits: Vec::new(),
            splats: Default::default(),
            rays: 0,
            invalid: 0,
        });
        noise.update(0, &film, all[0]);
        assert!(noise.relative(0..all.len()).expect("samples") > quiet + 0.1);
        // The tile with other samples is excluded.
        assert_eq!(noise.relative(1..all.len()), Some(quiet));
    }

    #[test]
    fn tile_by_tile_it_is_what_all_pixels_together_have() {
        let all = tiles(64, 40);
        let mut film = Film::new(64, 40);
        let mut noise = PictureNoise::new(all.len());
        // Tiles far darker than the mean, below what counts as dark, and brighter ones, in two passes.
        for (samples, (index, &tile)) in [0..4, 4..16]
            .into_iter()
            .flat_map(|range| all.iter().enumerate().map(move |tile| (range.clone(), tile)))
        {
            let light = [1.0, 0.01, 5.0, 0.2][index];
            for sample in samples {
                film.add(&noisy(tile, sample, light, 0.5));
            }
            noise.update(index, &film, tile);
        }
        let pixels: Vec<(f32, f32)> = (0..40)
            .flat_map(|y| (0..64).map(move |x| (x, y)))
            .map(|(x, y)| {
                let mean = luminance(film.pixel(x, y).expect("samples").radiance);
                (mean, film.standard_error(x, y).expect("samples"))
            })
            .collect();
        let mean = pixels.iter().map(|(mean, _)| mean).sum::<f32>() / pixels.len() as f32;
        let squares = pixels.iter().map(|(own, error)| (error / own.max(DARK * mean)).powi(2));
        let expected = (squares.sum::<f32>() / pixels.len() as f32).sqrt();
        let noise = noise.relative(0..all.len()).expect("samples");
        // The mean of the first pass differs from that of the last by its error, 0.3 / sqrt(4 * 2560) of it.
        assert!((noise / expected - 1.0).abs() < 0.01, "{noise} {expected}");
    }
}
