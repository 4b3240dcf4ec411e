//! Decides how many pixels are traced: as many of the film as the window shows, unless the user wants the full film.
//! The picture fills its place in the window, whatever the shape of the film.
//!
//! The size of the window is adopted when it has stayed the same for a moment, so that the picture does not restart at
//! every step of a resize; meanwhile the last picture is stretched.

use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy::window::PrimaryWindow;

use crate::app::editor::command::resolution::Resolution;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::{Filling, RenderControl, RenderFilm, RenderStatus, full_size};
use crate::memory;
use crate::render::film::Film;
use crate::render::layers::FilmLayers;
use crate::scene::{self, ActiveSensor, FreeView};

/// The time for which the size of the picture's panel has to stay before it is adopted.
const SETTLING: Duration = Duration::from_millis(200);
/// The time without a change after which the full film is traced, if the user wants that.
const REST: Duration = Duration::from_secs(5);
/// A film that takes more than this share of the memory budget is traced in full only if the user confirms it.
const LARGE_SHARE: f64 = 0.25;

/// The size in pixels of the panel with the picture.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct PicturePlace {
    /// The size in the last frame. None before the first, and without a window.
    room: Option<UVec2>,
    since: Option<Instant>,
    /// The adopted size.
    settled: Option<UVec2>,
}

impl PicturePlace {
    /// Notes the pixels in which the picture is shown in this frame.
    pub fn note(&mut self, room: UVec2) {
        if self.room != Some(room) {
            self.room = Some(room);
            self.since = Some(Instant::now());
        }
    }

    /// Whether the panel's size is adopted.
    pub fn is_settled(&self) -> bool {
        self.room == self.settled
    }

    /// Adopts the size: at once before there is a picture, else when it has stayed for a while.
    fn settle(&mut self, has_picture: bool, now: Instant) {
        let has_stayed = self
            .since
            .is_none_or(|since| now.saturating_duration_since(since) >= SETTLING);
        if !has_picture || has_stayed {
            self.settled = self.room;
        }
    }
}

/// Memory that the full film of a picture takes with its layers, in bytes.
pub fn full_film_bytes(size: UVec2, layers: FilmLayers) -> u64 {
    Film::memory_bytes(size.x, size.y, layers)
}

/// Whether a film of so many bytes is only traced in full after a question.
pub fn is_large(bytes: u64) -> bool {
    bytes as f64 > LARGE_SHARE * memory::budget().limit() as f64
}

/// Sets the size of the film. Runs after the commands and before the engine.
pub fn follow_place(
    mut place: ResMut<PicturePlace>,
    mut control: ResMut<RenderControl>,
    settings: Res<ViewSettings>,
    status: Res<RenderStatus>,
    film: Res<RenderFilm>,
    (active, free_view): (Res<ActiveSensor>, Res<FreeView>),
    films: Query<&scene::Film>,
    windows: Query<&Window, With<PrimaryWindow>>,
) {
    let has_picture = film.job > 0;
    place.bypass_change_detection().settle(has_picture, Instant::now());
    // The panel with the picture may be hidden behind another one.
    let whole_window = || windows.single().ok().map(Window::physical_size);
    let room = place.settled.or_else(whole_window);
    let Some(of_camera) = active.0.and_then(|sensor| films.get(sensor).ok()) else {
        return;
    };
    let full = full_size(of_camera, &control);
    let is_large = is_large(full_film_bytes(full, film.film.layers()));
    let view_size = room.filter(|_| is_large || settings.resolution != Resolution::Full);
    if control.view_size != view_size {
        control.view_size = view_size;
    }
    let is_free = *free_view != FreeView::default();
    let bytes_of_view = room.map_or(0, |room| full_film_bytes(room, film.film.layers()));
    let filling = match is_free {
        // A small film with many layers fits into the memory where a large viewport's does not.
        _ if self::is_large(bytes_of_view) => Filling::None,
        _ if settings.resolution == Resolution::Full => Filling::None,
        true => Filling::Free,
        false => Filling::AroundFilm,
    };
    if control.filling != filling {
        control.filling = filling;
    }
    let rests = status.samples > 0 && !control.paused && status.last_restart.elapsed() >= REST;
    let is_wanted =
        settings.resolution == Resolution::AfterRest && !is_large && !is_free && control.framing_until_change.is_none();
    if is_wanted && rests && place.is_settled() && !control.full_until_change && status.size != status.full_size {
        control.full_until_change = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_counts_when_it_stays() {
        let mut place = PicturePlace::default();
        let begin = Instant::now();
        assert!(place.is_settled());
        place.note(UVec2::new(800, 600));
        assert!(!place.is_settled());
        // There is no picture yet that would restart.
        place.settle(false, begin);
        assert_eq!(place.settled, Some(UVec2::new(800, 600)));
        for width in 801..900 {
            place.note(UVec2::new(width, 600));
            place.settle(true, Instant::now());
            assert_eq!(place.settled, Some(UVec2::new(800, 600)));
        }
        place.settle(true, Instant::now() + SETTLING);
        assert_eq!(place.settled, Some(UVec2::new(899, 600)));
        assert!(place.is_settled());
    }

    fn world(width: u32, height: u32, resolution: Resolution) -> World {
        let mut world = World::new();
        let film = scene::Film {
            width,
            height,
            ..Default::default()
        };
        let sensor = world.spawn((scene::Sensor::default(), film)).id();
        world.insert_resource(ActiveSensor(Some(sensor)));
        world.init_resource::<RenderControl>();
        world.init_resource::<RenderFilm>();
        world.init_resource::<RenderStatus>();
        world.init_resource::<FreeView>();
        world.insert_resource(ViewSettings {
            resolution,
            ..ViewSettings::default()
        });
        let mut place = PicturePlace::default();
        place.note(UVec2::new(1000, 700));
        world.insert_resource(place);
        world.run_system_cached(follow_place).expect("runs");
        world
    }

    #[test]
    fn large_films_are_not_traced_in_full_by_a_setting() {
        let bound = |width, height, resolution| {
            let world = world(width, height, resolution);
            let control = world.resource::<RenderControl>();
            (control.view_size, control.full_until_change)
        };
        let room = Some(UVec2::new(1000, 700));
        assert_eq!(bound(3840, 2160, Resolution::View), (room, false));
        assert_eq!(bound(64, 64, Resolution::Full), (None, false));
        let mut side = 1024;
        while !is_large(full_film_bytes(UVec2::splat(side), FilmLayers::default())) {
            side *= 2;
        }
        for resolution in [Resolution::Full, Resolution::AfterRest] {
            assert_eq!(bound(side, side, resolution), (room, false), "{resolution:?}");
        }
    }

    #[test]
    fn the_full_film_is_traced_after_a_rest_if_that_is_wanted() {
        for resolution in [Resolution::View, Resolution::AfterRest] {
            let mut world = world(640, 480, resolution);
            {
                let mut status = world.resource_mut::<RenderStatus>();
                status.samples = 3;
                status.full_size = UVec2::new(640, 480);
                status.size = UVec2::new(320, 240);
            }
            world.run_system_cached(follow_place).expect("runs");
            assert!(
                !world.resource::<RenderControl>().full_until_change,
                "it has just begun"
            );
            let long_ago = Instant::now()
                .checked_sub(2 * REST)
                .expect("the machine runs for longer");
            world.resource_mut::<RenderStatus>().last_restart = long_ago;
            world.run_system_cached(follow_place).expect("runs");
            let is_full = world.resource::<RenderControl>().full_until_change;
            assert_eq!(is_full, resolution == Resolution::AfterRest);
        }
    }
}
