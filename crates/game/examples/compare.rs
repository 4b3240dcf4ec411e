//! Compares a picture that `walk` has saved with one that Sunroom has traced: `cargo run --release --example compare --
//! WALKED.exr TRACED.exr`.
//!
//! The traced picture has to have the layers `object-id`, `geometric-normal` and `emitted`. Pixels count whose
//! neighbours belong to the same object, with the same normal, and send out no light of their own. Luminances are
//! compared as means over 7 x 7 of these pixels.
//!
//! | option | meaning |
//! |---|---|
//! | `--objects A,B` | only these objects count, by their numbers in the layer `object-id`; others may be no diffuse ones |
//! | `--fail-above X` | ends with code 1 if the means differ by more than this share |
//! | `--picture OUT.jpg` | saves both side by side |

use std::collections::HashMap;
use std::error::Error;
use std::process::ExitCode;

use bevy::math::{IVec2, Vec3};
use bevy::prelude::Color;
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use image::RgbImage;

/// A mean is over the pixels at most so far away, in both directions.
const BLUR: i32 = 3;
/// Pixels are near an edge if a pixel that does not count is at most so far away.
const EDGE: i32 = 8;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut files = Vec::new();
    let (mut objects, mut limit, mut picture) = (Vec::new(), None, None);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match &*word {
            "--objects" => {
                for number in value()?.split(',') {
                    objects.push(number.parse::<f32>()?);
                }
            }
            "--fail-above" => limit = Some(value()?.parse::<f64>()?),
            "--picture" => picture = Some(value()?),
            _ => files.push(word),
        }
    }
    let [walked, traced] = &files[..] else {
        return Err("usage: compare WALKED.exr TRACED.exr [--objects A,B] [--fail-above X] [--picture OUT.jpg]".into());
    };
    let (walked, traced) = (Layers::read(walked)?, Layers::read(traced)?);
    if walked.size != traced.size {
        return Err(format!("{} and {} pixels", walked.size, traced.size).into());
    }
    if let Some(picture) = picture {
        side_by_side(&walked, &traced)?.save(picture)?;
    }

    let counts = pixels_that_count(&traced, &objects)?;
    let near_edge = |at| around(at, EDGE).any(|other| traced.index(other).is_some_and(|index| !counts[index]));
    let (walked_light, traced_light) = (walked.luminance()?, traced.luminance()?);
    let mean_around = |light: &[f64], at| {
        let own = around(at, BLUR).filter_map(|other| traced.index(other));
        let own: Vec<f64> = own.filter(|index| counts[*index]).map(|index| light[index]).collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    let mut regions = [
        ("all", Region::default()),
        ("flat", Region::default()),
        ("edges", Region::default()),
    ];
    for at in traced.places() {
        let Some(index) = traced.index(at).filter(|index| counts[*index]) else {
            continue;
        };
        let ratio = mean_around(&walked_light, at) / mean_around(&traced_light, at);
        for region in [0, if near_edge(at) { 2 } else { 1 }] {
            regions[region].1.add(walked_light[index], traced_light[index], ratio);
        }
    }
    println!("region     pixels  mean ratio  median  95 %    99 %    > 1.1   < 0.9");
    for (name, region) in &mut regions {
        region.print(name);
    }
    let distance = (regions[0].1.mean_ratio() - 1.0).abs();
    Ok(match limit {
        // Not a number fails as well.
        Some(limit) if distance.is_nan() || distance > limit => ExitCode::FAILURE,
        _ => ExitCode::SUCCESS,
    })
}

/// The channels of an EXR file.
struct Layers {
    size: IVec2,
    channels: HashMap<String, FlatSamples>,
}

impl Layers {
    fn read(path: &str) -> Result<Self, Box<dyn Error>> {
        let layer = read_first_flat_layer_from_file(path)
            .map_err(|error| format!("{path}: {error}"))?
            .layer_data;
        let size = IVec2::new(layer.size.x() as i32, layer.size.y() as i32);
        let channels = layer.channel_data.list.into_iter();
        Ok(Self {
            size,
            channels: channels
                .map(|channel| (channel.name.to_string(), channel.sample_data))
                .collect(),
        })
    }

    fn channel(&self, name: &str) -> Result<Vec<f32>, String> {
        let samples = self.channels.get(name).ok_or(format!("there is no channel {name}"))?;
        Ok(samples.values_as_f32().collect())
    }

    fn triples(&self, names: [&str; 3]) -> Result<Vec<Vec3>, String> {
        let [x, y, z] = names.map(|name| self.channel(name));
        Ok(x?
            .into_iter()
            .zip(y?)
            .zip(z?)
            .map(|((x, y), z)| Vec3::new(x, y, z))
            .collect())
    }

    fn luminance(&self) -> Result<Vec<f64>, String> {
        let weights = Vec3::new(0.2126, 0.7152, 0.0722);
        Ok(self
            .triples(["R", "G", "B"])?
            .iter()
            .map(|color| f64::from(color.dot(weights)))
            .collect())
    }

    fn places(&self) -> impl Iterator<Item = IVec2> + use<> {
        let IVec2 { x: width, y: height } = self.size;
        (0..height).flat_map(move |y| (0..width).map(move |x| IVec2::new(x, y)))
    }

    fn index(&self, at: IVec2) -> Option<usize> {
        let is_inside = at.cmpge(IVec2::ZERO).all() && at.cmplt(self.size).all();
        is_inside.then(|| (at.y * self.size.x + at.x) as usize)
    }
}

fn around(at: IVec2, distance: i32) -> impl Iterator<Item = IVec2> {
    let side = -distance..=distance;
    side.clone()
        .flat_map(move |y| side.clone().map(move |x| at + IVec2::new(x, y)))
}

fn pixels_that_count(traced: &Layers, objects: &[f32]) -> Result<Vec<bool>, String> {
    let object = traced.channel("ObjectId.Y")?;
    let normal = traced.triples(["GeometricNormal.X", "GeometricNormal.Y", "GeometricNormal.Z"])?;
    let emitted = traced.triples(["Emitted.R", "Emitted.G", "Emitted.B"])?;
    let is_wanted = |index: usize| {
        let number = object[index];
        emitted[index] == Vec3::ZERO && number != 0.0 && (objects.is_empty() || objects.contains(&number))
    };
    let counts = |at| {
        let own = traced.index(at).filter(|index| is_wanted(*index));
        own.is_some_and(|own| {
            around(at, 1)
                .filter_map(|other| traced.index(other))
                .all(|other| is_wanted(other) && object[other] == object[own] && normal[other].dot(normal[own]) > 0.95)
        })
    };
    Ok(traced.places().map(counts).collect())
}

/// Sums over the pixels of a region.
#[derive(Default)]
struct Region {
    walked: f64,
    traced: f64,
    ratios: Vec<f64>,
}

impl Region {
    fn add(&mut self, walked: f64, traced: f64, ratio: f64) {
        self.walked += walked;
        self.traced += traced;
        self.ratios.push(ratio);
    }

    fn mean_ratio(&self) -> f64 {
        self.walked / self.traced
    }

    fn print(&self, name: &str) {
        let mut distances: Vec<f64> = self.ratios.iter().map(|ratio| (ratio - 1.0).abs()).collect();
        distances.sort_by(f64::total_cmp);
        let part = |share: f64| {
            distances
                .get((share * distances.len() as f64) as usize)
                .copied()
                .unwrap_or(f64::NAN)
        };
        let share = |is_meant: fn(&f64) -> bool| {
            let count = self.ratios.iter().filter(|ratio| is_meant(ratio)).count();
            100.0 * count as f64 / self.ratios.len() as f64
        };
        println!(
            "{name:<8} {:>8}  {:<10.4}  {:<6.4}  {:<6.4}  {:<6.4}  {:>4.2} %  {:>4.2} %",
            self.ratios.len(),
            self.mean_ratio(),
            part(0.5),
            part(0.95),
            part(0.99),
            share(|ratio| *ratio > 1.1),
            share(|ratio| *ratio < 0.9),
        );
    }
}

fn side_by_side(walked: &Layers, traced: &Layers) -> Result<RgbImage, String> {
    let halves = [walked.triples(["R", "G", "B"])?, traced.triples(["R", "G", "B"])?];
    let (width, height) = (walked.size.x as u32, walked.size.y as u32);
    Ok(RgbImage::from_fn(2 * width, height, |x, y| {
        let Vec3 {
            x: red,
            y: green,
            z: blue,
        } = halves[(x / width) as usize][(y * width + x % width) as usize];
        let color = Color::linear_rgb(red, green, blue).to_srgba();
        image::Rgb([color.red, color.green, color.blue].map(|value| (255.0 * value.clamp(0.0, 1.0)).round() as u8))
    }))
}
