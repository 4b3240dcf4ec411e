//! How long it takes to find 24 lamps for a wanted picture of 800 x 500 pixels, as while one paints.
//!
//! `cargo bench --bench inverse_lighting` prints milliseconds, the least of several rounds.

use std::hint::black_box;
use std::time::Instant;

use glam::Vec2;
use sunroom_core::color::Rgb;
use sunroom_core::inverse_lighting::{LampLight, LampLimits, Painting, Seen, Stroke, Target, Wish, solve};

const SIZE: [u32; 2] = [800, 500];
const LAMPS: usize = 24;
const ROUNDS: u32 = 10;

/// Lamps over a floor, pixel by pixel.
struct Floor(Vec<[Rgb; LAMPS]>);

impl LampLight for Floor {
    fn size(&self) -> [u32; 2] {
        SIZE
    }

    fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        light.copy_from_slice(&self.0[(y * SIZE[0] + x) as usize]);
        let rest = Rgb::splat(0.01);
        Some(Seen {
            rest,
            present: rest + light.iter().sum::<Rgb>(),
        })
    }

    fn irradiance_at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        self.at(x, y, light)
    }
}

fn main() {
    let light = |pixel: u32| {
        std::array::from_fn(|lamp| {
            let at = Vec2::new((pixel % SIZE[0]) as f32, (pixel / SIZE[0]) as f32) / SIZE[1] as f32;
            let place = Vec2::new(0.1 + 0.2 * (lamp % 8) as f32, 0.2 + 0.3 * (lamp / 8) as f32);
            Rgb::new(1.0, 0.9, 0.8) * 0.001 / (at.distance_squared(place) + 0.02)
        })
    };
    let floor = Floor((0..SIZE[0] * SIZE[1]).map(light).collect());
    let picture: Vec<Option<Rgb>> = floor
        .0
        .iter()
        .map(|lamps| Some(1.5 * lamps.iter().sum::<Rgb>()))
        .collect();
    let stroke = Stroke {
        wish: Wish::Brighter(3.0),
        path: (0..40).map(|step| Vec2::new(0.2 + 0.015 * step as f32, 0.5)).collect(),
        radius: 0.1,
        hardness: 0.5,
    };
    for (name, target) in [
        ("a picture of all pixels", Target::Picture(picture.into())),
        ("a stroke across the picture", Target::Stroke(stroke)),
    ] {
        for colored in [false, true] {
            let limits = vec![
                LampLimits {
                    colored,
                    ..LampLimits::of_strength(10.0)
                };
                LAMPS
            ];
            let (mut observing, mut solving) = (f64::INFINITY, f64::INFINITY);
            for _ in 0..ROUNDS {
                let start = Instant::now();
                let observations = Painting::observe_all(vec![target.clone()], &floor, LAMPS);
                observing = observing.min(start.elapsed().as_secs_f64());
                let start = Instant::now();
                black_box(solve(&observations, &limits)).expect("an answer");
                solving = solving.min(start.elapsed().as_secs_f64());
            }
            let kind = if colored { "strengths and colours" } else { "strengths" };
            println!(
                "{name}, {kind}: {:.1} ms to observe, {:.1} ms to solve",
                1e3 * observing,
                1e3 * solving
            );
        }
    }
}
