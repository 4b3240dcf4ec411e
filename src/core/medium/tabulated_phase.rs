//! A phase function by a table of values at equal steps of the cosine, linear in between.

/// A function of the cosine of the angle between the old and the new direction, with integral 1 over the sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct TabulatedPhase {
    /// Densities per solid angle from cosine -1 (backwards) to 1 (forwards).
    values: Vec<f32>,
    /// The integral over the cosine up to each value, normalised from 0 to 1.
    sums: Vec<f32>,
}

impl TabulatedPhase {
    /// The function in proportion to `values`, from cosine -1 to 1. None if there are fewer than two values, one is
    /// negative or not finite, or all are zero.
    pub fn new(values: &[f32]) -> Option<Self> {
        let is_bad = |value: &f32| !(*value >= 0.0 && value.is_finite());
        if values.len() < 2 || values.iter().any(is_bad) {
            return None;
        }
        let step = 2.0 / (values.len() - 1) as f64;
        let mut sum = 0.0f64;
        let areas = values.windows(2).map(|pair| {
            sum += 0.5 * step * (f64::from(pair[0]) + f64::from(pair[1]));
            sum
        });
        let sums: Vec<f64> = [0.0].into_iter().chain(areas).collect();
        let total = *sums.last()?;
        let per_solid_angle = 1.0 / (std::f64::consts::TAU * total);
        (total > 0.0).then(|| Self {
            values: values
                .iter()
                .map(|&value| (f64::from(value) * per_solid_angle) as f32)
                .collect(),
            sums: sums.iter().map(|sum| (sum / total) as f32).collect(),
        })
    }

    /// The density per solid angle.
    pub(super) fn pdf(&self, cosine: f32) -> f32 {
        let last = self.values.len() - 2;
        let place = (cosine + 1.0) * 0.5 * (last + 1) as f32;
        let step = (place as usize).min(last);
        let part = place - step as f32;
        self.values[step] + part * (self.values[step + 1] - self.values[step])
    }

    /// Samples the cosine by inversion: `u` falls into a step, where the density is linear.
    pub(super) fn sample(&self, u: f32) -> f32 {
        let last = self.values.len() - 2;
        let step = self.sums.partition_point(|&sum| sum <= u).saturating_sub(1).min(last);
        let (a, b) = (self.values[step], self.values[step + 1]);
        let area = self.sums[step + 1] - self.sums[step];
        let rest = ((u - self.sums[step]) / area).clamp(0.0, 1.0);
        // The root of a x + (b - a) x^2 / 2 = rest (a + b) / 2, in the form that does not cancel.
        let discriminant = a * a + rest * (b - a) * (a + b);
        let part = rest * (a + b) / (a + discriminant.max(0.0).sqrt());
        let part = if part.is_finite() { part.min(1.0) } else { 0.5 };
        (2.0 * (step as f32 + part) / (last + 1) as f32 - 1.0).clamp(-1.0, 1.0)
    }
}
