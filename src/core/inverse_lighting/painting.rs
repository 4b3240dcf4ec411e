//! From strokes and a wanted picture to observations of the light.
//!
//! Observations are means over blocks of pixels, weighted by what a stroke covers. Layers of light are noisy, and noise
//! in the light of a lamp makes least squares underrate the lamp (errors in variables); means have much less of it.

use std::ops::Range;

use rayon::prelude::*;

use super::coverage::{Coverage, Stroke};
use super::observations::{Observation, Observations, Wanted};
use super::solve::LampLimits;
use crate::color::{Rgb, luminance};

/// The width and height of a block in pixels.
const BLOCK: u32 = 8;

/// Errors are relative to the light of a place, but at least to this share of the brightest painted place.
const DARKEST: f32 = 1e-3;

/// The light of lamps in a picture.
pub trait LampLight: Sync {
    /// Width and height in pixels.
    fn size(&self) -> [u32; 2];

    /// Writes the radiance of each lamp at a gain of one into `light`, which is black. Returns the radiance of
    /// everything else and the albedo; None if the pixel has no light yet.
    fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<(Rgb, Rgb)>;
}

/// Something that wants light.
#[derive(Clone, Copy, Debug)]
pub enum Target<'a> {
    /// A brush stroke.
    Stroke(&'a Stroke),
    /// The radiance of each pixel, row by row; None where any will do.
    Picture(&'a [Option<Rgb>]),
}

/// All that is wanted. Later targets cover earlier ones.
#[derive(Clone, Copy, Debug)]
pub struct Painting<'a> {
    /// The targets.
    pub targets: &'a [Target<'a>],
}

/// The means over a block.
struct Means {
    weight: f64,
    wanted: [f64; 3],
    is_color: bool,
    present: [f64; 3],
    rest: [f64; 3],
    light: Vec<[f64; 3]>,
}

/// What a target covers of the picture that later ones leave.
enum Cover {
    Part(Coverage),
    /// The shares of all pixels, row by row.
    All(Vec<f32>),
}

impl Cover {
    fn share(&self, x: u32, y: u32, width: u32) -> f32 {
        match self {
            Self::Part(coverage) => coverage.share(x, y),
            Self::All(shares) => shares[y as usize * width as usize + x as usize],
        }
    }

    /// The columns and rows of blocks that it may cover.
    fn blocks(&self, width: u32, height: u32) -> [Range<u32>; 2] {
        let (columns, rows) = match self {
            Self::Part(coverage) => (coverage.columns.clone(), coverage.rows.clone()),
            Self::All(_) => (0..width, 0..height),
        };
        [columns, rows].map(|pixels| pixels.start / BLOCK..pixels.end.div_ceil(BLOCK))
    }
}

impl Painting<'_> {
    /// The observations of these lamps, with errors relative to the wanted or the present light, whichever is brighter.
    /// Strokes are counted as in [`Self::targets`]; a target whose picture
    /// has another size is left out.
    pub fn observations(&self, source: &impl LampLight, lamps: &[LampLimits]) -> Observations {
        let [width, height] = source.size();
        let mut all = Observations::new(lamps.len());
        for (target, cover) in self.covers(width, height).into_iter().enumerate() {
            let [columns, rows] = cover.blocks(width, height);
            let of_row = |row: u32| {
                let mut found = Observations::new(lamps.len());
                for column in columns.clone() {
                    let means = self.means(target, &cover, [column, row], source, lamps);
                    if let Some((observation, light)) = means.and_then(|means| means.observation(target)) {
                        found.push(observation, &light);
                    }
                }
                found
            };
            let of_rows: Vec<_> = rows.into_par_iter().map(of_row).collect();
            of_rows.into_iter().for_each(|found| all.append(found));
        }
        let mut levels: Vec<f32> = all.list().iter().map(|one| one.level).collect();
        let middle = levels.len() / 2;
        let usual = match levels.is_empty() {
            true => 0.0,
            false => *levels.select_nth_unstable_by(middle, f32::total_cmp).1,
        };
        let least = (DARKEST * usual).max(f32::MIN_POSITIVE);
        for observation in all.list_mut() {
            observation.level = observation.level.max(least);
        }
        all
    }

    /// What each target covers that later ones leave.
    fn covers(&self, width: u32, height: u32) -> Vec<Cover> {
        let pixels = width as usize * height as usize;
        let mut left = vec![1.0_f32; pixels];
        let mut covers: Vec<Cover> = Vec::new();
        for target in self.targets.iter().rev() {
            covers.push(match target {
                Target::Stroke(stroke) => {
                    let mut coverage = stroke.coverage(width, height);
                    let columns = coverage.columns.len().max(1);
                    for (y, row) in coverage.rows.clone().zip(coverage.shares.chunks_mut(columns)) {
                        let start = y as usize * width as usize + coverage.columns.start as usize;
                        for (share, left) in row.iter_mut().zip(&mut left[start..]) {
                            let own = *share;
                            *share *= *left;
                            *left *= 1.0 - own;
                        }
                    }
                    Cover::Part(coverage)
                }
                Target::Picture(picture) if picture.len() == pixels => {
                    Cover::All(std::mem::replace(&mut left, vec![0.0; pixels]))
                }
                Target::Picture(_) => Cover::Part(Coverage::default()),
            });
        }
        covers.reverse();
        covers
    }

    /// The means over a block of what a target covers; None if that is nothing.
    fn means(
        &self,
        target: usize,
        cover: &Cover,
        block: [u32; 2],
        source: &impl LampLight,
        lamps: &[LampLimits],
    ) -> Option<Means> {
        let [width, height] = source.size();
        let [columns, rows] =
            [(block[0], width), (block[1], height)].map(|(block, end)| block * BLOCK..((block + 1) * BLOCK).min(end));
        let mut means: Option<Means> = None;
        let mut light = vec![Rgb::ZERO; lamps.len()];
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            let share = cover.share(x, y, width);
            if share <= 0.0 {
                continue;
            }
            light.fill(Rgb::ZERO);
            let Some((rest, albedo)) = source.at(x, y, &mut light) else {
                continue;
            };
            let own = light.iter().zip(lamps).map(|(&light, lamp)| light * lamp.present);
            let present = rest + own.sum::<Rgb>();
            let wanted = match self.targets[target] {
                Target::Stroke(stroke) => stroke.wish.wanted(present, albedo),
                Target::Picture(picture) => picture[y as usize * width as usize + x as usize].map(Wanted::Color),
            };
            if let Some(wanted) = wanted {
                let means = means.get_or_insert_with(|| Means::new(lamps.len()));
                means.add(share.into(), wanted, present, rest, &light);
            }
        }
        means
    }
}

impl Means {
    fn new(lamps: usize) -> Self {
        Self {
            weight: 0.0,
            wanted: [0.0; 3],
            is_color: false,
            present: [0.0; 3],
            rest: [0.0; 3],
            light: vec![[0.0; 3]; lamps],
        }
    }

    fn add(&mut self, weight: f64, wanted: Wanted, present: Rgb, rest: Rgb, light: &[Rgb]) {
        self.weight += weight;
        let wanted = match wanted {
            Wanted::Color(color) => {
                self.is_color = true;
                color
            }
            Wanted::Luminance(luminance) => Rgb::splat(luminance),
        };
        let sums = [&mut self.wanted, &mut self.present, &mut self.rest]
            .into_iter()
            .chain(&mut self.light);
        for (sum, value) in sums.zip([&wanted, &present, &rest].into_iter().chain(light)) {
            for (sum, value) in sum.iter_mut().zip(value.to_array()) {
                *sum += weight * f64::from(value);
            }
        }
    }

    /// The observation and the light of each lamp.
    fn observation(self, stroke: usize) -> Option<(Observation, Vec<Rgb>)> {
        if self.weight <= 0.0 {
            return None;
        }
        let mean = |sum: [f64; 3]| Rgb::from(sum.map(|sum| (sum / self.weight) as f32));
        let wanted = match self.is_color {
            true => Wanted::Color(mean(self.wanted)),
            false => Wanted::Luminance(mean(self.wanted).x),
        };
        // The size of light is measured as its errors are: of a colour by the mean square of its components.
        let size = |color: Rgb| color.length() / 3.0_f32.sqrt();
        let present = mean(self.present);
        let level = match wanted {
            Wanted::Color(color) => size(color).max(size(present)),
            Wanted::Luminance(wanted) => wanted.max(luminance(present)),
        };
        let light = self.light.iter().copied().map(mean).collect();
        let observation = Observation {
            wanted,
            rest: mean(self.rest),
            weight: self.weight as f32,
            level,
            stroke,
        };
        Some((observation, light))
    }
}
