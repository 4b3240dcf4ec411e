//! The form for a series of copies: along a line or around an axis.

use bevy::math::Vec3;
use bevy_egui::egui::{self, Ui};

use super::{fields, lengths, look};
use crate::app::editor::command::arrange::{LONGEST_SERIES, Series, Way};
use crate::app::editor::command::{Command, SceneEdit};

/// The entries so far. They stay while the window is open.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesForm {
    count: u32,
    is_ring: bool,
    instances: bool,
    /// The step; None for one that suits the selection.
    step: Option<Vec3>,
    axis: usize,
    degrees: f32,
    /// The center of the ring; None for the origin of the world.
    center: Vec3,
}

impl Default for SeriesForm {
    fn default() -> Self {
        Self {
            count: 5,
            is_ring: false,
            instances: false,
            step: None,
            axis: 1,
            degrees: 360.0,
            center: Vec3::ZERO,
        }
    }
}

/// Shows the form. `suggested` is a step that suits the selection, in world units. Returns true when the form is to be
/// closed.
pub fn series(ui: &mut Ui, form: &mut SeriesForm, suggested: Vec3, commands: &mut Vec<Command>) -> bool {
    ui.horizontal(|ui| {
        ui.selectable_value(&mut form.is_ring, false, "Along a line");
        ui.selectable_value(&mut form.is_ring, true, "Around an axis");
    });
    fields::integer(ui, "Count", &mut form.count, 2..=LONGEST_SERIES);
    let speed = 0.01 * suggested.abs().max_element().max(1e-3);
    if form.is_ring {
        fields::choice(ui, "Axis", &mut form.axis, &[(0, "X"), (1, "Y"), (2, "Z")]);
        fields::quantity(ui, "Angle", &mut form.degrees, 1.0, -3600.0..=3600.0, "°");
        lengths::vector(ui, "Center", &mut form.center, speed);
    } else {
        let mut step = form.step.unwrap_or(suggested);
        if lengths::vector(ui, "Step", &mut step, speed) {
            form.step = Some(step);
        }
    }
    fields::checkbox(ui, "Instances", &mut form.instances);
    ui.add(
        egui::Label::new(
            egui::RichText::new("Instances share one group of shapes: a change of it changes all.").weak(),
        )
        .wrap(),
    );
    ui.add_space(6.0);
    let (makes, cancels) = look::form_buttons(ui, "Make", "Adds the copies of what is selected");
    if makes {
        commands.push(SceneEdit::MakeSeries(form.series(suggested)).into());
    }
    makes || cancels
}

impl SeriesForm {
    /// The series that *Make* would make. `suggested` is as in [`series`].
    pub fn series(&self, suggested: Vec3) -> Series {
        Series {
            count: self.count,
            way: match self.is_ring {
                true => Way::Around {
                    axis: self.axis,
                    degrees: self.degrees,
                    center: self.center,
                },
                false => Way::Along(self.step.unwrap_or(suggested)),
            },
            instances: self.instances,
        }
    }
}
