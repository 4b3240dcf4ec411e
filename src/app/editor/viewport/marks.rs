//! Texts and frames that are legible on any picture.

use bevy_egui::egui::{self, Align2, Color32, CornerRadius, FontId, Frame, Margin, Pos2, Rect, Stroke, Ui, Vec2};

/// The background of texts over the picture: white texts are legible on it whatever is behind.
pub(crate) const BACKING: Color32 = Color32::from_black_alpha(228);

/// The least distance of long texts from the edges of the picture, in points.
const EDGE: f32 = 16.0;

/// A white frame with black around it, which is visible on any picture.
pub(crate) fn thin_frame(painter: &egui::Painter, rect: Rect, alpha: u8) {
    for (width, color) in [
        (3.0, Color32::from_black_alpha(alpha)),
        (1.0, Color32::from_white_alpha(alpha)),
    ] {
        painter.rect_stroke(rect, 0.0, Stroke::new(width, color), egui::StrokeKind::Middle);
    }
}

/// The frame of a bar, in the theme's colour. It is nearly opaque, so that texts and buttons on it are legible over any
/// picture.
pub(crate) fn bar_frame(ui: &Ui, margin: Margin) -> Frame {
    Frame::new()
        .fill(ui.visuals().window_fill.gamma_multiply_u8(238))
        .stroke(ui.visuals().window_stroke)
        .corner_radius(CornerRadius::same(4))
        .inner_margin(margin)
}

/// A text that can be read on any picture.
pub(crate) fn tag(painter: &egui::Painter, corner: Pos2, align: Align2, text: &str) -> Rect {
    tag_at(painter, text, |size| align.anchor_size(corner, size))
}

/// A tag below and to the right of a point, moved so far that all of it is in the picture.
pub(crate) fn tag_beside(painter: &egui::Painter, corner: Pos2, text: &str) {
    tag_at(painter, text, |size| {
        inside(Rect::from_min_size(corner, size), painter.clip_rect())
    });
}

/// A tag in the rectangle that `place` gives for its size.
fn tag_at(painter: &egui::Painter, text: &str, place: impl FnOnce(Vec2) -> Rect) -> Rect {
    let width = (painter.clip_rect().width() - 2.0 * EDGE).max(EDGE);
    let layout = painter.layout(
        text.to_owned(),
        FontId::proportional(12.5),
        Color32::from_gray(230),
        width,
    );
    let rect = place(layout.size() + egui::vec2(12.0, 6.0));
    painter.rect_filled(rect, 3.0, BACKING);
    painter.galley(rect.min + egui::vec2(6.0, 3.0), layout, Color32::WHITE);
    rect
}

/// The rectangle moved into another one, as far as it fits.
fn inside(rect: Rect, room: Rect) -> Rect {
    let shift = (room.max - rect.max).min(Vec2::ZERO).max(room.min - rect.min);
    rect.translate(shift)
}

/// Tags beside things in the picture, without overlaps. Tags that are partly outside are moved into the picture.
#[derive(Debug, Default)]
pub(crate) struct Tags {
    taken: Vec<Rect>,
}

/// The least distance between two tags, in points.
const BETWEEN: f32 = 2.0;

impl Tags {
    /// Shows a text with its middle as near to this place as there is room above or below.
    pub(crate) fn tag(&mut self, painter: &egui::Painter, middle: Pos2, text: &str) {
        let room = painter.clip_rect();
        let rect = tag_at(painter, text, |size| {
            self.free(Rect::from_center_size(middle, size), room)
        });
        self.taken.push(rect);
    }

    /// The free rectangle in the picture nearest to the wanted one, above or below it.
    fn free(&self, wanted: Rect, picture: Rect) -> Rect {
        // A tag outside the picture is not moved into it.
        let room = match picture.intersects(wanted) {
            true => picture,
            false => Rect::EVERYTHING,
        };
        let wanted = inside(wanted, room);
        let column = wanted.expand2(egui::vec2(BETWEEN, f32::INFINITY));
        let beside = || self.taken.iter().filter(|taken| taken.intersects(column));
        let is_free = |place: &Rect| {
            room.contains_rect(*place) && beside().all(|taken| !taken.expand(0.5 * BETWEEN).intersects(*place))
        };
        let at = |top: f32| wanted.translate(egui::vec2(0.0, top - wanted.top()));
        let next_to = beside().flat_map(|taken| [taken.top() - BETWEEN - wanted.height(), taken.bottom() + BETWEEN]);
        let places = std::iter::once(wanted).chain(next_to.map(at)).filter(is_free);
        let distance = |place: &Rect| (place.top() - wanted.top()).abs();
        places
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap_or(wanted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_tag_lies_over_another() {
        let mut tags = Tags::default();
        let size = egui::vec2(60.0, 20.0);
        let wanted = [
            (100.0, 100.0),
            (110.0, 104.0),
            (90.0, 97.0),
            (100.0, 100.0),
            (300.0, 100.0),
            (130.0, 125.0),
        ];
        for (x, y) in wanted {
            let wanted = Rect::from_center_size(Pos2::new(x, y), size);
            let place = tags.free(wanted, Rect::EVERYTHING);
            assert!(tags.taken.iter().all(|taken| !taken.intersects(place)), "{place:?}");
            assert_eq!(place.center().x, x);
            assert!((place.center().y - y).abs() <= 2.0 * (size.y + BETWEEN), "{place:?}");
            tags.taken.push(place);
        }
        assert_eq!(tags.taken[0].center(), Pos2::new(100.0, 100.0));
        assert_eq!(tags.taken[4].center(), Pos2::new(300.0, 100.0), "nothing is there");
        // It moves to the nearer side.
        assert!(tags.taken[1].center().y > 104.0 && tags.taken[2].center().y < 97.0);
    }

    #[test]
    fn tags_are_brought_into_the_picture() {
        let picture = Rect::from_min_size(Pos2::new(100.0, 50.0), egui::vec2(400.0, 300.0));
        let size = egui::vec2(60.0, 20.0);
        let mut tags = Tags::default();
        for (x, y) in [
            (105.0, 200.0),
            (495.0, 55.0),
            (300.0, 345.0),
            (300.0, 349.0),
            (310.0, 348.0),
        ] {
            let place = tags.free(Rect::from_center_size(Pos2::new(x, y), size), picture);
            assert!(picture.contains_rect(place), "{place:?}");
            assert!(tags.taken.iter().all(|taken| !taken.intersects(place)), "{place:?}");
            tags.taken.push(place);
        }
        let wide = Rect::from_center_size(Pos2::new(300.0, 200.0), egui::vec2(600.0, 20.0));
        assert_eq!(
            tags.free(wide, picture).left(),
            picture.left(),
            "it begins in the picture"
        );
        let beyond = Rect::from_center_size(Pos2::new(300.0, 900.0), size);
        assert_eq!(tags.free(beyond, picture), beyond);
    }
}
