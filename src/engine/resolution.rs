//! The number of pixels of a picture: the film's, or as many as fit into the area where it is shown.

use bevy::math::{UVec2, Vec2};
use bevy::prelude::World;

use super::control::{Filling, Framing, RenderControl};
use crate::render::view::View;
use crate::scene::{ActiveSensor, Film};

/// The film of the camera in use.
pub fn active_film(world: &World) -> Option<&Film> {
    let sensor = world.resource::<ActiveSensor>().0?;
    world.get::<Film>(sensor)
}

/// The largest size in pixels that has the proportions of `size` and fits into `room`, rounded down and at least 1 x 1.
/// It may be larger than `size`.
pub fn fit(size: UVec2, room: UVec2) -> UVec2 {
    let size = size.max(UVec2::ONE).as_dvec2();
    let scale = (room.as_dvec2() / size).min_element();
    // A side that fills the room must not fall below it by rounding.
    (size * scale + 1e-6).floor().as_uvec2().max(UVec2::ONE)
}

/// The nearest valid size of a film, with about the same proportions.
pub(super) fn possible(size: UVec2) -> UVec2 {
    let size = size.clamp(UVec2::ONE, UVec2::splat(Film::LARGEST_SIDE));
    let pixels = f64::from(size.x) * f64::from(size.y);
    let shrink = (Film::MOST_PIXELS as f64 / pixels).sqrt().min(1.0);
    (size.as_dvec2() * shrink).as_uvec2().max(UVec2::ONE)
}

/// The requested size, before [`RenderControl::resolution_scale`]; it may be invalid for a film.
pub(super) fn asked(film: &Film, control: &RenderControl) -> UVec2 {
    let window = film.window();
    control
        .film_size_override
        .unwrap_or(UVec2::new(window.width, window.height))
}

/// The size of the picture at full resolution in pixels.
pub fn full_size(film: &Film, control: &RenderControl) -> UVec2 {
    scaled(possible(asked(film, control)), control.resolution_scale)
}

/// The framing of the picture of this film.
pub fn framing(film: &Film, control: &RenderControl) -> Framing {
    if let Some(Framing { size, extent }) = control.framing_until_change {
        let size = scaled(possible(size), control.motion_scale);
        return Framing { size, extent };
    }
    let whole = possible(asked(film, control));
    let room = control.view_size.filter(|_| !control.full_until_change);
    let (size, extent) = match room {
        Some(room) if control.filling != Filling::None => {
            let room = possible(room);
            (room, extent(whole, room))
        }
        Some(room) => (fit(whole, room).min(whole), Vec2::ONE),
        None => (whole, Vec2::ONE),
    };
    let size = scaled(size, control.resolution_scale * control.motion_scale);
    Framing { size, extent }
}

/// The framing of a picture that is the film, whatever the place that it could fill.
pub(super) fn framing_of_film(film: &Film, control: &RenderControl) -> Framing {
    let control = RenderControl {
        filling: Filling::None,
        ..control.clone()
    };
    framing(film, &control)
}

/// The width and height of `room` in widths and heights of the largest frame with the proportions of `film` that fits
/// into it.
fn extent(film: UVec2, room: UVec2) -> Vec2 {
    let ratio = room.as_dvec2() / film.as_dvec2();
    (ratio / ratio.min_element()).as_vec2()
}

fn scaled(size: UVec2, scale: f32) -> UVec2 {
    let scale = if scale.is_nan() { 1.0 } else { scale.clamp(0.0, 1.0) };
    (size.as_vec2() * scale).round().as_uvec2().max(UVec2::ONE)
}

/// Whether two views differ in nothing but the number of pixels and the surroundings of the film.
pub(super) fn is_same_at_other_size(one: &View, other: &View) -> bool {
    let resized = View {
        camera: other.camera,
        film_camera: other.film_camera,
        width: other.width,
        height: other.height,
        ..one.clone()
    };
    resized == *other && one.of_film() == other.of_film()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_are_as_large_as_they_can_be() {
        for (x, y) in [(1, 1), (65_536, 1), (65_536, 1024), (8192, 8192), (640, 480)] {
            assert!(Film::is_possible(x, y), "{x} x {y}");
            assert_eq!(possible(UVec2::new(x, y)), UVec2::new(x, y));
        }
        for (x, y) in [(0, 5), (8193, 8192), (65_537, 1), (1, u32::MAX), (u32::MAX, u32::MAX)] {
            assert!(!Film::is_possible(x, y), "{x} x {y}");
            let instead = possible(UVec2::new(x, y));
            assert!(Film::is_possible(instead.x, instead.y), "{x} x {y}: {instead}");
        }
    }

    #[test]
    fn a_picture_fills_its_place_one_way() {
        let table = [
            ((800, 600), (701, 700), (701, 525)),
            ((800, 600), (1045, 700), (933, 700)),
            ((3840, 2160), (1000, 900), (1000, 562)),
            ((100, 50_000), (300, 300), (1, 300)),
            ((7, 3), (7, 3), (7, 3)),
            ((0, 0), (5, 4), (4, 4)),
            ((5, 4), (0, 0), (1, 1)),
        ];
        for (size, room, expected) in table {
            assert_eq!(fit(size.into(), room.into()), expected.into(), "{size:?} in {room:?}");
        }
        for side in 1..2000 {
            let fitted = fit(UVec2::new(1999, 1777), UVec2::new(side, 5000));
            assert_eq!(fitted.x, side);
        }
    }

    #[test]
    fn a_picture_has_no_more_pixels_than_its_place_and_its_film() {
        let film = Film {
            width: 3840,
            height: 2160,
            ..Film::default()
        };
        let traced = |change: fn(&mut RenderControl)| {
            let mut control = RenderControl::default();
            change(&mut control);
            (framing(&film, &control).size, full_size(&film, &control))
        };
        let whole = UVec2::new(3840, 2160);
        assert_eq!(traced(|_| {}), (whole, whole));
        assert_eq!(
            traced(|control| control.view_size = Some(UVec2::new(1000, 900))),
            (UVec2::new(1000, 562), whole)
        );
        assert_eq!(
            traced(|control| control.view_size = Some(UVec2::new(5000, 5000))),
            (whole, whole)
        );
        assert_eq!(
            traced(|control| {
                control.view_size = Some(UVec2::new(1000, 900));
                control.full_until_change = true;
            }),
            (whole, whole)
        );
        assert_eq!(
            traced(|control| {
                control.framing_until_change = Some(Framing {
                    size: UVec2::new(50, 40),
                    extent: Vec2::ONE,
                });
                control.view_size = Some(UVec2::new(20, 20));
                control.resolution_scale = 0.5;
            }),
            (UVec2::new(50, 40), UVec2::new(1920, 1080))
        );
        assert_eq!(
            traced(|control| {
                control.view_size = Some(UVec2::new(1000, 900));
                control.resolution_scale = 0.5;
                control.motion_scale = 0.5;
            }),
            (UVec2::new(250, 141), UVec2::new(1920, 1080))
        );
    }

    #[test]
    fn a_view_that_is_filled_has_all_pixels_of_its_place() {
        let film = Film {
            width: 800,
            height: 600,
            ..Film::default()
        };
        let framing = |room: Option<UVec2>, change: fn(&mut RenderControl)| {
            let mut control = RenderControl {
                view_size: room,
                filling: Filling::Free,
                ..RenderControl::default()
            };
            change(&mut control);
            let Framing { size, extent } = framing(&film, &control);
            (size.to_array(), extent.to_array())
        };
        let wide = Some(UVec2::new(1600, 600));
        assert_eq!(framing(wide, |_| {}), ([1600, 600], [2.0, 1.0]));
        assert_eq!(
            framing(wide, |control| control.motion_scale = 0.25),
            ([400, 150], [2.0, 1.0])
        );
        assert_eq!(framing(Some(UVec2::new(80, 120)), |_| {}), ([80, 120], [1.0, 2.0]));
        let film_alone = ([800, 600], [1.0, 1.0]);
        assert_eq!(framing(wide, |control| control.full_until_change = true), film_alone);
        assert_eq!(framing(None, |_| {}), film_alone);
        let kept = |control: &mut RenderControl| {
            control.resolution_scale = 0.5;
            control.framing_until_change = Some(Framing {
                size: UVec2::new(523, 351),
                extent: Vec2::new(1.118, 1.0),
            });
        };
        assert_eq!(framing(wide, kept), ([523, 351], [1.118, 1.0]));
    }
}
