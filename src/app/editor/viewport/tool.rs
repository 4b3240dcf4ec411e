//! The tools of the viewport: a tool gets keys and mouse first, and paints over the picture.

use bevy_egui::egui::{Painter, Pos2, Rect, Response, Ui};

use super::blocking::BlockingState;
use super::gizmo::interaction::{GizmoState, Rest};
use super::model::ViewportModel;
use super::state::ViewportState;
use super::texturing::{self, TexturingState};
use super::{cut_handle, legend};
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::Command;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::input::press::Press;

/// A tool of the viewport. Kinds of tools with one state share an implementor.
pub(super) trait ViewportTool {
    /// Follows mouse and keys for a frame. Returns the input that the tool does not use.
    fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &ViewportModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest;

    /// Paints the tool over the picture.
    fn paint(&self, painter: &Painter, screen: &Screen, model: &ViewportModel, pointer: Option<Pos2>);

    /// The hint about the next step, in place of the tool's usual one.
    fn hint(&self, _model: &ViewportModel) -> Option<String> {
        None
    }

    /// Shows the tool's bar at the foot of the picture.
    fn bar(&mut self, _ui: &mut Ui, _picture: Rect, _model: &ViewportModel, _commands: &mut Vec<Command>) {}
}

/// The gizmo, which stays usable with the tools that only click.
impl ViewportTool for GizmoState {
    fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &ViewportModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest {
        self.follow_handles(ui, response, screen, &model.gizmo, presses, commands)
    }

    fn paint(&self, painter: &Painter, screen: &Screen, model: &ViewportModel, pointer: Option<Pos2>) {
        self.paint_handles(painter, screen, &model.gizmo, pointer);
    }
}

/// The tools that draw, push and cut blocks.
impl ViewportTool for BlockingState {
    fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &ViewportModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest {
        self.follow_blocks(ui, response, screen, &model.blocking(), presses, commands)
    }

    fn paint(&self, painter: &Painter, screen: &Screen, model: &ViewportModel, _pointer: Option<Pos2>) {
        self.paint_blocks(painter, screen, &model.blocking());
    }

    fn hint(&self, model: &ViewportModel) -> Option<String> {
        self.next_step(&model.blocking())
    }
}

/// The tool that places textures.
impl ViewportTool for TexturingState {
    fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &ViewportModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest {
        self.follow_tile(ui, response, screen, &model.texturing(), presses, commands)
    }

    fn paint(&self, painter: &Painter, screen: &Screen, model: &ViewportModel, pointer: Option<Pos2>) {
        self.paint_tile(painter, screen, &model.texturing(), pointer);
    }

    fn bar(&mut self, ui: &mut Ui, picture: Rect, model: &ViewportModel, commands: &mut Vec<Command>) {
        let cut = model.keys.seeing.cut.map_or(0.0, |_| cut_handle::BAR_HEIGHT + 6.0);
        let foot = cut.max(model.legend.map_or(0.0, legend::height));
        texturing::bar(ui, picture, foot, &model.texturing(), self, commands);
    }
}

impl ViewportState {
    /// The tool in use.
    pub(super) fn tool(&self, tool: Tool) -> &dyn ViewportTool {
        match tool {
            Tool::Draw(_) | Tool::Push | Tool::Cut(_) => &self.blocking,
            Tool::PlaceTexture => &self.texturing,
            Tool::PaintLight => &self.light_brush,
            Tool::Select | Tool::Focus | Tool::Region | Tool::Paths | Tool::Ruler => &self.gizmo,
        }
    }

    /// The tool in use.
    pub(super) fn tool_mut(&mut self, tool: Tool) -> &mut dyn ViewportTool {
        match tool {
            Tool::Draw(_) | Tool::Push | Tool::Cut(_) => &mut self.blocking,
            Tool::PlaceTexture => &mut self.texturing,
            Tool::PaintLight => &mut self.light_brush,
            Tool::Select | Tool::Focus | Tool::Region | Tool::Paths | Tool::Ruler => &mut self.gizmo,
        }
    }

    /// Ends the actions of the tools that are not in use.
    pub(super) fn leave_other_tools(&mut self, tool: Tool) {
        if !tool.blocks_out() {
            self.blocking.leave();
        }
        if tool != Tool::PlaceTexture {
            self.texturing.leave();
        }
        if tool != Tool::PaintLight {
            self.light_brush.leave();
        }
    }
}
