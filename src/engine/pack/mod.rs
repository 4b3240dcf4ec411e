//! Turns components into the renderer's records, with plain functions, one file for each kind of record. Every check of
//! a range and every conversion of units is here, those of materials and lights in `ranges.rs`; the kernel (`render`
//! and below) trusts its numbers.

mod bsdf;
pub(super) mod environment;
pub(super) mod group;
pub(super) mod instance;
pub(super) mod light;
pub(super) mod material;
pub(super) mod medium;
pub(super) mod mtl;
mod principled;
mod ranges;
pub(super) mod surface;
pub(super) mod texture;
pub(super) mod view;

use crate::color::Rgb;
use crate::material::MaterialId;

/// The first materials of every table: for shapes without a valid material, and for lights without one.
const STAND_IN_ID: MaterialId = MaterialId(0);
const LAMP_ID: MaterialId = MaterialId(1);

/// Checks the numbers of one entity and reports the invalid ones.
pub(super) struct Checker<'a> {
    /// The name of the entity in messages to the user.
    pub name: &'a str,
    pub errors: &'a mut Vec<String>,
}

impl Checker<'_> {
    pub fn report(&mut self, text: impl std::fmt::Display) {
        self.errors.push(format!("{}: {text}", self.name));
    }

    /// `value` clamped to [low, high]; `otherwise` if it is NaN.
    pub fn number(&mut self, what: &str, value: f32, low: f32, high: f32, otherwise: f32) -> f32 {
        if value.is_nan() {
            self.report(format_args!("{what} is not a number, {otherwise} is used"));
            return otherwise;
        }
        let clamped = value.clamp(low, high);
        if clamped != value {
            self.report(format_args!("{what} is {value}, outside {low} to {high}"));
        }
        clamped
    }

    /// A colour with each component in [0, `high`]; NaN counts as 0.
    pub fn color(&mut self, what: &str, value: Rgb, high: f32) -> Rgb {
        let checked = Rgb::from_array(value.to_array().map(|component| match component {
            component if component.is_nan() => 0.0,
            // Adding zero makes -0 the 0 it is equal to.
            component => component.clamp(0.0, high) + 0.0,
        }));
        if checked != value {
            self.report(format_args!("{what} is {value}, outside 0 to {high}"));
        }
        checked
    }

    pub fn reflectance(&mut self, what: &str, value: Rgb) -> Rgb {
        self.color(what, value, 1.0)
    }
}
