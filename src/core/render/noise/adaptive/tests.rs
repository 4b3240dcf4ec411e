use super::*;
use crate::color::Rgb;
use crate::render::tile::{PixelSum, TileSamples, tiles};
use crate::sampling::{COLOUR, place_in_block};

const WIDTH: u32 = 96;
const HEIGHT: u32 = 70;

/// A map after [`FIRST`] samples of a picture, and the tiles of the picture. A pixel at (x, y) has the luminance `[l,
/// _]` of `light`, with halves that differ by the share `[_, d]`.
fn sampled_in([width, height]: [u32; 2], light: impl Fn(u32, u32) -> [f32; 2]) -> (NoiseMap, Vec<Tile>) {
    let all = tiles(width, height);
    let (mut map, mut film) = (NoiseMap::new(&all, width), Film::new(width, height));
    for (index, &tile) in all.iter().enumerate() {
        let ranges = [0..1, 1..2, 2..4, 4..8, 8..16];
        for samples in ranges {
            let sign = if samples.start < 8 { -1.0 } else { 1.0 };
            let pixel = |x: u32, y: u32| {
                let [luminance, noise] = light(x, y);
                let light = luminance * (1.0 + sign * noise);
                let count = samples.len() as f32;
                PixelSum {
                    radiance: Rgb::splat(light * count),
                    luminance_squared: light * light * count,
                    rays: 3.0 * count,
                    ..PixelSum::default()
                }
            };
            let rows = tile.y..tile.y + tile.height;
            let pixels = rows.flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| (x, y)));
            let pixels = pixels.map(|(x, y)| pixel(x, y)).collect();
            film.add(&TileSamples::of_pixels(tile, samples.clone(), pixels));
        }
        map.begin(index, &film);
    }
    (map, all)
}

fn sampled(noise: impl Fn(u32, u32) -> f32) -> (NoiseMap, Vec<Tile>) {
    sampled_in([WIDTH, HEIGHT], |x, y| [1.0, noise(x, y)])
}

fn allocated(map: &NoiseMap, tiles: &[Tile]) -> Option<Vec<PerBlock<u32>>> {
    let active: Vec<usize> = (0..tiles.len()).collect();
    map.allocate(&active, &vec![[FIRST; _]; tiles.len()], FIRST, 2 * FIRST)
}

#[test]
fn samples_go_where_the_noise_is_and_cost_as_much() {
    let is_noisy = |x: u32, y: u32| (x / 16 + y / 16).is_multiple_of(4);
    let (map, tiles) = sampled(|x, y| if is_noisy(x, y) { 0.5 } else { 0.02 });
    let ends = allocated(&map, &tiles).expect("a gain");
    let (mut all, mut pixels, mut noisy) = (0, 0, Vec::new());
    for (tile, ends) in tiles.iter().zip(&ends) {
        for (place, block) in blocks_of(*tile) {
            let area = block.width * block.height;
            (all, pixels) = (all + area * ends[place], pixels + area);
            if is_noisy(block.x, block.y) {
                noisy.push(ends[place]);
            }
        }
    }
    let mean = f64::from(all) / f64::from(pixels);
    assert!((0.85..1.01).contains(&(mean / f64::from(2 * FIRST))), "{mean}");
    let of_noisy = noisy.iter().sum::<u32>() as f64 / noisy.len() as f64;
    assert!(
        of_noisy > 1.8 * mean && noisy.iter().all(|&end| end >= FIRST),
        "{of_noisy}"
    );
}

#[test]
fn even_noise_is_sampled_evenly() {
    let (map, tiles) = sampled(|_, _| 0.3);
    assert_eq!(allocated(&map, &tiles), None);
    let (map, tiles) = sampled(|_, _| 0.0);
    assert_eq!(allocated(&map, &tiles), None);
    // Noise that the surrounding blocks do not predict.
    let random = |x: u32, y: u32| crate::sampling::hash::pcg3d([x / BLOCK, y / BLOCK, 7])[0].is_multiple_of(8);
    let (map, tiles) = sampled(|x, y| if random(x, y) { 0.5 } else { 0.02 });
    assert_eq!(allocated(&map, &tiles), None);
}

#[test]
fn a_block_has_no_say_in_its_own_samples() {
    // The light has dark parts, in which noise counts less.
    let light = |x: u32, y: u32| {
        let luminance = if x % 50 < 20 { 0.01 } else { 1.0 };
        [luminance, if x < 40 { 0.3 } else { 0.02 + 0.001 * y as f32 }]
    };
    let (map, tiles) = sampled_in([WIDTH, HEIGHT], light);
    let usual = allocated(&map, &tiles).expect("a gain");
    // Blocks of the colour of (50, 32), in tiles of the same kind, have other statistics.
    let board = map.board(&Vec::from_iter(0..tiles.len()), FIRST).expect("all is known");
    let is_same = |x: u32, y: u32| {
        let [a, b] = [(50, 32), (x, y)].map(|(x, y)| (y / BLOCK) as usize * board.columns + (x / BLOCK) as usize);
        board.group_of(a) == board.group_of(b)
    };
    let (map, _) = sampled_in(
        [WIDTH, HEIGHT],
        |x, y| if is_same(x, y) { [30.0, 0.9] } else { light(x, y) },
    );
    let other = allocated(&map, &tiles).expect("a gain");
    let (mut same, mut differ) = (0, false);
    for ((tile, usual), other) in tiles.iter().zip(&usual).zip(&other) {
        for (place, block) in blocks_of(*tile) {
            if is_same(block.x, block.y) {
                assert_eq!(usual[place], other[place], "{block:?}");
                same += 1;
            } else {
                differ |= usual[place] != other[place];
            }
        }
    }
    assert!(same > 300 && differ);
}

#[test]
fn blocks_of_groups_without_a_gain_get_as_many_more() {
    // Only the tiles of one kind have something to gain, which decides for the tiles of the other.
    let noise = |x: u32, y: u32| match ((x / TILE + y / TILE) % 2, x / 8 % 2) {
        (0, 0) => 0.5,
        _ => 0.02,
    };
    let (map, tiles) = sampled(noise);
    let active: Vec<usize> = (0..tiles.len()).collect();
    for to in [95, 100, 300] {
        let counts = vec![[64; _]; tiles.len()];
        let ends = map.allocate(&active, &counts, 64, to).expect("a gain");
        for (tile, ends) in tiles
            .iter()
            .zip(ends)
            .filter(|(tile, _)| (tile.x / TILE + tile.y / TILE).is_multiple_of(2))
        {
            blocks_of(*tile).for_each(|(place, _)| assert_eq!(ends[place], to));
        }
    }
}

#[test]
fn pictures_of_any_size_are_shared_out() {
    for size in [[1, 1], [1, 90], [90, 1], [33, 33], [65, 3]] {
        let is_noisy = |x: u32, y: u32| (x / 8 + y / 8).is_multiple_of(3);
        let (map, tiles) = sampled_in(size, |x, y| [1.0, if is_noisy(x, y) { 0.5 } else { 0.02 }]);
        let ends = allocated(&map, &tiles);
        // A single tile has no tile of the other kind from which to choose the power.
        assert_eq!(ends.is_some(), tiles.len() > 1, "{size:?}");
        for (tile, ends) in tiles.iter().zip(ends.into_iter().flatten()) {
            blocks_of(*tile).for_each(|(place, _)| assert!(ends[place] >= FIRST, "{size:?}"));
        }
    }
}

#[test]
fn colours_are_those_with_random_numbers_of_their_own() {
    let (map, tiles) = sampled(|_, _| 0.3);
    let board = map.board(&Vec::from_iter(0..tiles.len()), FIRST).expect("all is known");
    for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
        let place = (y / BLOCK) as usize * board.columns + (x / BLOCK) as usize;
        assert_eq!(
            board.colour_of(place),
            (place_in_block(x, y) & COLOUR) as usize,
            "{x}, {y}"
        );
    }
}

#[test]
fn what_was_found_survives_writing() {
    let (map, tiles) = sampled(|x, _| if x < 40 { 0.3 } else { 0.02 });
    let mut bytes = Writer::default();
    map.write(&mut bytes);
    let mut read = NoiseMap::new(&tiles, WIDTH);
    read.read(&mut Reader(&bytes.0)).expect("what was written");
    assert_eq!((&read.levels, &read.even), (&map.levels, &map.even));
    for length in [0, 3, 40, bytes.0.len() - 1] {
        let mut cut = NoiseMap::new(&tiles, WIDTH);
        assert!(cut.read(&mut Reader(&bytes.0[..length])).is_err(), "{length}");
    }
}

#[test]
fn what_is_no_noise_is_damaged() {
    let all = tiles(WIDTH, HEIGHT);
    let blocks = NoiseMap::new(&all, WIDTH).blocks;
    for (found, is_possible) in [
        ([0.5, 1.0, 3.0], true),
        ([f32::NAN, 1.0, 3.0], false),
        ([0.5, f32::INFINITY, 3.0], false),
        ([0.5, 1.0, f32::NAN], false),
        ([-0.5, 1.0, 3.0], false),
        ([0.5, -1.0, 3.0], false),
        ([0.5, 1.0, -3.0], false),
    ] {
        let mut bytes = Writer::default();
        all.iter().for_each(|_| bytes.put(0u32));
        bytes.put(1u32);
        (0..blocks).for_each(|_| bytes.put(found));
        let read = NoiseMap::new(&all, WIDTH).read(&mut Reader(&bytes.0));
        assert_eq!(read.is_ok(), is_possible, "{found:?}");
    }
}
