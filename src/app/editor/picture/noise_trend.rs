//! The noise of the picture over its number of samples, for the status line.

use bevy::prelude::*;

use crate::engine::{RenderFilm, RenderStatus};

/// The largest number of points. When it is reached, every second one is left out.
const MOST: usize = 64;

/// The noise of the present picture at increasing numbers of samples.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct NoiseTrend {
    job: u64,
    /// The samples per pixel and the estimated relative noise at that time.
    points: Vec<(u32, f32)>,
}

impl NoiseTrend {
    /// The points, by rising numbers of samples.
    pub fn points(&self) -> &[(u32, f32)] {
        &self.points
    }

    /// Notes the state of the picture that is number `job`.
    pub fn note(&mut self, job: u64, samples: u32, noise: Option<f32>) {
        let last = self.points.last().map_or(0, |(samples, _)| *samples);
        if self.job != job || samples < last {
            self.job = job;
            self.points.clear();
        }
        let Some(noise) = noise.filter(|noise| noise.is_finite()) else {
            return;
        };
        if self.points.last().is_some_and(|(last, _)| *last == samples) {
            return;
        }
        if self.points.len() == MOST {
            let mut place = 0;
            self.points.retain(|_| {
                place += 1;
                place % 2 == 1
            });
        }
        self.points.push((samples, noise));
    }
}

/// Notes the present noise of the picture.
pub fn follow_noise(mut trend: ResMut<NoiseTrend>, film: Res<RenderFilm>, status: Res<RenderStatus>) {
    trend
        .bypass_change_detection()
        .note(film.job, status.samples, status.noise);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_of_one_picture_and_few() {
        let mut trend = NoiseTrend::default();
        trend.note(1, 1, None);
        for samples in 2..=1000 {
            for _ in 0..2 {
                trend.note(1, samples, Some(1.0 / samples as f32));
            }
        }
        let points = trend.points();
        assert!((MOST / 2..=MOST).contains(&points.len()), "{}", points.len());
        assert!(
            points
                .windows(2)
                .all(|pair| pair[0].0 < pair[1].0 && pair[0].1 > pair[1].1)
        );
        assert_eq!(points.last().map(|(samples, _)| *samples), Some(1000));
        trend.note(1, 1001, Some(f32::NAN));
        assert_eq!(trend.points().last().map(|(samples, _)| *samples), Some(1000));
        trend.note(2, 1, None);
        assert_eq!(trend.points(), []);
    }
}
