//! Texts and frames that are visible on any picture.

use bevy_egui::egui::{self, Align2, Color32, CornerRadius, FontId, Frame, Margin, Pos2, Rect, Stroke, Ui};

/// The background of texts over the picture: white texts are legible on it whatever is behind.
pub(crate) const BACKING: Color32 = Color32::from_black_alpha(228);

/// A white frame with black around it, which is visible on any picture.
pub(crate) fn thin_frame(painter: &egui::Painter, rect: Rect, alpha: u8) {
    for (width, color) in [
        (3.0, Color32::from_black_alpha(alpha)),
        (1.0, Color32::from_white_alpha(alpha)),
    ] {
        painter.rect_stroke(rect, 0.0, Stroke::new(width, color), egui::StrokeKind::Middle);
    }
}

/// The frame of a bar, in the theme's colour. It is nearly opaque, so that texts and buttons on it are legible over any picture.
pub(crate) fn bar_frame(ui: &Ui, margin: Margin) -> Frame {
    Frame::new()
        .fill(ui.visuals().window_fill.gamma_multiply_u8(238))
        .stroke(ui.visuals().window_stroke)
        .corner_radius(CornerRadius::same(4))
        .inner_margin(margin)
}

/// A text that can be read on any picture.
pub(crate) fn tag(painter: &egui::Painter, corner: Pos2, align: Align2, text: &str) -> Rect {
    let layout = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.5), Color32::from_gray(230));
    let rect = align.anchor_size(corner, layout.size() + egui::vec2(12.0, 6.0));
    painter.rect_filled(rect, 3.0, BACKING);
    painter.galley(rect.min + egui::vec2(6.0, 3.0), layout, Color32::WHITE);
    rect
}
