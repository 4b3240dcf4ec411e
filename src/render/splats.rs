//! Light that the samples of one tile bring to pixels of others, as paths from the lights do (PBR 4th ed., section 5.4; Veach 1997,
//! section 10.3).
//!
//! Tiles are done in any order, and a sum of floating-point numbers depends on its order. So splats wait until all tiles have the samples
//! that they come from, and are then added in the order of samples and tiles.

use std::collections::BTreeMap;

use glam::UVec2;

use crate::color::Rgb;

/// Light for a pixel that need not be the sample's own. It counts as one of the pixel's own samples does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// Beside the picture it is left out.
    pub pixel: UVec2,
    /// Linear Rec. 709, W/(m^2 sr).
    pub radiance: Rgb,
}

/// The splats of a film. Without any this takes no memory, and [`Film::memory_bytes`](super::film::Film::memory_bytes) does not count it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Splats {
    /// The splats that are not yet added, by the end of the range of samples and the tile that they come from.
    waiting: BTreeMap<(u32, usize), Vec<Splat>>,
    /// Sums by place in the film; empty until there is a splat.
    sums: Vec<Rgb>,
    /// Samples per pixel whose splats are in the sums.
    pub samples: u32,
}

impl Splats {
    /// Keeps what a range of samples that ends before `end` has brought from the picture's tile number `tile`.
    pub fn keep(&mut self, end: u32, tile: usize, splats: &[Splat]) {
        if !splats.is_empty() {
            self.waiting.insert((end, tile), splats.to_vec());
        }
    }

    /// Takes the splats that are next in order among those whose samples are all below `samples`.
    pub fn next_below(&mut self, samples: u32) -> Option<Vec<Splat>> {
        let next = self.waiting.first_entry()?;
        (next.key().0 <= samples).then(|| next.remove())
    }

    /// Adds light at a place of a film that has so many `places`.
    pub fn add(&mut self, place: usize, radiance: Rgb, places: usize) {
        self.sums.resize(places, Rgb::ZERO);
        self.sums[place] += radiance;
    }

    /// The mean over samples at a place in the film.
    pub fn mean(&self, place: usize) -> Rgb {
        let sum = self.sums.get(place);
        sum.map_or(Rgb::ZERO, |&sum| sum / self.samples as f32)
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

    fn samples(tile: Tile, samples: Range<u32>, splats: Vec<Splat>) -> TileSamples {
        let sum = PixelSum {
            radiance: Rgb::splat(0.25 * samples.len() as f32),
            ..PixelSum::default()
        };
        TileSamples {
            tile,
            samples,
            pixels: vec![sum; (tile.width * tile.height) as usize],
            blocks: None,
            layers: Default::default(),
            first_hits: Vec::new(),
            splats,
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
        assert!(film.radiance().iter().all(|&radiance| radiance == Rgb::splat(0.25)));
        assert!(!film.settle_splats(1), "some of these samples are not below 1");
        assert!(film.settle_splats(2) && !film.settle_splats(2));
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

    /// The film, and the sums of splats as they arrived, once `workers` have done all passes: each takes the next tile of a pass, and any of
    /// them may be the next to have done its own.
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
            film.settle_splats(done.iter().copied().min().unwrap_or(0));
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
