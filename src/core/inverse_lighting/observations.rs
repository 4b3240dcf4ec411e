//! The light of lamps at places of a picture, with the light that is wanted there, and the normal equations of both.

use std::ops::Range;

use rayon::prelude::*;

use super::solve::LampLimits;
use crate::color::{LUMINANCE, Rgb, luminance};

/// The light that is wanted at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// This radiance, in linear Rec. 709. Each component counts a third.
    Color(Rgb),
    /// This luminance of any colour, in the units of radiance.
    Luminance(f32),
}

/// A place of the picture, or the mean over some of its pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// The light that is wanted, of all lamps and the rest together.
    pub wanted: Wanted,
    /// The light of everything but the lamps in question.
    pub rest: Rgb,
    /// The weight of the squared error, at least 0.
    pub weight: f32,
    /// The luminance that the error is relative to, above 0.
    pub level: f32,
    /// The number of the stroke that wants it.
    pub stroke: usize,
}

/// All that is wanted, with the light of each lamp.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observations {
    lamps: usize,
    /// The light of each lamp at a gain of one, observation by observation.
    light: Vec<Rgb>,
    list: Vec<Observation>,
}

/// The number of observations that are summed up in one go: sums do not depend on the number of threads.
const CHUNK: usize = 1024;

impl Observations {
    /// No observation yet, of this number of lamps.
    pub fn new(lamps: usize) -> Self {
        Self {
            lamps,
            ..Self::default()
        }
    }

    /// Adds an observation. `light` is the radiance of each lamp at a gain of one; lamps beyond the number given at
    /// first are left out, and those that are absent are dark there.
    pub fn push(&mut self, observation: Observation, light: &[Rgb]) {
        self.list.push(observation);
        let dark = std::iter::repeat(Rgb::ZERO);
        self.light.extend(light.iter().copied().chain(dark).take(self.lamps));
    }

    /// Adds those of another list of as many lamps, as those of the stroke with this number.
    pub(super) fn append_as(&mut self, stroke: usize, other: &Self) {
        let list = other.list.iter().map(|one| Observation { stroke, ..*one });
        self.list.extend(list);
        self.light.extend_from_slice(&other.light);
    }

    /// Adds those of another list of as many lamps.
    pub(super) fn append(&mut self, mut other: Self) {
        self.list.append(&mut other.list);
        self.light.append(&mut other.light);
    }

    /// The number of lamps.
    pub fn lamps(&self) -> usize {
        self.lamps
    }

    /// The observations.
    pub fn list(&self) -> &[Observation] {
        &self.list
    }

    /// The same, to change.
    pub(super) fn list_mut(&mut self) -> &mut [Observation] {
        &mut self.list
    }

    /// The light of each lamp in observation `place`, at a gain of one.
    pub fn light(&self, place: usize) -> &[Rgb] {
        &self.light[place * self.lamps..][..self.lamps]
    }

    /// The light of observation `place` with these gains, one for each lamp.
    pub fn shown(&self, place: usize, gains: &[Rgb]) -> Rgb {
        let lamps = self.light(place).iter().zip(gains);
        self.list[place].rest + lamps.map(|(&light, &gain)| light * gain).sum::<Rgb>()
    }

    /// The squared relative error of observation `place` where the light is `shown`, without its weight.
    pub fn squared_error(&self, place: usize, shown: Rgb) -> f64 {
        let level = f64::from(self.list[place].level);
        let error = match self.list[place].wanted {
            Wanted::Color(color) => (shown - color).as_dvec3().length_squared() / 3.0,
            Wanted::Luminance(wanted) => f64::from(luminance(shown) - wanted).powi(2),
        };
        error / (level * level)
    }

    /// The errors with these gains, each times the root of its share of the weight, so that the sum of their squares is
    /// the mean squared relative error. They are in a fixed order of as many numbers whatever the gains are.
    pub fn residuals(&self, gains: &[Rgb]) -> Vec<f64> {
        let total: f64 = self.list.iter().map(|one| f64::from(one.weight)).sum();
        let mut residuals = Vec::with_capacity(3 * self.list.len());
        for (place, one) in self.list.iter().enumerate() {
            let shown = self.shown(place, gains);
            let scale = (f64::from(one.weight) / total.max(f64::MIN_POSITIVE)).sqrt() / f64::from(one.level);
            match one.wanted {
                Wanted::Color(color) => {
                    let errors = (shown - color).as_dvec3() * (scale / 3.0_f64.sqrt());
                    residuals.extend(errors.to_array());
                }
                Wanted::Luminance(wanted) => residuals.push(scale * f64::from(luminance(shown) - wanted)),
            }
        }
        residuals
    }

    /// Whether all numbers are finite and no weight is negative.
    pub(super) fn are_finite(&self) -> bool {
        let is_finite = |observation: &Observation| {
            let wanted = match observation.wanted {
                Wanted::Color(color) => color.is_finite(),
                Wanted::Luminance(luminance) => luminance.is_finite(),
            };
            let has_weight = observation.weight.is_finite() && observation.weight >= 0.0;
            let has_level = observation.level.is_finite() && observation.level > 0.0;
            wanted && observation.rest.is_finite() && has_weight && has_level
        };
        self.list.iter().all(is_finite) && self.light.iter().all(|light| light.is_finite())
    }

    /// The normal equations of these lamps, of which `unknowns` says the places among all unknown gains. They are
    /// divided by the sum of all weights.
    pub(super) fn normal_equations(&self, limits: &[LampLimits], unknowns: &[Range<usize>]) -> NormalEquations {
        let count = unknowns.last().map_or(0, |last| last.end);
        let chunks = self.list.len().div_ceil(CHUNK);
        let of_chunk = |chunk: usize| {
            let mut sum = NormalEquations::new(count);
            let mut row = vec![0.0; count];
            for place in chunk * CHUNK..((chunk + 1) * CHUNK).min(self.list.len()) {
                self.add_to(&mut sum, place, limits, unknowns, &mut row);
            }
            sum
        };
        let parts: Vec<NormalEquations> = (0..chunks).into_par_iter().map(of_chunk).collect();
        let mut sum = NormalEquations::new(count);
        parts.iter().for_each(|part| sum.add(part));
        sum.divide_by_weight();
        sum
    }

    fn add_to(
        &self,
        sum: &mut NormalEquations,
        place: usize,
        limits: &[LampLimits],
        unknowns: &[Range<usize>],
        row: &mut [f64],
    ) {
        let Observation {
            wanted,
            rest,
            weight,
            level,
            ..
        } = self.list[place];
        if weight == 0.0 {
            return;
        }
        sum.weight += f64::from(weight);
        let weight = f64::from(weight) / f64::from(level).powi(2);
        let lamps = || self.light(place).iter().zip(limits).zip(unknowns);
        match wanted {
            Wanted::Color(color) => {
                for channel in 0..3 {
                    row.fill(0.0);
                    for ((light, limits), unknowns) in lamps() {
                        let own = if limits.colored { channel } else { 0 };
                        row[unknowns.start + own] = f64::from(light[channel]) * limits.tint(channel);
                    }
                    sum.add_row(row, f64::from(color[channel] - rest[channel]), weight / 3.0);
                }
            }
            Wanted::Luminance(wanted) => {
                row.fill(0.0);
                for ((light, limits), unknowns) in lamps() {
                    for channel in 0..3 {
                        let own = if limits.colored { channel } else { 0 };
                        let part = f64::from(light[channel]) * limits.tint(channel);
                        row[unknowns.start + own] += part * f64::from(LUMINANCE[channel]);
                    }
                }
                sum.add_row(row, f64::from(wanted - luminance(rest)), weight);
            }
        }
    }
}

/// The sums of weighted least squares: the error of gains g is g'Mg - 2 r'g + constant.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NormalEquations {
    /// The matrix M, row by row. Only columns up to the diagonal are filled in.
    pub matrix: Vec<f64>,
    pub right: Vec<f64>,
    pub weight: f64,
}

impl NormalEquations {
    pub(super) fn new(unknowns: usize) -> Self {
        Self {
            matrix: vec![0.0; unknowns * unknowns],
            right: vec![0.0; unknowns],
            weight: 0.0,
        }
    }

    pub(super) fn add_row(&mut self, row: &[f64], wanted: f64, weight: f64) {
        let count = row.len();
        for (place, &value) in row.iter().enumerate() {
            let scaled = weight * value;
            if scaled == 0.0 {
                continue;
            }
            self.right[place] += scaled * wanted;
            let sums = &mut self.matrix[place * count..][..=place];
            for (sum, other) in sums.iter_mut().zip(row) {
                *sum += scaled * other;
            }
        }
    }

    fn add(&mut self, other: &Self) {
        let sums = self.matrix.iter_mut().chain(&mut self.right);
        let others = other.matrix.iter().chain(&other.right);
        sums.zip(others).for_each(|(sum, other)| *sum += other);
        self.weight += other.weight;
    }

    fn divide_by_weight(&mut self) {
        if self.weight > 0.0 {
            let sums = self.matrix.iter_mut().chain(&mut self.right);
            sums.for_each(|sum| *sum /= self.weight);
        }
    }
}
