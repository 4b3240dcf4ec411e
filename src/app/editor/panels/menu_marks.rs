//! Entries of menus with a column of marks before their texts: a box for what is on or off, a dot for one of several
//! values and for the tool in use, the icon of a kind of thing. The row itself has a colour only below the pointer.

use bevy_egui::egui::{
    Atom, Atoms, Button, Color32, Id, IntoAtoms, Painter, Rect, Response, Stroke, StrokeKind, Ui, WidgetInfo,
    WidgetType, vec2,
};

use super::kind_icons;

/// The edge of the column in points, and that of a box in it.
const COLUMN: f32 = 16.0;
const BOX: f32 = 11.0;

/// What stands before the text of an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mark<'a> {
    /// Nothing.
    None,
    /// A box, with a tick if something is on.
    Box(bool),
    /// A circle, with a dot if the value is the chosen one.
    Dot(bool),
    /// The icon of a kind of thing.
    Icon(&'a str),
}

fn column() -> Id {
    Id::new("mark of a menu's entry")
}

/// The text of a submenu, below the texts of entries.
pub(super) fn inset<'a>(text: &'a str) -> Atoms<'a> {
    (Atom::custom(column(), vec2(COLUMN, COLUMN)), text).into_atoms()
}

/// Shows an entry with its keys.
pub(super) fn entry(ui: &mut Ui, mark: Mark, text: &str, keys: String) -> Response {
    let shown = Button::selectable(false, inset(text)).shortcut_text(keys).atom_ui(ui);
    if let Some(place) = shown.rect(column()) {
        let color = ui.style().interact(&shown.response).text_color();
        let color = ui.visuals().override_text_color.unwrap_or(color);
        paint(ui.painter(), place, mark, color);
    }
    let kind = match mark {
        Mark::Box(is_on) => Some((WidgetType::Checkbox, is_on)),
        Mark::Dot(is_on) => Some((WidgetType::RadioButton, is_on)),
        Mark::None | Mark::Icon(_) => None,
    };
    if let Some((kind, is_on)) = kind {
        let is_enabled = ui.is_enabled();
        (shown.response).widget_info(|| WidgetInfo::selected(kind, is_enabled, is_on, text));
    }
    shown.response
}

/// Shows one of several values.
pub(super) fn choice(ui: &mut Ui, is_chosen: bool, text: &str) -> Response {
    entry(ui, Mark::Dot(is_chosen), text, String::new())
}

fn paint(painter: &Painter, place: Rect, mark: Mark, color: Color32) {
    let middle = place.center();
    let faint = Stroke::new(1.0, color.gamma_multiply(0.6));
    match mark {
        Mark::None => {}
        Mark::Icon(kind) => kind_icons::paint(painter, middle, kind, color),
        Mark::Box(is_on) => {
            let frame = Rect::from_center_size(middle, vec2(BOX, BOX));
            painter.rect_stroke(frame, 2.0, faint, StrokeKind::Inside);
            if is_on {
                let tick = [(-3.0, 0.0), (-1.0, 2.5), (3.5, -3.0)].map(|(x, y)| middle + vec2(x, y));
                painter.line(tick.to_vec(), Stroke::new(1.8, color));
            }
        }
        Mark::Dot(is_on) => {
            painter.circle_stroke(middle, 0.5 * BOX - 0.5, faint);
            if is_on {
                painter.circle_filled(middle, 2.8, color);
            }
        }
    }
}
