//! The picture being made, as the application reads it.

use std::collections::HashSet;
use std::time::Instant;

use bevy::prelude::*;

use crate::render::film::Film;
use crate::render::tile::Tile;
use crate::render::view::View;

/// The film, and what of it has changed since somebody last looked.
#[derive(Resource, Default)]
pub struct RenderFilm {
    pub film: Film,
    /// Counts the pictures that were begun; with a new number all that was shown is old, though worth showing until tiles arrive. A
    /// picture is begun here when its first tile arrives, until then the last one stays.
    pub job: u64,
    dirty: HashSet<Tile>,
    /// When the job was begun whose picture this is.
    begun: Option<Instant>,
}

impl RenderFilm {
    /// The tiles that changed since the last call, each once, in no order.
    pub fn take_dirty(&mut self) -> Vec<Tile> {
        self.dirty.drain().collect()
    }

    pub fn has_dirty(&self) -> bool {
        !self.dirty.is_empty()
    }

    pub(super) fn has_size_of(&self, view: &View) -> bool {
        (self.film.width(), self.film.height()) == (view.width, view.height)
    }

    /// Makes room for the job that was begun at `job_begun`, unless that was done before.
    pub(super) fn begin(&mut self, view: &View, job_begun: Instant) {
        if self.begun == Some(job_begun) {
            return;
        }
        if self.has_size_of(view) {
            self.film.clear();
        } else {
            self.film = Film::new(view.width, view.height);
        }
        self.begun = Some(job_begun);
        self.job += 1;
        self.dirty.clear();
    }

    pub(super) fn mark(&mut self, tile: Tile) {
        self.dirty.insert(tile);
    }
}
