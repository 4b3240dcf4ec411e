//! The settings of the grid on the ground and of the axes of the world, which are drawn over the picture.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

/// The settings of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct GridSettings {
    /// Whether the grid and the axes are drawn.
    pub shown: bool,
    /// The distance between its lines in world units; None for a power of ten that suits the view.
    pub step: Option<f32>,
}

/// The range of [`GridSettings::step`].
pub const GRID_STEPS: RangeInclusive<f32> = 1e-6..=1e6;

/// The least distance between lines in the middle of the view, in points of the window.
const NARROWEST: f32 = 10.0;

impl Default for GridSettings {
    fn default() -> Self {
        Self {
            shown: true,
            step: None,
        }
    }
}

impl GridSettings {
    /// The settings with values limited to what the controls can set.
    pub(crate) fn within_range(self) -> Self {
        Self {
            step: self.step.filter(|step| GRID_STEPS.contains(step)),
            ..self
        }
    }

    /// The distance between lines in world units where a point of the window is as wide as `units_per_point`: the
    /// chosen one, or the least power of ten at which lines are 10 points apart or more.
    pub fn step_at(&self, units_per_point: f32) -> f32 {
        let suits = || {
            // NaN, as of a view without a depth, becomes the least step.
            let least = f64::from((NARROWEST * units_per_point).max(1e-6)).min(1e6);
            // A power of ten that is almost reached counts, so that rounding errors do not matter.
            10f64.powf((least.log10() - 1e-4).ceil()) as f32
        };
        self.step.unwrap_or_else(suits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_powers_of_ten_that_can_be_told_apart() {
        let grid = GridSettings::default();
        for (units_per_point, step) in [(0.1, 1.0), (0.11, 10.0), (0.0005, 0.01), (3.0, 100.0)] {
            let found = grid.step_at(units_per_point);
            assert!((found / step - 1.0).abs() < 1e-5, "{units_per_point}: {found}");
        }
        for unknown in [f32::NAN, 0.0] {
            let step = grid.step_at(unknown);
            assert!(step.is_finite() && step > 0.0, "{unknown}: {step}");
        }
        let chosen = GridSettings {
            step: Some(0.25),
            ..grid
        };
        assert_eq!(chosen.step_at(3.0), 0.25);
        let wrong = GridSettings {
            step: Some(-1.0),
            ..grid
        };
        assert_eq!(wrong.within_range().step, None);
    }
}
