//! The text about a drag: the change so far, and the keys that act on it.

use super::constraint::Constraint;
use super::drag::{Change, Drag};
use crate::app::editor::command::gizmo_settings::Mode;
use crate::app::editor::command::snapping::SnapTo;

impl Drag {
    /// The text about the change so far, with the step of Control.
    pub fn text(&self, change: Change, length_step: f32) -> String {
        const NAMES: [&str; 3] = ["X", "Y", "Z"];
        let axes = self.frame.axes;
        let unit = self.lengths.sign();
        let amount = match change {
            Change::Moved(by) | Change::Laid { by, .. } => match self.constraint {
                Constraint::Axis(k) => format!("{} {:.4}{unit}", NAMES[k], by.dot(axes[k])),
                _ => axes
                    .iter()
                    .zip(NAMES)
                    .map(|(axis, name)| format!("{name} {:.4}{unit}  ", by.dot(*axis)))
                    .collect(),
            },
            Change::Turned { angle, .. } => match self.constraint {
                Constraint::Axis(k) | Constraint::Plane(k) => format!("{} {:.1}°", NAMES[k], angle.to_degrees()),
                Constraint::Free => format!("{:.1}°", angle.to_degrees()),
            },
            Change::Scaled(factors) => match self.constraint {
                Constraint::Axis(k) => format!("{} ×{:.3}", NAMES[k], factors[k]),
                Constraint::Plane(normal) => format!("×{:.3}, not {}", factors[(normal + 1) % 3], NAMES[normal]),
                Constraint::Free => format!("×{:.3}", factors.x),
            },
        };
        let steps = self.settings.steps;
        let rule = match (self.settings.mode, self.typed.is_empty()) {
            (_, false) => format!("typed {}", self.typed.text()),
            (Mode::Move, _) => {
                let snap = self.settings.snap;
                let free = if snap.always { "Ctrl: freely, else" } else { "Ctrl:" };
                match snap.to {
                    SnapTo::Increments => format!("{free} steps of {length_step}, Shift: onto the surface"),
                    SnapTo::Grid => format!("{free} on the grid of {length_step}, Shift: onto the surface"),
                    to => format!("{free} to {}, Shift: onto the surface", to.name()),
                }
            }
            (Mode::Rotate, _) => format!("Ctrl: steps of {}°", steps.degrees),
            (Mode::Scale, _) => format!("Ctrl: steps of {}", steps.factor),
        };
        format!("{}   {rule}", amount.trim_end())
    }
}
