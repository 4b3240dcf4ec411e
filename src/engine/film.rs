//! The picture being made, as the application reads it.

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

/// The film, and the parts of it that have changed since the last look.
#[derive(Resource, Default)]
pub struct RenderFilm {
    /// The samples of the picture so far.
    pub film: Film,
    /// Counts the pictures that were begun; with a new number all that was shown is old, though worth showing until
    /// tiles arrive. A picture is begun here when its first tile arrives, until then the last one stays.
    pub job: u64,
    /// The samples that every pixel of the rendered region has; those outside of it may have fewer.
    pub samples: u32,
    /// The lights of each layer of the film.
    pub light_groups: Arc<[LightGroup]>,
    /// Whether the resolution is lower than asked for, see
    /// [`RenderControl::motion_scale`](super::RenderControl::motion_scale).
    pub is_coarse: bool,
    /// The G-buffer of the tiles for which it is there, in the order in which they arrived. Only where it is [asked
    /// for](RenderControl::gbuffer).
    pub gbuffer: Vec<TileGBuffer>,
    urgent: HashSet<Tile>,
    urgent_changed: bool,
    /// Whether there is light of this picture: a preview or samples.
    pub is_lit: bool,
    /// The light of the picture of the job before, row by row, if this one has its samples with other light. It is
    /// empty after the frame in which that changed.
    pub relit: Option<Arc<[Rgb]>>,
    /// The view of the picture; None if there is no picture.
    pub view: Option<View>,
    dirty: HashSet<Tile>,
    /// The time at which the job was begun whose picture this is.
    begun: Option<Instant>,
    memory: Option<Reservation>,
}

/// Says that a film does not fit into the memory budget. Its size is in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a film of {width} x {height} pixels needs {shortage}")]
pub(super) struct FilmShortage {
    width: u32,
    height: u32,
    shortage: Shortage,
}

impl RenderFilm {
    /// The tiles that changed since the last call, each once, in no order.
    pub fn take_dirty(&mut self) -> Vec<Tile> {
        self.dirty.drain().collect()
    }

    /// Whether there are tiles that were not painted since they changed.
    pub(crate) fn has_dirty(&self) -> bool {
        !self.dirty.is_empty()
    }

    /// Reserves the memory for the film of this view, in place of the former reservation. The film of a share keeps
    /// chunks up to `samples`.
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

    /// Reserves the memory for the film of this view, which is no share, in place of the former reservation. False if
    /// there is too little.
    pub(super) fn has_room_for(&mut self, view: &View) -> bool {
        self.reserve_bytes(Film::memory_bytes(view.width, view.height, view.film_layers()))
            .is_ok()
    }

    /// Makes room for the picture of the job that was begun at this time, unless that was done before. Returns the
    /// previews of the picture before.
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

    /// Shows this film, the picture of the job that was begun at this time.
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

    /// Gives the picture these layers of light, see [`Film::relight`]. It counts as another picture, which has the
    /// samples of this one.
    pub(super) fn relight(&mut self, layers: &[NewLayer], view: &View, light_groups: &Arc<[LightGroup]>) {
        self.relit = Some(self.film.radiance().into());
        self.film.relight(view.light_groups.count(), layers);
        (self.view, self.light_groups) = (Some(view.clone()), light_groups.clone());
        self.job += 1;
        self.mark_all();
    }

    /// Whether there is no picture.
    pub(crate) fn is_empty(&self) -> bool {
        self.film.width() == 0
    }

    /// Takes the picture away. What was kept of it belongs to no picture any more.
    pub(super) fn clear(&mut self) {
        *self = Self {
            job: self.job + 1,
            ..Self::default()
        };
    }

    /// Whether it has the picture of the job that was begun at this time.
    pub(super) fn is_of(&self, begun: Instant) -> bool {
        self.begun == Some(begun)
    }

    /// Notes that all tiles have changed.
    pub fn mark_all(&mut self) {
        self.dirty.extend(tiles(self.film.width(), self.film.height()));
    }

    /// Says which tiles get their first samples before the others.
    pub fn set_urgent(&mut self, urgent: HashSet<Tile>) {
        if self.urgent != urgent {
            (self.urgent, self.urgent_changed) = (urgent, true);
        }
    }

    /// The tiles that get their first samples before the others.
    pub(super) fn urgent(&self) -> &HashSet<Tile> {
        &self.urgent
    }

    /// These tiles, if they have changed since the last call.
    pub(super) fn take_urgent(&mut self) -> Option<&HashSet<Tile>> {
        std::mem::take(&mut self.urgent_changed).then_some(&self.urgent)
    }

    /// Notes that a tile has changed.
    pub fn mark(&mut self, tile: Tile) {
        self.dirty.insert(tile);
    }
}
