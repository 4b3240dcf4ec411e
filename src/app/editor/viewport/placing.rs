//! The places of the film's frame and of the picture in the panel.
//!
//! A picture that was rendered for another frame, as before a resize of the window, is aligned by the frame of the
//! film, so that things stay where they are.

use bevy::math::{UVec2, Vec2};
use bevy_egui::egui::{Pos2, Rect, vec2};

use crate::engine::fit;
use crate::render::view::View;

/// The place in the panel of a picture of this view, on whole pixels so that the pixels of the picture stay sharp: the
/// whole panel, if the view was framed for it. `film` has the proportions of the film.
pub(super) fn place_of_view(panel: Rect, pixels_per_point: f32, film: UVec2, view: Option<&View>) -> Rect {
    let room = pixels_of(panel, pixels_per_point);
    let size = match view.filter(|view| view.film_camera.is_some()) {
        None => fit(film, room),
        Some(view) => {
            let fitted = room.as_vec2() / view.camera.half_extent();
            // The proportions of a frame that was made for this room differ by rounding only.
            match (fitted.x / fitted.y - 1.0).abs() < 1e-4 {
                true => return panel,
                false => (view.camera.half_extent() * fitted.min_element())
                    .as_uvec2()
                    .max(UVec2::ONE),
            }
        }
    };
    let size = vec2(size.x as f32, size.y as f32);
    let corner = panel.center().to_vec2() * pixels_per_point - 0.5 * size;
    Rect::from_min_size((corner.floor() / pixels_per_point).to_pos2(), size / pixels_per_point)
}

/// The place of a picture with these [corners](View::film_corners) of the film, where the view at `place` has the
/// corners `of_view`.
pub(super) fn place_of_picture(place: Rect, of_view: [Vec2; 2], of_picture: [Vec2; 2]) -> Rect {
    if of_view == of_picture {
        return place;
    }
    let to_view = |corner: Vec2| {
        let film = (corner - of_picture[0]) / (of_picture[1] - of_picture[0]);
        at(place, of_view[0] + film * (of_view[1] - of_view[0]))
    };
    Rect::from_min_max(to_view(Vec2::ZERO), to_view(Vec2::ONE))
}

/// The point of a place with these coordinates, (0, 0) top left, (1, 1) bottom right.
pub(super) fn at(place: Rect, coordinates: Vec2) -> Pos2 {
    place.min + place.size() * vec2(coordinates.x, coordinates.y)
}

/// The whole pixels of a rectangle.
pub(super) fn pixels_of(panel: Rect, pixels_per_point: f32) -> UVec2 {
    let size = panel.size() * pixels_per_point;
    UVec2::new(size.x.max(1.0) as u32, size.y.max(1.0) as u32)
}

/// The place of the film in the panel, given the place of a picture of this view.
pub(super) fn place_of_film(place: Rect, of_view: [Vec2; 2]) -> Rect {
    Rect::from_min_max(at(place, of_view[0]), at(place, of_view[1]))
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::pos2;

    use super::*;

    #[test]
    fn pictures_of_other_frames_are_aligned_by_the_film() {
        let panel = Rect::from_min_size(pos2(10.0, 20.0), vec2(800.0, 400.0));
        // The view is twice as wide as the film, whose middle half of the panel is (210, 20) to (610, 420).
        let wide = [Vec2::new(0.25, 0.0), Vec2::new(0.75, 1.0)];
        let film = Rect::from_min_size(pos2(210.0, 20.0), vec2(400.0, 400.0));
        assert_eq!(place_of_film(panel, wide), film);
        assert_eq!(place_of_picture(panel, wide, View::WHOLE_FILM), film);
        assert_eq!(place_of_picture(panel, wide, wide), panel);
        assert_eq!(place_of_picture(film, View::WHOLE_FILM, wide), panel);
    }

    #[test]
    fn a_film_is_shown_whole_in_the_middle() {
        let panel = Rect::from_min_size(pos2(0.0, 0.0), vec2(1045.0, 700.0));
        let place = place_of_view(panel, 1.0, UVec2::new(800, 600), None);
        assert_eq!(place, Rect::from_min_size(pos2(56.0, 0.0), vec2(933.0, 700.0)));
    }
}
