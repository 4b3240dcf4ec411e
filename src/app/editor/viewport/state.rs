//! The state that the viewport keeps between frames.

use std::time::Duration;

use bevy::math::UVec2;
use bevy::prelude::Resource;
use bevy_egui::egui::{Rect, Ui};

use super::axes_widget::AxesState;
use super::blocking::BlockingState;
use super::blocking::grips::GripState;
use super::gizmo::interaction::GizmoState;
use super::light_brush::LightBrushState;
use super::path_grips::PathGripState;
use super::pointer::PointerState;
use super::side_model::{COUNT, PaneState};
use super::texturing::TexturingState;
use crate::app::editor::camera::walking::Gait;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::{Command, DisplayCommand};

/// The state that the viewport keeps between frames.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ViewportState {
    /// The state of the handles.
    pub gizmo: GizmoState,
    /// The state of the tools that block out.
    pub blocking: BlockingState,
    /// The state of the handles of openings.
    pub grips: GripState,
    /// The state of the handles of the points of a path.
    pub path_grips: PathGripState,
    /// The state of the tool that places textures.
    pub texturing: TexturingState,
    /// The state of the brush for light.
    pub light_brush: LightBrushState,
    /// The state of the mouse.
    pub pointer: PointerState,
    /// The size of the picture's panel in pixels when it was last shown.
    pub room: Option<UVec2>,
    pub(super) axes: AxesState,
    /// The size of the picture on the screen; None while there is no picture.
    pub picture: Option<ScreenPixels>,
    /// The view that has the mouse.
    pub panes: PaneState,
    /// The sizes of the side views; None while they are not shown.
    pub sides: Option<[ScreenPixels; COUNT]>,
    /// The place of the bar over a paused picture, if there is one.
    pub bar: Option<Rect>,
    /// The place in the picture that the pointer is at, (0, 0) top left, (1, 1) bottom right; None outside of it.
    pub pointed: Option<bevy::math::Vec2>,
    /// The place of the legend of false colours, if there is one.
    pub legend: Option<Rect>,
    /// Whether the picture is in headlight mode because of a drag.
    is_in_headlight: bool,
    pub(super) flying: bool,
    /// The motion of the walking body.
    pub(super) gait: Gait,
    pub(super) speed: SpeedTag,
}

impl ViewportState {
    /// The state at the start. Without a user nothing is hovered, since the window opens at an arbitrary pointer.
    pub fn new(is_attended: bool) -> Self {
        let mut state = Self::default();
        state.pointer.is_unattended = !is_attended;
        state
    }

    /// Shows the picture in headlight mode during drags, if preferred.
    pub fn light_drags(&mut self, is_wanted: bool, display: DisplaySettings, commands: &mut Vec<Command>) {
        let (from, to) = match self.is_in_headlight {
            false if is_wanted && self.gizmo.is_moving() => (DisplayMode::Shaded, DisplayMode::Headlight),
            true if !self.gizmo.is_dragging() => (DisplayMode::Headlight, DisplayMode::Shaded),
            _ => return,
        };
        // Another display mode that is chosen during the drag stays.
        if display.mode == from {
            commands.push(DisplayCommand::SetDisplay(DisplaySettings { mode: to, ..display }).into());
        }
        self.is_in_headlight = from == DisplayMode::Shaded && display.mode == from;
    }
}

/// The size of the picture on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenPixels {
    /// Width and height in pixels of the screen.
    pub size: UVec2,
    /// Pixels of the screen for each point of the window.
    pub per_point: f32,
}

impl ScreenPixels {
    /// The size of a rectangle of the window, at least one pixel.
    pub(super) fn of(ui: &Ui, place: Rect) -> Self {
        let per_point = ui.ctx().pixels_per_point();
        let size = (place.size() * per_point).round();
        Self {
            size: UVec2::new(size.x as u32, size.y as u32).max(UVec2::ONE),
            per_point,
        }
    }
}

/// The speed of flying, which is shown for a while after a change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SpeedTag {
    /// The speed of the last frame; None before the first.
    known: Option<f32>,
    /// The time at which the tag disappears, in seconds of egui's clock.
    until: f64,
}

/// Seconds that the speed stays on the picture after flying, and after it was set.
const SPEED_STAYS: f64 = 1.5;

impl SpeedTag {
    pub(super) fn follow(&mut self, ui: &Ui, flying: bool, speed: f32) {
        let now = ui.input(|input| input.time);
        let is_set = self.known.is_some_and(|known| known != speed);
        self.known = Some(speed);
        if flying || is_set {
            self.until = now + SPEED_STAYS;
        }
        if self.is_shown(ui) {
            ui.ctx()
                .request_repaint_after(Duration::from_secs_f64(self.until - now));
        }
    }

    pub(super) fn is_shown(&self, ui: &Ui) -> bool {
        self.known.is_some() && ui.input(|input| input.time) < self.until
    }
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::{__run_test_ui, Pos2, vec2};

    use super::*;

    #[test]
    fn a_picture_has_at_least_one_pixel() {
        for (points, expected) in [
            (vec2(30.0, 0.2), UVec2::new(30, 1)),
            (vec2(-3.0, 7.0), UVec2::new(1, 7)),
        ] {
            let mut found = None;
            __run_test_ui(|ui| found = Some(ScreenPixels::of(ui, Rect::from_min_size(Pos2::ZERO, points)).size));
            assert_eq!(found, Some(expected));
        }
    }
}
