//! The distance of what the picture shows, to hide behind it what is drawn over it.

use bevy::math::Vec2;

use crate::render::film::Film;

/// The distances of the picture's first hits. Without a film none is known.
#[derive(Clone, Copy, Debug, Default)]
pub struct Depths<'f>(Option<&'f Film>);

impl<'f> Depths<'f> {
    /// The distances in a film.
    pub fn of(film: &'f Film) -> Self {
        Self(Some(film).filter(|film| film.width() > 0 && film.height() > 0))
    }

    /// The distance in world units along the ray through a place of the picture, (0, 0) top left, (1, 1) bottom right: infinity where nothing
    /// is hit, and None where that is not known yet.
    pub fn at(&self, place: Vec2) -> Option<f32> {
        let film = self.0?;
        let pixel = |share: f32, count: u32| ((share * count as f32).max(0.0) as u32).min(count - 1);
        let (x, y) = (pixel(place.x, film.width()), pixel(place.y, film.height()));
        let depth = film.pixel(x, y)?.depth;
        Some(if depth > 0.0 { depth } else { f32::INFINITY })
    }

    /// The number of distances in a row; 0 if none is known.
    pub fn width(&self) -> u32 {
        self.0.map_or(0, Film::width)
    }
}
