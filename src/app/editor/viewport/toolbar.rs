//! The buttons above the picture: what the gizmo does, along which axes, about which point, in which steps.

use bevy_egui::egui::{
    self, Align, Button, Color32, ComboBox, CornerRadius, DragValue, Frame, Layout, Margin, Rect, Ui, UiBuilder,
};

use super::snap_menu::snap_menu;
use crate::app::editor::command::Command;
use crate::app::editor::command::gizmo_settings::{Axes, DEGREES, FACTORS, GizmoSettings, LENGTHS, Mode, Pivot, Steps};

const HEIGHT: f32 = 30.0;
const WIDTH: f32 = 590.0;

/// Shows the toolbar. `length_step` is the step of lengths in use, in world units.
pub(crate) fn toolbar(
    ui: &mut Ui,
    panel: Rect,
    settings: GizmoSettings,
    length_step: f32,
    commands: &mut Vec<Command>,
) {
    let size = egui::vec2(WIDTH.min(panel.width() - 16.0), HEIGHT);
    let place = Rect::from_min_size(panel.center_top() + egui::vec2(-0.5 * size.x, 6.0), size);
    let mut edited = settings;
    let layout = Layout::left_to_right(Align::Center);
    let mut bar = ui.new_child(UiBuilder::new().id_salt("gizmo toolbar").max_rect(place).layout(layout));
    bar.set_clip_rect(panel);
    let frame = Frame::new()
        .fill(backing(&bar))
        .stroke(bar.visuals().window_stroke)
        .corner_radius(CornerRadius::same(4))
        .inner_margin(Margin::symmetric(6, 3));
    frame.show(&mut bar, |ui| {
        for (mode, name, help) in [
            (Mode::Move, "Move", "Move (G)"),
            (Mode::Rotate, "Rotate", "Rotate (R)"),
            (Mode::Scale, "Scale", "Scale along the object's own axes (T)"),
        ] {
            let button = Button::selectable(settings.mode == mode, name);
            if ui.add(button).on_hover_text(help).clicked() {
                edited.mode = mode;
            }
        }
        ui.separator();
        let (name, other) = match settings.axes {
            Axes::World => ("World", Axes::Local),
            Axes::Local => ("Local", Axes::World),
        };
        let help = "Whose axes the handles are along: the world's or the active object's (X)";
        if ui
            .add_enabled(settings.mode != Mode::Scale, Button::new(name))
            .on_hover_text(help)
            .clicked()
        {
            edited.axes = other;
        }
        let chosen = Pivot::ALL
            .iter()
            .find(|(pivot, _)| *pivot == settings.pivot)
            .map_or("", |(_, name)| name);
        ComboBox::from_id_salt("pivot")
            .width(96.0)
            .selected_text(chosen)
            .show_ui(ui, |ui| {
                for (pivot, name) in Pivot::ALL {
                    ui.selectable_value(&mut edited.pivot, pivot, name);
                }
            })
            .response
            .on_hover_text("The point that things turn and grow about");
        ui.separator();
        snap_menu(ui, &mut edited.snap);
        step(ui, &mut edited, length_step);
    });
    if edited != settings {
        commands.push(Command::SetGizmo(edited));
    }
}

/// The background in the theme's colour. It is nearly opaque, so that texts and buttons on it are legible over any picture.
fn backing(ui: &Ui) -> Color32 {
    ui.visuals().window_fill.gamma_multiply_u8(238)
}

/// The step of the mode.
fn step(ui: &mut Ui, edited: &mut GizmoSettings, length_step: f32) {
    ui.label("Step");
    let steps = &mut edited.steps;
    let mut length = length_step;
    let (value, speed, range, suffix) = match edited.mode {
        Mode::Move => (&mut length, 0.02 * length_step, LENGTHS, ""),
        Mode::Rotate => (&mut steps.degrees, 0.5, DEGREES, "°"),
        Mode::Scale => (&mut steps.factor, 0.01, FACTORS, ""),
    };
    let drag = DragValue::new(value)
        .speed(speed)
        .range(range)
        .suffix(suffix)
        .max_decimals(4);
    let response = ui.add(drag).on_hover_text(
        "What Control rounds to while dragging, and how far the arrow keys go. A click with the right button: as in the beginning",
    );
    if response.secondary_clicked() {
        let usual = Steps::default();
        match edited.mode {
            Mode::Move => edited.steps.length = usual.length,
            Mode::Rotate => edited.steps.degrees = usual.degrees,
            Mode::Scale => edited.steps.factor = usual.factor,
        }
    } else if response.changed() && edited.mode == Mode::Move {
        edited.steps.length = Some(length);
    }
}
