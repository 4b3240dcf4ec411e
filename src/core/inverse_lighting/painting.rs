//! From strokes and a wanted picture to observations of the light.
//!
//! Observations are means over blocks of pixels, weighted by what a stroke covers. Layers of light are noisy, and noise
//! in the light of a lamp makes least squares underrate the lamp (errors in variables); means have much less of it.

use std::ops::Range;
use std::sync::Arc;

use glam::UVec2;
use rayon::prelude::*;

use super::coverage::{Coverage, Stroke};
use super::observations::{Observation, Observations, Wanted};
use super::wish::Wish;
use crate::color::{Rgb, luminance};
use crate::sampling::hash::pcg3d;

/// The width and height of a block in pixels.
const BLOCK: u32 = 8;

/// Errors are relative to the light of a place, but at least to this share of the brightest painted place.
const DARKEST: f32 = 1e-3;

/// The light of lamps in a picture.
pub trait LampLight: Sync {
    /// Width and height in pixels.
    fn size(&self) -> [u32; 2];

    /// Writes the radiance of each lamp at a gain of one into `light`, which is black. None if the pixel has no light
    /// yet.
    fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen>;

    /// The same of the irradiance on the surface that is seen. None where there is no surface, and where it is not
    /// known.
    fn irradiance_at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen>;
}

/// The light of a pixel besides that of each lamp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// The light of everything but the lamps in question.
    pub rest: Rgb,
    /// The present light of all together, to which wishes refer.
    pub present: Rgb,
}

/// Something that wants light.
#[derive(Clone, Debug)]
pub enum Target {
    /// A brush stroke.
    Stroke(Stroke),
    /// The radiance of each pixel, row by row; None where any will do.
    Picture(Arc<[Option<Rgb>]>),
}

impl Target {
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Stroke(one), Self::Stroke(other)) => one == other,
            (Self::Picture(one), Self::Picture(other)) => Arc::ptr_eq(one, other),
            _ => false,
        }
    }

    /// Whether it wants illuminance.
    fn is_of_irradiance(&self) -> bool {
        matches!(self, Self::Stroke(stroke) if matches!(stroke.wish, Wish::Illuminance(_)))
    }
}

/// All that is wanted, and the observations so far. Later targets cover earlier ones.
#[derive(Debug, Default)]
pub struct Painting {
    size: [u32; 2],
    lamps: usize,
    parts: Vec<Part>,
}

/// A target with what is known of it.
#[derive(Debug)]
struct Part {
    target: Target,
    /// What it covers of the picture that later targets leave.
    cover: Cover,
    /// The size of the picture.
    size: [u32; 2],
    /// The rows of blocks that are left to observe.
    left: Range<u32>,
    found: Observations,
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
#[derive(Debug, PartialEq)]
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
    fn blocks(&self, [width, height]: [u32; 2]) -> [Range<u32>; 2] {
        let (columns, rows) = match self {
            Self::Part(coverage) => (coverage.columns.clone(), coverage.rows.clone()),
            Self::All(_) => (0..width, 0..height),
        };
        [columns, rows].map(|pixels| pixels.start / BLOCK..pixels.end.div_ceil(BLOCK))
    }
}

impl Painting {
    /// The observations of these targets in one go.
    pub fn observe_all(targets: Vec<Target>, source: &impl LampLight, lamps: usize) -> Observations {
        let mut painting = Self::default();
        painting.set(targets, source.size(), lamps);
        painting.observe(source, || false);
        painting.observations()
    }

    /// Sets what is wanted of a picture of this size, and the number of lamps. Observations of targets that have not
    /// changed, and are not covered otherwise, stay. A target whose picture has another size is left out.
    pub fn set(&mut self, targets: Vec<Target>, size: [u32; 2], lamps: usize) {
        if (self.size, self.lamps) != (size, lamps) {
            (self.size, self.lamps, self.parts) = (size, lamps, Vec::new());
        }
        let covers = covers(&targets, size);
        let mut known = std::mem::take(&mut self.parts);
        let part = |(target, cover): (Target, Cover)| {
            let same = known
                .iter()
                .position(|part| part.target.is_same(&target) && part.cover == cover);
            same.map(|place| known.swap_remove(place)).unwrap_or_else(|| Part {
                left: cover.blocks(size)[1].clone(),
                found: Observations::new(lamps),
                target,
                cover,
                size,
            })
        };
        self.parts = targets.into_iter().zip(covers).map(part).collect();
    }

    /// The targets, as they were set.
    pub fn targets(&self) -> Vec<Target> {
        self.parts.iter().map(|part| part.target.clone()).collect()
    }

    /// Forgets the observations, because the light is another.
    pub fn forget(&mut self) {
        self.parts.iter_mut().for_each(Part::forget);
    }

    /// Forgets the observations of irradiance.
    pub fn forget_irradiance(&mut self) {
        let parts = self.parts.iter_mut();
        parts
            .filter(|part| part.target.is_of_irradiance())
            .for_each(Part::forget);
    }

    /// Observes what is not known yet, until `is_late`, which is asked every few rows. Returns whether all is known.
    pub fn observe(&mut self, source: &impl LampLight, mut is_late: impl FnMut() -> bool) -> bool {
        let rows_at_once = 2 * rayon::current_num_threads() as u32;
        for part in &mut self.parts {
            while !part.left.is_empty() {
                if is_late() {
                    return false;
                }
                let end = part.left.end.min(part.left.start + rows_at_once);
                let rows = part.left.start..end;
                let of_rows: Vec<_> = rows
                    .into_par_iter()
                    .map(|row| part.row(row, source, self.lamps))
                    .collect();
                of_rows.into_iter().for_each(|found| part.found.append(found));
                part.left.start = end;
            }
        }
        true
    }

    /// The observations, with errors relative to the wanted or the present light, whichever is brighter. Strokes are
    /// counted as targets are.
    pub fn observations(&self) -> Observations {
        let mut all = Observations::new(self.lamps);
        for (number, part) in self.parts.iter().enumerate() {
            all.append_as(number, &part.found);
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

    /// The pixels whose radiance is wanted, or whose irradiance is: at most `most` of them, chosen evenly, row by row.
    pub fn pixels(&self, irradiance: bool, most: usize) -> Vec<UVec2> {
        let [width, height] = self.size;
        let parts: Vec<&Part> = self
            .parts
            .iter()
            .filter(|part| part.target.is_of_irradiance() == irradiance)
            .collect();
        let all = (0..height).flat_map(|y| (0..width).map(move |x| UVec2::new(x, y)));
        let is_wanted = |at: &UVec2| parts.iter().any(|part| part.cover.share(at.x, at.y, width) > 0.0);
        let mut wanted: Vec<UVec2> = all.filter(is_wanted).collect();
        if wanted.len() > most {
            // Every n-th pixel would be in few columns.
            wanted.sort_by_cached_key(|at| pcg3d([at.x, at.y, 0]));
            wanted.truncate(most);
            wanted.sort_by_key(|at| [at.y, at.x]);
        }
        wanted
    }
}

/// What each target covers that later ones leave.
fn covers(targets: &[Target], [width, height]: [u32; 2]) -> Vec<Cover> {
    let pixels = width as usize * height as usize;
    let mut left = vec![1.0_f32; pixels];
    let mut covers: Vec<Cover> = Vec::new();
    for target in targets.iter().rev() {
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

impl Part {
    fn forget(&mut self) {
        self.left = self.cover.blocks(self.size)[1].clone();
        self.found = Observations::new(self.found.lamps());
    }

    /// The observations of a row of blocks.
    fn row(&self, row: u32, source: &impl LampLight, lamps: usize) -> Observations {
        let mut found = Observations::new(lamps);
        for column in self.cover.blocks(self.size)[0].clone() {
            let means = self.means([column, row], source, lamps);
            if let Some((observation, light)) = means.and_then(Means::observation) {
                found.push(observation, &light);
            }
        }
        found
    }

    /// The means over a block; None if that is not covered.
    fn means(&self, block: [u32; 2], source: &impl LampLight, lamps: usize) -> Option<Means> {
        let [width, height] = self.size;
        let [columns, rows] =
            [(block[0], width), (block[1], height)].map(|(block, end)| block * BLOCK..((block + 1) * BLOCK).min(end));
        let mut means: Option<Means> = None;
        let mut light = vec![Rgb::ZERO; lamps];
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            let share = self.cover.share(x, y, width);
            if share <= 0.0 {
                continue;
            }
            light.fill(Rgb::ZERO);
            let seen = match self.target.is_of_irradiance() {
                true => source.irradiance_at(x, y, &mut light),
                false => source.at(x, y, &mut light),
            };
            let Some(seen) = seen else { continue };
            let wanted = match &self.target {
                Target::Stroke(stroke) => stroke.wish.wanted(seen.present),
                Target::Picture(picture) => picture[y as usize * width as usize + x as usize].map(Wanted::Color),
            };
            if let Some(wanted) = wanted {
                let means = means.get_or_insert_with(|| Means::new(lamps));
                means.add(share.into(), wanted, seen, &light);
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

    fn add(&mut self, weight: f64, wanted: Wanted, seen: Seen, light: &[Rgb]) {
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
        for (sum, value) in sums.zip([&wanted, &seen.present, &seen.rest].into_iter().chain(light)) {
            for (sum, value) in sum.iter_mut().zip(value.to_array()) {
                *sum += weight * f64::from(value);
            }
        }
    }

    /// The observation and the light of each lamp.
    fn observation(self) -> Option<(Observation, Vec<Rgb>)> {
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
            stroke: 0,
        };
        Some((observation, light))
    }
}
