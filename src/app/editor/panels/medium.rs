//! Rows of the parameters of participating media.

use super::color_field;
use super::fields;
use super::material::Rows;
use crate::color::Rgb;
use crate::scene::medium::{ALBEDO, SIGMA_A, SIGMA_S, SIGMA_T};
use crate::scene::{Coefficients, ParameterInfo, VolumeParameter};

impl Rows<'_> {
    pub(super) fn coefficients(&mut self, value: &mut Coefficients) {
        match value {
            Coefficients::Extinction { sigma_t, albedo } => {
                self.volume(&SIGMA_T, sigma_t, Self::coefficient);
                self.volume(&ALBEDO, albedo, |rows, info, color| {
                    rows.edit.changed |= color_field::color(rows.ui, info, color);
                });
            }
            Coefficients::Separate { sigma_s, sigma_a } => {
                self.coefficient(&SIGMA_S, sigma_s);
                self.coefficient(&SIGMA_A, sigma_a);
            }
        }
    }

    pub(super) fn volume_emission(&mut self, info: &'static ParameterInfo, value: &mut VolumeParameter<Rgb>) {
        self.volume(info, value, |rows, info, color| {
            rows.edit.changed |= color_field::emission(rows.ui, info, info.unit, 0.0, color);
        });
    }

    pub(super) fn volume_share(&mut self, info: &'static ParameterInfo, value: &mut VolumeParameter<f32>) {
        self.volume(info, value, |rows, info, share| {
            rows.edit.changed |= fields::slider(rows.ui, info, share, info.slider_range());
        });
    }

    pub(super) fn values(&mut self, info: &'static ParameterInfo, values: &[f32]) {
        let text = format!("{} numbers", values.len());
        fields::note(self.ui, info, text);
    }

    fn coefficient(&mut self, info: &'static ParameterInfo, value: &mut Rgb) {
        if fields::vector(self.ui, info, value, 0.01, info.unit) {
            *value = value.max(Rgb::ZERO);
            self.edit.changed = true;
        }
    }

    /// A row for a value that is the same everywhere; a grid is named.
    fn volume<T>(
        &mut self,
        info: &'static ParameterInfo,
        value: &mut VolumeParameter<T>,
        row: impl FnOnce(&mut Self, &'static ParameterInfo, &mut T),
    ) {
        match value {
            VolumeParameter::Constant(value) | VolumeParameter::Box { value, .. } => row(self, info, value),
            VolumeParameter::Grid(grid) => {
                let name = grid.path.file_name().unwrap_or_default().to_string_lossy();
                fields::note(self.ui, info, name);
            }
        }
    }
}
