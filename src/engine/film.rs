//! The picture being made, as the application reads it.

use std::collections::HashSet;

use bevy::prelude::*;

use crate::render::film::Film;
use crate::render::tile::Tile;

/// The film, and what of it has changed since somebody last looked.
#[derive(Resource, Default)]
pub struct RenderFilm {
    pub film: Film,
    /// Counts the pictures that were begun; with a new number all that was shown is old, though worth showing until tiles arrive.
    pub job: u64,
    dirty: HashSet<Tile>,
}

impl RenderFilm {
    /// The tiles that changed since the last call, each once, in no order.
    pub fn take_dirty(&mut self) -> Vec<Tile> {
        self.dirty.drain().collect()
    }

    pub fn has_dirty(&self) -> bool {
        !self.dirty.is_empty()
    }

    pub(super) fn begin(&mut self, width: u32, height: u32) {
        if (self.film.width(), self.film.height()) == (width, height) {
            self.film.clear();
        } else {
            self.film = Film::new(width, height);
        }
        self.job += 1;
        self.dirty.clear();
    }

    pub(super) fn mark(&mut self, tile: Tile) {
        self.dirty.insert(tile);
    }
}
