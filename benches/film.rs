//! What one thread of the window does for each pixel of new samples: it adds them to the film, estimates the noise anew
//! and makes colours for the screen.
//!
//! `cargo bench --bench film` prints nanoseconds per pixel, the least of several rounds, over a film of 800 x 600.

use std::hint::black_box;
use std::ops::Range;
use std::time::Instant;

use glam::Vec3;
use sunroom_core::color::Rgb;
use sunroom_core::render::film::Film;
use sunroom_core::render::noise::PictureNoise;
use sunroom_core::render::tile::{PixelSum, TILE, Tile, TileSamples, tiles};
use sunroom_core::render::tonemap::{Display, ToneMap};

const SIZE: [u32; 2] = [800, 600];
/// The passes in which samples arrive, as a picture begins.
const PASSES: [Range<u32>; 5] = [0..1, 1..2, 2..4, 4..8, 8..16];
const ROUNDS: u32 = 10;

fn main() {
    let tiles = tiles(SIZE[0], SIZE[1]);
    let samples: Vec<Vec<TileSamples>> = PASSES
        .into_iter()
        .map(|pass| tiles.iter().map(|&tile| samples_of(tile, pass.clone())).collect())
        .collect();
    let (mut film, mut noise) = (Film::default(), PictureNoise::new(0));
    let mut adding = least(|| {
        film.begin(SIZE[0], SIZE[1], Default::default());
        noise = PictureNoise::new(tiles.len());
        let start = Instant::now();
        for sample in samples.iter().flatten() {
            film.add(sample);
        }
        start.elapsed().as_secs_f64()
    });
    adding /= PASSES.len() as f64;
    print("add a pass to the film", adding);
    let noting = least(|| {
        let start = Instant::now();
        for (index, &tile) in tiles.iter().enumerate() {
            noise.update(index, &film, tile);
        }
        start.elapsed().as_secs_f64()
    });
    print("estimate the noise", noting);
    let mut row = [None; TILE as usize];
    let reading = least(|| {
        let start = Instant::now();
        for &tile in &tiles {
            for y in tile.y..tile.y + tile.height {
                film.mixed_row(tile, y, &[], &mut row);
                black_box(&row);
            }
        }
        start.elapsed().as_secs_f64()
    });
    print("read the light", reading);
    let radiance = film.radiance();
    let mut rgba = vec![0; 4 * radiance.len()];
    for tone_map in ToneMap::ALL {
        let display = Display {
            tone_map,
            ..Display::default()
        };
        let encoding = least(|| {
            let start = Instant::now();
            display.encode_rgba(black_box(&radiance), &mut rgba);
            black_box(&rgba);
            start.elapsed().as_secs_f64()
        });
        print(&format!("encode, {}", tone_map.name()), encoding);
    }
}

/// A pass of a tile, of light that differs from pixel to pixel and from pass to pass.
fn samples_of(tile: Tile, samples: Range<u32>) -> TileSamples {
    let pixel = |place: u32| {
        let bits = (place + 1024 * samples.start + tile.x + 800 * tile.y).wrapping_mul(0x9e37_79b9) >> 8;
        let light = bits as f32 / (1 << 24) as f32;
        PixelSum {
            radiance: Rgb::new(4.0 * light, light, 0.1 + 0.2 * light),
            albedo: Rgb::splat(0.5),
            normal: Vec3::Z,
            depth: 1.0,
            luminance_squared: light * light,
            rays: 3.0,
        }
    };
    TileSamples {
        tile,
        blocks: None,
        pixels: (0..tile.width * tile.height).map(pixel).collect(),
        samples,
        layers: Default::default(),
        first_hits: Vec::new(),
        splats: Default::default(),
        rays: 0,
        invalid: 0,
    }
}

fn least(mut round: impl FnMut() -> f64) -> f64 {
    (0..ROUNDS).map(|_| round()).fold(f64::INFINITY, f64::min)
}

fn print(what: &str, seconds: f64) {
    let pixels = f64::from(SIZE[0] * SIZE[1]);
    println!("{what:<30}{:>8.1} ns", 1e9 * seconds / pixels);
}
