//! The files of a folder as rows with name, size and date.

use bevy_egui::egui::text::{LayoutJob, TextWrapping};
use bevy_egui::egui::{self, Align2, FontId, Rect, ScrollArea, Sense, TextStyle, Ui, WidgetInfo, WidgetType};

use super::listing::{Column, Entry, Order, changed_text};
use crate::app::editor::words::files::size_text;

/// The entry that was clicked.
pub(super) struct Clicked {
    pub place: usize,
    /// Whether it was a double click.
    pub twice: bool,
}

/// The widths of the two last columns, in points.
const SIZE: f32 = 80.0;
const CHANGED: f32 = 130.0;
const ROW: f32 = 22.0;
/// The width of the icon of folders and files.
const MARK: f32 = 22.0;

/// Shows the entries at these indices; `scrolls`: to the selected one.
pub(super) fn show(
    ui: &mut Ui,
    height: f32,
    entries: &[Entry],
    shown: &[usize],
    chosen: Option<&str>,
    scrolls: bool,
    order: &mut Order,
) -> Option<Clicked> {
    header(ui, order);
    let mut clicked = None;
    let mut area = ScrollArea::vertical().max_height(height - ROW).auto_shrink(false);
    let at = chosen.and_then(|name| shown.iter().position(|place| entries[*place].name == name));
    if let Some(at) = at.filter(|_| scrolls) {
        let line = ROW + ui.spacing().item_spacing.y;
        area = area.vertical_scroll_offset((line * (at as f32 + 0.5) - 0.5 * height).max(0.0));
    }
    area.show_rows(ui, ROW, shown.len(), |ui, rows| {
        for place in &shown[rows] {
            let entry = &entries[*place];
            let is_chosen = chosen == Some(&entry.name);
            let response = row(ui, entry, is_chosen);
            if response.clicked() {
                let twice = response.double_clicked();
                clicked = Some(Clicked { place: *place, twice });
            }
        }
    });
    clicked
}

/// The left edges of name, size and date within a row, each with its column's right edge.
fn columns(rect: Rect) -> [egui::Rangef; 3] {
    let right = rect.right() - 8.0;
    let date = egui::Rangef::new(right - CHANGED, right);
    let size = egui::Rangef::new(date.min - SIZE, date.min - 16.0);
    [egui::Rangef::new(rect.left() + 4.0, size.min - 8.0), size, date]
}

fn header(ui: &mut Ui, order: &mut Order) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), ROW), Sense::hover());
    let names = [
        (Column::Name, "Name"),
        (Column::Size, "Size"),
        (Column::Changed, "Changed"),
    ];
    for (range, (column, name)) in columns(rect).into_iter().zip(names) {
        let place = Rect::from_x_y_ranges(range, rect.y_range());
        let response = ui.interact(place, ui.id().with(name), Sense::click());
        response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, name));
        let is_first = order.column == column;
        let color = match is_first || response.hovered() {
            true => ui.visuals().text_color(),
            false => ui.visuals().weak_text_color(),
        };
        let mark = match (is_first, order.is_reversed) {
            (false, _) => "",
            (true, false) => " ⏷",
            (true, true) => " ⏶",
        };
        let font = TextStyle::Small.resolve(ui.style());
        let (at, align) = match column {
            Column::Name => (place.left_center() + egui::vec2(4.0, 0.0), Align2::LEFT_CENTER),
            Column::Size => (place.right_center(), Align2::RIGHT_CENTER),
            Column::Changed => (place.left_center(), Align2::LEFT_CENTER),
        };
        ui.painter().text(at, align, format!("{name}{mark}"), font, color);
        if response.clicked() {
            *order = Order {
                column,
                is_reversed: is_first && !order.is_reversed,
            };
        }
    }
    let stroke = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter().hline(rect.x_range(), rect.bottom(), stroke);
}

fn row(ui: &mut Ui, entry: &Entry, is_chosen: bool) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(egui::vec2(ui.available_width(), ROW), Sense::click());
    response.widget_info(|| WidgetInfo::selected(WidgetType::SelectableLabel, true, is_chosen, &entry.name));
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let visuals = ui.visuals();
    let painter = ui.painter();
    if is_chosen {
        painter.rect_filled(rect, 3.0, visuals.selection.bg_fill);
    } else if response.hovered() {
        painter.rect_filled(rect, 3.0, visuals.widgets.hovered.weak_bg_fill);
    }
    let (text, weak) = match is_chosen {
        true => (visuals.strong_text_color(), visuals.strong_text_color()),
        false => (visuals.text_color(), visuals.weak_text_color()),
    };
    let [name, size, date] = columns(rect);
    let middle = rect.center().y;
    let mark = egui::pos2(name.min + 4.0, middle);
    if entry.is_folder {
        painter.text(mark, Align2::LEFT_CENTER, "🗀", FontId::proportional(14.0), weak);
    }
    let font = TextStyle::Body.resolve(ui.style());
    let at = egui::pos2(name.min + MARK, middle);
    let mut job = LayoutJob::simple_singleline(entry.name.clone(), font, text);
    job.wrap = TextWrapping::truncate_at_width(name.max - at.x);
    let words = ui.painter().layout_job(job);
    painter.galley(at - egui::vec2(0.0, 0.5 * words.size().y), words, text);
    let small = FontId::proportional(12.0);
    if !entry.is_folder {
        let at = egui::pos2(size.max, middle);
        painter.text(at, Align2::RIGHT_CENTER, size_text(entry.bytes), small.clone(), weak);
    }
    let at = egui::pos2(date.min, middle);
    painter.text(at, Align2::LEFT_CENTER, changed_text(entry), small, weak);
    response
}
