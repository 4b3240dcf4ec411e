//! The film of the current picture, as the application reads it.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Instant;

use bevy::math::UVec2;
use bevy::prelude::*;

use crate::color::Rgb;
use crate::memory::{self, Reservation, Shortage};
use crate::render::film::{Film, NewLayer};
use crate::render::gbuffer::TileGBuffer;
use crate::render::tile::{Tile, TilePreview, tiles};
use crate::render::view::View;

use super::control::RenderControl;
use super::light_groups::LightGroup;
use super::schedule::tiles_in;

/// The film, and its tiles that have changed since they were last painted.
#[derive(Resource, Default)]
pub struct RenderFilm {
    /// The samples of the picture so far.
    pub film: Film,
    /// The number of the picture. With a new number all displayed tiles are old, though still worth showing until new
    /// tiles arrive: the last picture stays until the first tile of the new one.
    pub job: u64,
    /// The samples that every pixel of the rendered region has; pixels outside of it may have fewer.
    pub samples: u32,
    /// The lights of each layer of the film.
    pub light_groups: Arc<[LightGroup]>,
    /// Whether the resolution is temporarily reduced, see
    /// [`RenderControl::motion_scale`](super::RenderControl::motion_scale).
    pub is_coarse: bool,
    /// The G-buffer of the tiles that have arrived, in that order. Only if it is [requested](RenderControl::gbuffer).
    pub gbuffer: Vec<TileGBuffer>,
    urgent: HashSet<Tile>,
    urgent_changed: bool,
    /// Whether the film has light of this picture: a preview or samples.
    pub is_lit: bool,
    /// The light of the previous picture, row by row, if this one has its samples under other lights. It is empty after
    /// the frame in which that changed.
    pub relit: Option<Arc<[Rgb]>>,
    /// The view of the picture; None if there is no picture.
    pub view: Option<View>,
    dirty: HashSet<Tile>,
    /// The time at which this picture's job began.
    begun: Option<Instant>,
    memory: Option<Reservation>,
}

/// The error that a film does not fit into the memory budget. Its size is in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a film of {width} x {height} pixels needs {shortage}")]
pub(super) struct FilmShortage {
    width: u32,
    height: u32,
    shortage: Shortage,
}

impl RenderFilm {
    /// The tiles that changed since the last call, without repetition, in no order.
    pub fn take_dirty(&mut self) -> Vec<Tile> {
        self.dirty.drain().collect()
    }

    /// Whether tiles have changed since they were last painted.
    pub(crate) fn has_dirty(&self) -> bool {
        !self.dirty.is_empty()
    }

    /// Reserves the memory for the film of this view, in place of the old reservation. The film of a share keeps chunks
    /// up to `samples`.
    pub(super) fn reserve(&mut self, view: &View, control: &RenderControl, samples: u32) -> Result<(), FilmShortage> {
        let kept = view.film_layers();
        let chunks = control.share.filter(|&first| first > 0).map_or(0, |first| {
            let size = UVec2::new(view.width, view.height);
            let tiles = tiles_in(control.region, &tiles(view.width, view.height), size);
            Film::chunk_bytes(tiles.len(), first..samples, kept)
        });
        let bytes = Film::memory_bytes(view.width, view.height, kept).saturating_add(chunks);
        self.reserve_bytes(bytes).map_err(|shortage| FilmShortage {
            width: view.width,
            height: view.height,
            shortage,
        })
    }

    fn reserve_bytes(&mut self, bytes: u64) -> Result<(), Shortage> {
        match &mut self.memory {
            Some(memory) => memory.resize(bytes),
            None => memory::reserve(bytes).map(|memory| self.memory = Some(memory)),
        }
    }

    /// Reserves the memory for the film of this view, which is not a share, in place of the old reservation. False if
    /// there is too little.
    pub(super) fn has_room_for(&mut self, view: &View) -> bool {
        self.reserve_bytes(Film::memory_bytes(view.width, view.height, view.film_layers()))
            .is_ok()
    }

    /// Starts the picture of the job that began at `begun`, unless it is already started. Returns the previews of the
    /// previous picture.
    pub(super) fn begin(
        &mut self,
        begun: Instant,
        view: &View,
        light_groups: &Arc<[LightGroup]>,
        is_coarse: bool,
    ) -> Vec<Option<TilePreview>> {
        if self.is_of(begun) {
            return Vec::new();
        }
        let mut film = std::mem::take(&mut self.film);
        let old = film.begin(view.width, view.height, view.film_layers());
        self.begin_with(begun, view, light_groups, is_coarse, film);
        old
    }

    /// Replaces the film by that of a job that began at `begun`.
    pub(super) fn begin_with(
        &mut self,
        begun: Instant,
        view: &View,
        light_groups: &Arc<[LightGroup]>,
        is_coarse: bool,
        film: Film,
    ) {
        self.film = film;
        self.view = Some(view.clone());
        self.light_groups = light_groups.clone();
        self.is_coarse = is_coarse;
        self.begun = Some(begun);
        self.job += 1;
        self.samples = 0;
        self.is_lit = false;
        self.relit = None;
        self.gbuffer.clear();
        self.urgent.clear();
        self.urgent_changed = false;
        self.dirty.clear();
    }

    /// Replaces the layers of light, see [`Film::relight`]. The result counts as another picture, which has the samples
    /// of this one.
    pub(super) fn relight(&mut self, layers: &[NewLayer], view: &View, light_groups: &Arc<[LightGroup]>) {
        self.relit = Some(self.film.radiance().into());
        self.film.relight(view.light_groups.count(), layers);
        (self.view, self.light_groups) = (Some(view.clone()), light_groups.clone());
        self.job += 1;
        self.mark_all();
    }

    /// Whether the film has no picture.
    pub(crate) fn is_empty(&self) -> bool {
        self.film.width() == 0
    }

    /// Removes the picture with all its data. The empty film counts as another picture.
    pub(super) fn clear(&mut self) {
        *self = Self {
            job: self.job + 1,
            ..Self::default()
        };
    }

    /// Whether the film has the picture of the job that began at `begun`.
    pub(super) fn is_of(&self, begun: Instant) -> bool {
        self.begun == Some(begun)
    }

    /// Marks all tiles as changed.
    pub fn mark_all(&mut self) {
        self.dirty.extend(tiles(self.film.width(), self.film.height()));
    }

    /// Sets the tiles that get their first samples before the others.
    pub fn set_urgent(&mut self, urgent: HashSet<Tile>) {
        if self.urgent != urgent {
            (self.urgent, self.urgent_changed) = (urgent, true);
        }
    }

    /// The tiles that get their first samples before the others.
    pub(super) fn urgent(&self) -> &HashSet<Tile> {
        &self.urgent
    }

    /// The urgent tiles, if they have changed since the last call.
    pub(super) fn take_urgent(&mut self) -> Option<&HashSet<Tile>> {
        std::mem::take(&mut self.urgent_changed).then_some(&self.urgent)
    }

    /// Marks a tile as changed.
    pub fn mark(&mut self, tile: Tile) {
        self.dirty.insert(tile);
    }
}
