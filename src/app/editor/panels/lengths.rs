//! Fields for lengths: numbers in the unit of the scene, into which other units may be typed (`2m`, `30cm`, `6'`,
//! `4in`).

use std::ops::RangeInclusive;

use bevy::math::Vec3;
use bevy_egui::egui::{Ui, UiBuilder, UiStackInfo};

use super::caption::Caption;
use super::fields::{self, NumberStyle};
use crate::scene::LengthUnit;

/// The tag of a part of a panel that has the unit of the scene.
const SCENE_UNIT: &str = "unit of the scene";
/// The tag of a part of a panel whose numbers are lengths.
const LENGTHS: &str = "lengths";

/// Sets the unit of the scene for the fields of `content`.
pub fn in_unit<R>(ui: &mut Ui, unit: LengthUnit, content: impl FnOnce(&mut Ui) -> R) -> R {
    tagged(ui, SCENE_UNIT, unit, content)
}

fn tagged<R>(ui: &mut Ui, tag: &'static str, unit: LengthUnit, content: impl FnOnce(&mut Ui) -> R) -> R {
    let info = UiStackInfo::default().with_tag_value(tag, unit);
    ui.scope_builder(UiBuilder::new().ui_stack_info(info), content).inner
}

fn tag(ui: &Ui, tag: &str) -> Option<LengthUnit> {
    ui.stack().iter().find_map(|ui| ui.tags().get_downcast(tag).copied())
}

/// The unit of the scene that the panel shows.
pub(crate) fn unit(ui: &Ui) -> LengthUnit {
    tag(ui, SCENE_UNIT).unwrap_or_default()
}

/// Shows fields whose numbers are lengths.
fn lengths<R>(ui: &mut Ui, content: impl FnOnce(&mut Ui) -> R) -> R {
    let unit = unit(ui);
    tagged(ui, LENGTHS, unit, content)
}

/// The unit of the numbers in this part of the panel; None if they are no lengths.
pub(super) fn length_unit(ui: &Ui) -> Option<LengthUnit> {
    tag(ui, LENGTHS)
}

/// Shows a length with its unit; returns true if edited.
pub fn length<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut f32,
    speed: f32,
    range: RangeInclusive<f32>,
) -> bool {
    let suffix = unit(ui).sign();
    lengths(ui, |ui| fields::quantity(ui, caption, value, speed, range, &suffix))
}

/// Shows a length on a slider whose steps are even in the exponent; returns true if edited.
pub(crate) fn length_slider<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut f32,
    range: RangeInclusive<f32>,
) -> bool {
    lengths(ui, |ui| fields::log_slider(ui, caption, value, range))
}

/// Shows several lengths side by side; returns true if edited.
pub(super) fn numbers<'a, const N: usize>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    values: &mut [f32; N],
    styles: [NumberStyle; N],
) -> bool {
    lengths(ui, |ui| fields::numbers(ui, caption, values, styles))
}

/// Shows three lengths; returns true if edited.
pub fn vector<'a>(ui: &mut Ui, caption: impl Into<Caption<'a>>, value: &mut Vec3, speed: f32) -> bool {
    lengths(ui, |ui| fields::vector(ui, caption, value, speed, ""))
}
