//! The declaration of a parameter: name, help texts and range.

use std::ops::RangeInclusive;

/// The declaration of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ParameterInfo {
    /// The name in the file.
    pub name: &'static str,
    /// The label in the panel: short enough for its column.
    pub label: &'static str,
    /// The effect, as a sentence.
    pub about: &'static str,
    /// The allowed values with their unit, in words.
    pub values: &'static str,
    /// The bounds of a number, or of the channels of a colour, unless the kind implies them.
    pub range: RangeInclusive<f32>,
    /// The narrower bounds of a slider, if it has any; numbers beyond them can be typed.
    pub offered: Option<RangeInclusive<f32>>,
    /// The default of a number that is one of several parts of a parameter; for all others the declaration of the
    /// plugin has it.
    pub usual: f32,
    /// The unit after the number in the panel.
    pub unit: &'static str,
}

impl ParameterInfo {
    /// A parameter without bounds or unit.
    pub const fn new(name: &'static str, label: &'static str, about: &'static str, values: &'static str) -> Self {
        Self {
            name,
            label,
            about,
            values,
            range: f32::MIN..=f32::MAX,
            offered: None,
            usual: 0.0,
            unit: "",
        }
    }

    /// A reflectance by colour.
    pub const fn reflectance(name: &'static str, label: &'static str, about: &'static str) -> Self {
        Self::new(name, label, about, "0 to 1 per channel, or a texture")
    }

    /// A number from 0 to 1 that may be a texture.
    pub const fn share(name: &'static str, label: &'static str, about: &'static str) -> Self {
        Self::new(name, label, about, "0 to 1, or a texture").within(0.0..=1.0)
    }

    /// A boolean parameter.
    pub const fn switch(name: &'static str, label: &'static str, about: &'static str) -> Self {
        Self::new(name, label, about, "on or off")
    }

    /// The sampling rate relative to the default.
    pub const fn sampling_rate(name: &'static str, label: &'static str, about: &'static str) -> Self {
        let values = "0 or more; 0 never, 1 as usual. The picture does not depend on it, only its noise";
        Self::new(name, label, about, values).within(0.0..=f32::MAX)
    }

    /// An angle in degrees.
    pub const fn degrees(name: &'static str, label: &'static str, about: &'static str, values: &'static str) -> Self {
        Self::new(name, label, about, values).in_units("°")
    }

    /// A factor on light.
    pub const fn factor(name: &'static str, label: &'static str, about: &'static str) -> Self {
        Self::new(name, label, about, "0 or more; 1 leaves it as it is").within(0.0..=f32::MAX)
    }

    /// Sets the bounds.
    pub const fn within(mut self, range: RangeInclusive<f32>) -> Self {
        self.range = range;
        self
    }

    /// Sets the bounds that a slider offers.
    pub const fn offering(mut self, offered: RangeInclusive<f32>) -> Self {
        self.offered = Some(offered);
        self
    }

    /// The bounds of a slider.
    pub fn slider_range(&self) -> RangeInclusive<f32> {
        self.offered.as_ref().unwrap_or(&self.range).clone()
    }

    /// The bounds of a length in a file: a length above 0 may be arbitrarily small, as tiny scenes need.
    pub fn file_range(&self) -> RangeInclusive<f32> {
        let start = *self.range.start();
        let least = if start > 0.0 { f32::MIN_POSITIVE } else { start };
        least..=*self.range.end()
    }

    /// Sets the default.
    pub const fn usually(mut self, usual: f32) -> Self {
        self.usual = usual;
        self
    }

    /// Sets the unit.
    pub const fn in_units(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }
}
