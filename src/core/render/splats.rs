//! Splats: light that the samples of one tile add to pixels of others, as light paths do (PBR 4th ed., section 5.4;
//! Veach 1997, section 10.3).
//!
//! Tiles finish in any order, and a sum of floating-point numbers depends on its order. Sums of splats are therefore
//! fixed-point numbers, which do not: they have the same bits for any number of threads, and for a picture that is
//! merged from shares.

use bytemuck::{Pod, Zeroable};
use glam::UVec2;

use crate::color::{Rgb, luminance};

/// Light for a pixel that need not be the sample's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// The pixel; a splat outside of the picture is ignored.
    pub pixel: UVec2,
    /// Linear Rec. 709, W/(m^2 sr), with the weight of one of the pixel's own samples.
    pub radiance: Rgb,
}

/// The splats of a tile's light paths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileSplats {
    /// The splats, in the order in which they were found.
    pub list: Vec<Splat>,
    /// The number of light paths that were traced, those without splats included; 0 if the method traces none.
    pub paths: u64,
}

impl TileSplats {
    /// Appends other splats.
    pub fn append(&mut self, mut other: Self) {
        self.list.append(&mut other.list);
        self.paths += other.paths;
    }
}

/// The splats of a film. Without any this takes no memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Splats {
    /// Sums by index in the film; empty before the first splat.
    pub sums: Vec<SplatSum>,
    /// The number of light paths that the sums are over.
    pub paths: u64,
}

/// The sum of the splats of a pixel, in units of 2^-64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SplatSum {
    pub radiance: [i128; 3],
    /// The sum of squared luminances.
    pub luminance_squared: i128,
}

/// The unit of the sums. They range up to 2^63, which no sum of light reaches, in steps of 2^-64.
const ONE: f64 = (1u128 << 64) as f64;

impl SplatSum {
    fn add(&mut self, radiance: Rgb) {
        for (sum, value) in self.radiance.iter_mut().zip(radiance.to_array()) {
            *sum = sum.saturating_add(fixed(value));
        }
        let square = luminance(radiance).powi(2);
        self.luminance_squared = self.luminance_squared.saturating_add(fixed(square));
    }

    /// Adds the sum of other splats.
    pub fn append(&mut self, other: &Self) {
        for (sum, value) in self.radiance.iter_mut().zip(other.radiance) {
            *sum = sum.saturating_add(value);
        }
        self.luminance_squared = self.luminance_squared.saturating_add(other.luminance_squared);
    }
}

/// Converts to fixed point, clamped to the largest number.
fn fixed(value: f32) -> i128 {
    (f64::from(value) * ONE) as i128
}

impl Splats {
    /// Adds light at the index `place` of a film with `places` pixels.
    pub fn add(&mut self, place: usize, radiance: Rgb, places: usize) {
        self.sums.resize(places, SplatSum::default());
        self.sums[place].add(radiance);
    }

    /// The mean light at the index `place` of a film of `pixels` pixels, which has `paths / pixels` paths per pixel.
    pub fn mean(&self, place: usize, pixels: u64) -> Rgb {
        let Some(sum) = self.sums.get(place) else {
            return Rgb::ZERO;
        };
        let scale = pixels as f64 / self.paths.max(1) as f64 / ONE;
        let [r, g, b] = sum.radiance.map(|sum| (sum as f64 * scale) as f32);
        Rgb::new(r, g, b)
    }

    /// The estimated variance of the luminance of [`Self::mean`]: few of very many paths reach a pixel, so that it is
    /// the sum of the squares.
    pub fn variance(&self, place: usize, pixels: u64) -> f32 {
        let scale = pixels as f64 / self.paths.max(1) as f64;
        let squares = self
            .sums
            .get(place)
            .map_or(0.0, |sum| sum.luminance_squared as f64 / ONE);
        (squares * scale * scale) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::film::Film;
    use crate::render::tile::{PixelSum, Tile, TileSamples, tiles};
    use crate::sampling::hash::pcg3d;
    use std::ops::Range;

    const SIZE: u32 = 70;

    fn samples(tile: Tile, samples: Range<u32>, list: Vec<Splat>) -> TileSamples {
        let sum = PixelSum {
            radiance: Rgb::splat(0.25 * samples.len() as f32),
            ..PixelSum::default()
        };
        TileSamples {
            tile,
            pixels: vec![sum; (tile.width * tile.height) as usize],
            blocks: None,
            layers: Default::default(),
            first_hits: Vec::new(),
            splats: TileSplats {
                list,
                paths: u64::from(tile.width * tile.height) * (samples.end - samples.start) as u64,
            },
            samples,
            rays: 0,
            invalid: 0,
        }
    }

    #[test]
    fn splats_land_in_their_pixels() {
        let (inside, corner) = (UVec2::new(40, 3), UVec2::splat(SIZE - 1));
        let splat = |pixel, light| Splat {
            pixel,
            radiance: Rgb::splat(light),
        };
        let mut film = Film::new(SIZE, SIZE);
        for (index, tile) in tiles(SIZE, SIZE).into_iter().enumerate() {
            let splats = match index {
                0 => vec![
                    splat(inside, 3.0),
                    splat(UVec2::new(SIZE, 0), 7.0),
                    splat(UVec2::new(0, SIZE), 7.0),
                ],
                5 => vec![splat(inside, 1.0), splat(corner, 2.0)],
                _ => Vec::new(),
            };
            film.add(&samples(tile, 0..2, splats));
        }
        assert!(film.has_splats());
        for (x, y) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y))) {
            let expected = match UVec2::new(x, y) {
                pixel if pixel == inside => 2.25,
                pixel if pixel == corner => 1.25,
                _ => 0.25,
            };
            let pixel = film.pixel(x, y).expect("it has samples");
            assert_eq!(pixel.radiance, Rgb::splat(expected), "{x} {y}");
            assert_eq!(film.mixed_pixel(x, y, &[]), Some(pixel.radiance));
        }
        film.begin(SIZE, SIZE, Default::default());
        tiles(SIZE, SIZE).into_iter().for_each(|tile| {
            film.add(&samples(tile, 0..1, Vec::new()));
        });
        assert!(film.radiance().iter().all(|&radiance| radiance == Rgb::splat(0.25)));
    }

    /// Light from a tile's samples for three pixels that all tiles share.
    fn splats(tile: usize, first: u32) -> Vec<Splat> {
        let splat = |number| {
            let [bits, ..] = pcg3d([tile as u32, first, number]);
            Splat {
                pixel: UVec2::splat(20 * (number % 3)),
                radiance: Rgb::splat(bits as f32 / 1e7),
            }
        };
        (0..50).map(splat).collect()
    }

    /// The film, and the sums of splats as they arrived, once `workers` have finished all passes: each takes the next
    /// tile of a pass, and any of them may be the next to finish its own.
    fn rendered(workers: u32) -> (Film, [Rgb; 3]) {
        let tiles = tiles(SIZE, SIZE);
        let passes = [0..1, 1..2, 2..4];
        let mut items = passes
            .iter()
            .flat_map(|range| (0..tiles.len()).map(move |tile| (tile, range.clone())));
        let mut at_work: Vec<(usize, Range<u32>)> = items.by_ref().take(workers as usize).collect();
        let (mut film, mut done, mut arrived) = (Film::new(SIZE, SIZE), vec![0; tiles.len()], [Rgb::ZERO; 3]);
        for step in 0.. {
            let ready: Vec<usize> = (0..at_work.len())
                .filter(|&place| done[at_work[place].0] == at_work[place].1.start)
                .collect();
            let [random, ..] = pcg3d([workers, step, 0]);
            let Some(&next) = ready.get(random as usize % ready.len().max(1)) else {
                break;
            };
            let (tile, range) = at_work.swap_remove(next);
            at_work.extend(items.next());
            done[tile] = range.end;
            let splats = splats(tile, range.start);
            splats
                .iter()
                .for_each(|splat| arrived[splat.pixel.x as usize / 20] += splat.radiance);
            film.add(&samples(tiles[tile], range, splats));
        }
        assert!(done.iter().all(|&samples| samples == 4));
        (film, arrived)
    }

    #[test]
    fn any_number_of_workers_gives_the_same_bits() {
        let (alone, in_order) = rendered(1);
        for workers in [2, 3, 8, 20] {
            let (film, arrived) = rendered(workers);
            assert!(arrived != in_order, "{workers}: in another order the bits would differ");
            assert!(film.radiance() == alone.radiance(), "{workers}");
        }
    }
}
