//! The row at the foot of the picture that shows the placement of the texture in numbers.

use bevy::math::Affine2;
use bevy_egui::egui::emath::format_with_decimals_in_range;
use bevy_egui::egui::{
    Align, ComboBox, DragValue, Layout, Margin, Rect, Response, Ui, UiBuilder, WidgetInfo, WidgetType, vec2,
};

use super::{TextureTarget, TexturingModel, TexturingState};
use crate::app::editor::command::texture_placing::Placing;
use crate::app::editor::command::{Command, TextureEdit};
use crate::app::editor::input::number_field::{self, Meaning};
use crate::app::editor::viewport::marks::bar_frame;

const HEIGHT: f32 = 30.0;
/// The width before the first frame; afterwards it is the width of the fields.
const WIDTH: f32 = 560.0;

/// Shows the row if there is a texture to place. `foot` is the distance from the foot of the picture.
pub(crate) fn bar(
    ui: &mut Ui,
    picture: Rect,
    foot: f32,
    model: &TexturingModel,
    state: &mut TexturingState,
    commands: &mut Vec<Command>,
) {
    let Some(target) = model.placeable() else { return };
    let Some(group) = target.groups.get(state.chosen) else {
        return;
    };
    let size = vec2(WIDTH.min(picture.width() - 16.0), HEIGHT);
    let corner = picture.left_bottom() + vec2(8.0, -8.0 - foot - size.y);
    let layout = Layout::left_to_right(Align::Center);
    let place = Rect::from_min_size(corner, size);
    let mut bar = ui.new_child(UiBuilder::new().id_salt("texture bar").max_rect(place).layout(layout));
    let mut after = group.to_uv;
    bar_frame(&bar, Margin::symmetric(6, 3)).show(&mut bar, |ui| {
        choice(ui, target, state);
        if let Some(before) = Placing::of(&group.to_uv) {
            let mut placing = before;
            numbers(ui, &mut placing);
            if placing != before && placing.repeats.x > 0.0 && placing.repeats.y != 0.0 {
                after = placing.to_uv();
            }
        }
        if ui
            .button("Reset")
            .on_hover_text("One upright picture for each unit of u and v")
            .clicked()
        {
            after = target.upright;
        }
    });
    place_as(target, group.to_uv, after, commands);
}

fn place_as(target: &TextureTarget, before: Affine2, after: Affine2, commands: &mut Vec<Command>) {
    if after != before && after.is_finite() {
        commands.push(
            TextureEdit::PlaceTextures {
                owner: target.entity,
                before,
                after,
            }
            .into(),
        );
    }
}

/// The choice among the groups of textures.
fn choice(ui: &mut Ui, target: &TextureTarget, state: &mut TexturingState) {
    let names: Vec<String> = target.groups.iter().map(|group| group.name()).collect();
    if let [only] = &names[..] {
        ui.label(only);
        return;
    }
    let shown = names.get(state.chosen).cloned().unwrap_or_default();
    let before = state.chosen;
    ComboBox::from_id_salt("placed textures")
        .selected_text(shown)
        .width(110.0)
        .truncate()
        .show_ui(ui, |ui| {
            for (index, name) in names.iter().enumerate() {
                ui.selectable_value(&mut state.chosen, index, name);
            }
        })
        .response
        .on_hover_text("Textures that lie alike are placed together");
    if state.chosen != before {
        state.focus = None;
    }
}

fn numbers(ui: &mut Ui, placing: &mut Placing) {
    // The default field has the colour of the row.
    let field_color = ui.visuals().extreme_bg_color;
    ui.visuals_mut().widgets.inactive.weak_bg_fill = field_color;
    ui.weak("Offset");
    field(ui, "Offset U", &mut placing.offset.x, 0.005, "");
    field(ui, "Offset V", &mut placing.offset.y, 0.005, "");
    ui.weak("Rotation");
    field(ui, "Rotation", &mut placing.degrees, 0.5, "°");
    ui.weak("Repeats");
    field(ui, "Repeats U", &mut placing.repeats.x, 0.02, "");
    field(ui, "Repeats V", &mut placing.repeats.y, 0.02, "");
}

fn field(ui: &mut Ui, name: &str, value: &mut f32, speed: f64, suffix: &str) -> Response {
    let shown = f64::from(*value);
    let decimals = if suffix.is_empty() { 4 } else { 2 };
    let drag = DragValue::new(value).speed(speed).suffix(suffix).max_decimals(decimals);
    let range = f32::MIN..=f32::MAX;
    let field = number_field::number(ui, drag, name, range, Meaning::Number, format_with_decimals_in_range);
    let response = ui.add_sized([56.0, ui.spacing().interact_size.y], field);
    response.widget_info(|| {
        let mut info = WidgetInfo::drag_value(true, shown);
        info.label = Some(format!("Texture {name}"));
        info.typ = WidgetType::DragValue;
        info
    });
    response
}
