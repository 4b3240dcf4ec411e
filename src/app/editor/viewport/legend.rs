//! Shows the meaning of the picture's colours at its lower right.

use bevy_egui::egui::{self, Align2, Color32, FontId, Painter, Rect, lerp, pos2, vec2};

use super::marks::BACKING;
use crate::app::editor::picture::legend::{Legend, Ramp};

/// The size of the texts, in points.
const SIZE: f32 = 12.0;
/// The size of the bar of a ramp, in points.
const BAR: egui::Vec2 = vec2(180.0, 12.0);
/// The margins of the bar for the numbers, in points.
const MARGIN: egui::Vec2 = vec2(48.0, 8.0);
/// The height of a line of words, and the width of all lines, in points.
const LINE: egui::Vec2 = vec2(108.0, 18.0);

/// The gap to the corner of the picture, in points.
const GAP: egui::Vec2 = vec2(8.0, 6.0);

/// The height of a legend at the foot of the picture, in points.
pub(crate) fn height(legend: &Legend) -> f32 {
    GAP.y + size(legend).y
}

/// The place of a legend in the window.
pub(crate) fn place(picture: Rect, legend: &Legend) -> Rect {
    let size = size(legend);
    Rect::from_min_size(picture.right_bottom() - size - GAP, size)
}

fn size(legend: &Legend) -> egui::Vec2 {
    match legend {
        Legend::Ramp { .. } => BAR + 2.0 * MARGIN,
        Legend::Words(words) => vec2(LINE.x, LINE.y * words.len() as f32 + 6.0),
    }
}

pub(crate) fn paint(painter: &Painter, picture: Rect, legend: &Legend) {
    let back = place(picture, legend);
    painter.rect_filled(back, 3.0, BACKING);
    match legend {
        Legend::Ramp { ramp, low, high } => paint_ramp(painter, back.shrink2(MARGIN), *ramp, low, high),
        Legend::Words(words) => paint_words(painter, back, words),
    }
}

fn paint_ramp(painter: &Painter, bar: Rect, ramp: Ramp, low: &str, high: &str) {
    let strips = 60;
    for strip in 0..strips {
        let (from, to) = (strip as f32 / strips as f32, (strip + 1) as f32 / strips as f32);
        let [r, g, b] = ramp.color(0.5 * (from + to)).map(|c| (255.0 * c) as u8);
        let rect = Rect::from_x_y_ranges(lerp(bar.x_range(), from)..=lerp(bar.x_range(), to), bar.y_range());
        painter.rect_filled(rect, 0.0, Color32::from_rgb(r, g, b));
    }
    let font = FontId::proportional(SIZE);
    let gap = vec2(5.0, 0.0);
    for (place, align, text) in [
        (bar.left_center() - gap, Align2::RIGHT_CENTER, low),
        (bar.right_center() + gap, Align2::LEFT_CENTER, high),
    ] {
        painter.text(place, align, text, font.clone(), Color32::WHITE);
    }
}

fn paint_words(painter: &Painter, back: Rect, words: &[([u8; 3], &str)]) {
    for (place, ([r, g, b], text)) in words.iter().enumerate() {
        let middle = back.top() + 3.0 + (place as f32 + 0.5) * LINE.y;
        let swatch = Rect::from_center_size(pos2(back.left() + 14.0, middle), egui::Vec2::splat(11.0));
        painter.rect_filled(swatch, 2.0, Color32::from_rgb(*r, *g, *b));
        let at = pos2(back.left() + 26.0, middle);
        painter.text(
            at,
            Align2::LEFT_CENTER,
            *text,
            FontId::proportional(SIZE),
            Color32::WHITE,
        );
    }
}
