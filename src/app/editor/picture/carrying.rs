//! Reprojects an earlier picture onto the present one until that has samples of its own: see [`crate::render::carry`].

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use crossbeam_channel::{Receiver, Sender, TryRecvError, unbounded};

use super::compare::Comparison;
use super::filter_work::FilterWork;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::display::DisplayMode;
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::color::Rgb;
use crate::engine::{DeferredDrop, Gate, RenderControl, RenderFilm, RenderState, RenderStatus, WakeUp};
use crate::memory::{self, Reservation};
use crate::render::carry::{Carried, CarriedTile, Clean, Earlier};
use crate::render::denoise::DenoiseError;
use crate::render::gbuffer::TileGBuffer;
use crate::render::tile::{Tile, tiles};
use crate::render::view::{Shown, View};

/// The time per frame for taking up reprojected tiles; the rest waits for the next frame.
const LONGEST: Duration = Duration::from_millis(4);
/// The tiles that a job reprojects together.
const TOGETHER: usize = 16;
/// The samples of the film below which tiles with hardly any known pixels are rendered first.
const FIRST_SAMPLES: u32 = 4;
/// A picture of low resolution is not carried over while an earlier, sharper one covers more than this share of it.
const ENOUGH: f32 = 0.7;
/// The memory per pixel in bytes: the carried-over and the painted light in the earlier picture and in this one; and
/// the coarse picture.
const BYTES_OF_PIXEL: u64 = 2 * Carried::BYTES_OF_PIXEL + 48;

/// The earlier picture, and its parts that are carried over.
#[derive(Resource, Default)]
pub(crate) struct Carrying {
    /// Whether the window has a user, or stands for one in a measurement.
    is_watched: bool,
    carried: Option<Carried>,
    /// The last picture of light before another display mode, kept for the next picture of light.
    kept: Option<Arc<Earlier>>,
    /// The last job of the film.
    job: u64,
    /// Whether the film's resolution is lower than requested.
    is_coarse: bool,
    last_restart: Option<Instant>,
    /// Tiles from the threads that reproject their pixels.
    found: Option<Found>,
    /// Whether this picture or one before it was path guided.
    is_guided: bool,
    /// The tiles that show pixels of an earlier picture.
    tiles: HashSet<Tile>,
    /// Whether all tiles have to be repainted because nothing is carried over any more.
    has_ended: bool,
    /// Whether the texture still shows the earlier picture, which suits all pixels of this one that are not known yet.
    is_unchanged: bool,
    /// The running filter of the coarse picture.
    coarse: Option<FilterWork<Result<Vec<Rgb>, DenoiseError>>>,
    memory: Option<Reservation>,
}

/// The channel of reprojected tiles from their threads.
struct Found {
    sender: Sender<CarriedTile>,
    receiver: Receiver<CarriedTile>,
    /// The tiles that have not arrived.
    awaited: usize,
}

impl Carrying {
    pub fn new(is_watched: bool) -> Self {
        Self {
            is_watched,
            ..Self::default()
        }
    }

    /// The carried-over picture of this film.
    pub(super) fn picture_mut(&mut self, film: &RenderFilm) -> Option<&mut Carried> {
        self.carried.as_mut().filter(|carried| carried.is_of_size(&film.film))
    }

    /// Whether parts of the picture are still carried over from an earlier one.
    pub fn is_seen(&self) -> bool {
        self.carried.as_ref().is_some_and(|carried| carried.earlier().is_some()) && !self.tiles.is_empty()
    }

    /// Whether the next frame has more tiles to take up.
    pub fn has_backlog(&self) -> bool {
        self.found.as_ref().is_some_and(|found| found.awaited > 0)
    }

    /// Corrects the carried-over pixels by the samples of these tiles.
    pub(super) fn learn(&mut self, film: &RenderFilm, changed: &[Tile]) {
        if let Some(carried) = self.picture_mut(film) {
            carried.learn(changed, &film.film);
        }
    }

    /// Corrects the carried-over pixels by a denoised picture.
    pub(super) fn learn_clean(&mut self, film: &RenderFilm, clean: Clean) {
        let has_some = !self.tiles.is_empty();
        if let Some(carried) = self.picture_mut(film).filter(|_| has_some) {
            carried.learn_clean(&film.film, clean);
        }
    }

    /// Notes which of the painted tiles still show pixels of an earlier picture.
    pub(super) fn note_painted(&mut self, painted: &[Tile], still: Vec<Tile>) {
        for tile in painted {
            self.tiles.remove(tile);
        }
        self.tiles.extend(still);
    }

    /// Returns, once per end, whether all tiles have to be repainted because nothing is carried over any more.
    pub(super) fn take_end(&mut self) -> bool {
        std::mem::take(&mut self.has_ended)
    }

    /// Returns, once per picture, whether the texture suits a new picture without being repainted.
    pub(super) fn take_unchanged(&mut self) -> bool {
        std::mem::take(&mut self.is_unchanged)
    }

    /// Pauses while another display mode, a light mix or a comparison is shown. The picture so far is kept.
    fn rest(&mut self, garbage: &DeferredDrop) {
        if let Some(carried) = self.carried.take() {
            let before = carried.earlier();
            if let Some(earlier) = carried.into_earlier() {
                garbage.drop_later(self.kept.replace(earlier));
            }
            garbage.drop_later(before);
            self.has_ended = true;
        }
        self.end(garbage);
    }

    /// Ends carrying over.
    fn end(&mut self, garbage: &DeferredDrop) {
        if let Some(carried) = self.carried.take() {
            self.has_ended = true;
            garbage.drop_later(carried);
        }
        (self.coarse, self.found) = (None, None);
        self.tiles.clear();
        self.is_unchanged = false;
    }

    /// Reserves the memory for pictures of this view. Returns false if there is too little.
    fn reserve(&mut self, view: &View) -> bool {
        let bytes = BYTES_OF_PIXEL * u64::from(view.width) * u64::from(view.height);
        let reserved = match &mut self.memory {
            Some(memory) => memory.resize(bytes),
            None => memory::reserve(bytes).map(|memory| self.memory = Some(memory)),
        };
        reserved.is_ok()
    }

    /// Carries the last painted picture over to a new film.
    fn begin(&mut self, film: &mut RenderFilm, garbage: &DeferredDrop) {
        let was_coarse = std::mem::replace(&mut self.is_coarse, film.is_coarse);
        let old = self.carried.take();
        self.end(garbage);
        self.job = film.job;
        let Some(view) = film.view.as_ref() else { return };
        if view.shown != Shown::Radiance {
            self.carried = old;
            self.rest(garbage);
            return;
        }
        // A picture that fills the memory is shown without carrying over.
        if !self.reserve(view) {
            (self.has_ended, self.memory) = (true, None);
            garbage.drop_later((old, self.kept.take()));
            return;
        }
        let size = UVec2::new(view.width, view.height);
        self.is_unchanged = old.as_ref().is_some_and(|old| old.has_view(&view.camera, size));
        let earlier = old.and_then(|old| match old.earlier() {
            Some(before) if was_coarse && old.coverage() > ENOUGH => Some(before),
            before => {
                let earlier = old.into_earlier();
                garbage.drop_later(before);
                earlier
            }
        });
        let kept = self.kept.take();
        let earlier = match earlier {
            None => kept,
            some => {
                garbage.drop_later(kept);
                some
            }
        };
        let has_to_be_painted = earlier.is_some() && !self.is_unchanged;
        let mut carried = Carried::begin(earlier, &view.camera, size);
        self.is_guided |= view.guide.is_some();
        if self.is_guided {
            carried.expect_guided_paths();
        }
        self.tiles = tiles(view.width, view.height).into_iter().collect();
        let (sender, receiver) = unbounded();
        self.found = Some(Found {
            sender,
            receiver,
            awaited: 0,
        });
        self.carried = Some(carried);
        if has_to_be_painted {
            film.mark_all();
        }
    }

    /// Starts the reprojection of tiles with a new G-buffer, and takes up finished ones, within the time of a frame.
    fn take_gbuffer(&mut self, film: &mut RenderFilm, wake_up: &WakeUp) {
        let (Some(carried), Some(found)) = (&mut self.carried, &mut self.found) else {
            film.gbuffer.clear();
            return;
        };
        found.awaited += film.gbuffer.len();
        while !film.gbuffer.is_empty() {
            let new: Vec<TileGBuffer> = film.gbuffer.drain(..TOGETHER.min(film.gbuffer.len())).collect();
            let (sender, wake_up) = (found.sender.clone(), wake_up.clone());
            let reprojection = carried.reprojection().cloned();
            rayon::spawn(move || {
                for tile in new {
                    // The receiver is gone if another picture has begun.
                    if sender.send(CarriedTile::find(reprojection.as_deref(), tile)).is_err() {
                        return;
                    }
                }
                if let Some(wake) = &wake_up.0 {
                    wake();
                }
            });
        }
        let begun = Instant::now();
        while begun.elapsed() < LONGEST
            && let Ok(tile) = found.receiver.try_recv()
        {
            film.mark(carried.add(tile));
            found.awaited -= 1;
        }
        if !found.receiver.is_empty()
            && let Some(wake) = &wake_up.0
        {
            wake();
        }
    }

    /// Takes up the coarse picture once it is filtered.
    fn take_coarse(&mut self, film: &mut RenderFilm) {
        let (Some(carried), Some(filter)) = (&mut self.carried, &self.coarse) else {
            return;
        };
        match filter.result() {
            Err(TryRecvError::Empty) => return,
            Ok(Ok(light)) => {
                carried.add_coarse(&light);
                film.mark_all();
            }
            // Without the filter the picture stays as sampled.
            Ok(Err(_)) | Err(TryRecvError::Disconnected) => {}
        }
        self.coarse = None;
    }
}

/// Requests the G-buffer from the engine.
pub(crate) fn ask_for_gbuffer(
    carrying: Res<Carrying>,
    mut control: ResMut<RenderControl>,
    settings: Res<ViewSettings>,
    preferences: Res<Preferences>,
    mix: Res<LightMix>,
    comparison: Res<Comparison>,
    film: Res<RenderFilm>,
) {
    // A kept picture may lack a G-buffer, until another scene is opened.
    if film.is_empty() && control.lights_are_free != carrying.is_watched {
        control.lights_are_free = carrying.is_watched;
    }
    // Mixed lights and comparisons show the film alone.
    let is_plain =
        settings.display.mode == DisplayMode::Shaded && mix.is_neutral() && comparison.view == CompareView::Off;
    let is_on = carrying.is_watched && preferences.carries_over && is_plain;
    if control.gbuffer != is_on {
        control.gbuffer = is_on;
    }
}

/// Follows the film: keeps a picture before it is replaced, and carries it over to the next.
pub(crate) fn follow_carrying(
    mut carrying: ResMut<Carrying>,
    mut film: ResMut<RenderFilm>,
    control: Res<RenderControl>,
    preferences: Res<Preferences>,
    status: Res<RenderStatus>,
    wake_up: Res<WakeUp>,
    gate: Res<Gate>,
    garbage: Res<DeferredDrop>,
) {
    let carrying = carrying.bypass_change_detection();
    let film = film.bypass_change_detection();
    if !control.gbuffer || film.is_empty() {
        carrying.rest(&garbage);
        film.gbuffer.clear();
        film.set_urgent(HashSet::new());
        carrying.job = film.job;
        if film.is_empty() || !preferences.carries_over {
            garbage.drop_later(carrying.kept.take());
            (carrying.memory, carrying.is_guided) = (None, false);
        }
        return;
    }
    if carrying.last_restart.replace(status.last_restart) != Some(status.last_restart) {
        // The cores are needed for the next picture.
        carrying.coarse = None;
    }
    let is_relit = film.relit.is_some() && carrying.job + 1 == film.job;
    if carrying.job != film.job && !is_relit {
        carrying.begin(film, &garbage);
    }
    // Carried-over pixels are corrected by the samples, which have the new light.
    carrying.job = film.job;
    carrying.take_gbuffer(film, &wake_up);
    carrying.take_coarse(film);
    let Some(carried) = &mut carrying.carried else { return };
    let is_finished = status.state == RenderState::Done && status.is_up_to_date;
    carried.set_progress(match is_finished {
        true => 1.0,
        false => film.samples as f32 / status.target.max(1) as f32,
    });
    if is_finished && !carrying.tiles.is_empty() {
        carrying.tiles.clear();
        carrying.has_ended = true;
    }
    let is_early = film.samples < FIRST_SAMPLES && carried.earlier().is_some();
    film.set_urgent(match is_early {
        true => carried.hardly_known(),
        false => HashSet::new(),
    });
    if film.samples == 0
        && let Some(coarse) = carried.coarse(&film.film)
    {
        let threads = control.threads.get();
        let filter = move |cancel: &AtomicBool| coarse.enlarge(threads, cancel);
        carrying.coarse = FilterWork::begin("coarse", Some(&gate), &wake_up, filter).ok();
    }
}
