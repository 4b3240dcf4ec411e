//! How noisy a picture is: one number for all of it, to stop at.

use super::film::Film;
use super::tile::Tile;
use crate::color::luminance;

/// Pixels darker than this share of the picture's mean are judged as if they had that much: of what is all but black nobody sees the
/// noise.
pub const DARK: f32 = 0.1;

/// The root mean square over the pixels of the estimated standard error of a pixel's luminance relative to that luminance; 0.01 is
/// noise of one in a hundred. It does not depend on the exposure or the unit of light, and falls with the root of the samples.
///
/// Over the pixels of `tiles` that have two samples or more; None if there are none, or where all is black.
pub fn relative_noise(film: &Film, tiles: &[Tile]) -> Option<f32> {
    let of_tile = |tile: &Tile| {
        let (x, y) = (tile.x..tile.x + tile.width, tile.y..tile.y + tile.height);
        y.flat_map(move |y| x.clone().map(move |x| (x, y)))
    };
    let of_pixel = |(x, y)| {
        let error = film.standard_error(x, y)?;
        let mean = luminance(film.pixel(x, y)?.radiance);
        Some((f64::from(error), f64::from(mean).abs()))
    };
    let pixels: Vec<(f64, f64)> = tiles.iter().flat_map(of_tile).filter_map(of_pixel).collect();
    let (count, total) = (pixels.len() as f64, pixels.iter().map(|(_, mean)| mean).sum::<f64>());
    if total <= 0.0 {
        return None;
    }
    let least = f64::from(DARK) * total / count;
    let relative = |(error, mean): &(f64, f64)| (error / mean.max(least)).powi(2);
    let squares: f64 = pixels.iter().map(relative).sum();
    Some((squares / count).sqrt() as f32)
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::*;
    use crate::color::Rgb;
    use crate::render::tile::{PixelSum, TileSamples, tiles};
    use crate::sampling::hash::pcg3d;

    /// Samples of luminance `mean` (1 +- `spread`), evenly distributed.
    fn film(samples: Range<u32>, mean: f32, spread: f32) -> Film {
        let mut film = Film::new(64, 40);
        for tile in tiles(64, 40) {
            for sample in samples.clone() {
                let pixel = |place: u32| {
                    let [bits, ..] = pcg3d([tile.x + 100 * tile.y, place, sample]);
                    let value = mean * (1.0 + spread * (bits as f32 / 2f32.powi(31) - 1.0));
                    let radiance = Rgb::splat(value);
                    PixelSum {
                        radiance,
                        luminance_squared: luminance(radiance).powi(2),
                        ..PixelSum::default()
                    }
                };
                film.add(&TileSamples {
                    tile,
                    samples: sample..sample + 1,
                    pixels: (0..tile.width * tile.height).map(pixel).collect(),
                    layers: Vec::new(),
                    first_hits: Vec::new(),
                    rays: 0,
                    invalid: 0,
                });
            }
        }
        film
    }

    #[test]
    fn noise_is_the_spread_over_the_root_of_the_samples() {
        let all = tiles(64, 40);
        for (count, mean, spread) in [(16, 1.0, 0.5), (64, 1.0, 0.5), (64, 1e-3, 0.5), (64, 5.0, 0.1)] {
            let noise = relative_noise(&film(0..count, mean, spread), &all).expect("samples");
            // Of an even distribution the deviation is spread / sqrt 3; pixels are divided by means that are off by their own error,
            // which over 2560 pixels leaves a few percent.
            let expected = spread / (3.0 * count as f32).sqrt();
            assert!((noise / expected - 1.0).abs() < 0.05, "{noise} {expected}");
        }
    }

    #[test]
    fn only_what_is_asked_for_and_measured_counts() {
        let all = tiles(64, 40);
        assert_eq!(relative_noise(&film(0..1, 1.0, 0.5), &all), None);
        assert_eq!(relative_noise(&film(0..4, 0.0, 0.5), &all), None);
        assert_eq!(relative_noise(&film(0..4, 1.0, 0.5), &[]), None);
        let mut film = film(0..4, 1.0, 0.0);
        let quiet = relative_noise(&film, &all).expect("samples");
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
            layers: Vec::new(),
            first_hits: Vec::new(),
            rays: 0,
            invalid: 0,
        });
        assert!(relative_noise(&film, &all).expect("samples") > quiet + 0.1);
        // The tile that got something else is not asked for.
        assert_eq!(relative_noise(&film, &all[1..]), Some(quiet));
    }
}
