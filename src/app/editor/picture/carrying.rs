//! Shows what an earlier picture still tells about the present one, until that has samples of its own: see [`crate::render::carry`].

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use crossbeam_channel::TryRecvError;

use super::compare::Comparison;
use super::denoised::Denoised;
use super::denoiser::Denoiser;
use super::filter_work::FilterWork;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::display::DisplayMode;
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::color::Rgb;
use crate::engine::{DeferredDrop, Gate, RenderControl, RenderFilm, RenderState, RenderStatus, WakeUp};
use crate::memory::{self, Reservation};
use crate::render::carry::{Carried, Clean, Earlier};
use crate::render::denoise::DenoiseError;
use crate::render::tile::{Tile, tiles};
use crate::render::view::{Shown, View};

/// The part of a frame in which pixels are found in the earlier picture; the rest waits for the next frame.
const LONGEST: Duration = Duration::from_millis(6);
/// The tiles whose pixels are found at once.
const TOGETHER: usize = 16;
/// A picture of low resolution is not carried over while there is a better one for this share of it.
const ENOUGH: f32 = 0.7;
/// The pictures of [`Earlier::bytes`] that are in memory at once: the earlier one, what is carried over, what is made of both for the next one, and the
/// coarse picture.
const COPIES: u64 = 4;

/// The picture before, and what of it is carried over.
#[derive(Resource, Default)]
pub(crate) struct Carrying {
    /// Whether the window has a user, or stands for one in a measurement.
    is_watched: bool,
    /// The picture that was shown when the job began whose film has not begun yet.
    earlier: Option<Arc<Earlier>>,
    carried: Option<Carried>,
    /// The film's job that was seen last.
    job: u64,
    last_restart: Option<Instant>,
    /// The number of tiles of the film's G-buffer that were taken.
    taken: usize,
    has_backlog: bool,
    /// Whether this picture or one before it had guided paths.
    is_guided: bool,
    /// The tiles that show something that is not of the film.
    tiles: HashSet<Tile>,
    /// Whether all has to be painted because nothing is carried over any more.
    has_ended: bool,
    /// The filter of the coarse picture, while it is at work.
    coarse: Option<FilterWork<Result<Vec<Rgb>, DenoiseError>>>,
    memory: Option<Reservation>,
}

impl Carrying {
    pub fn new(is_watched: bool) -> Self {
        Self {
            is_watched,
            ..Self::default()
        }
    }

    /// What is carried over to the present film.
    pub fn picture(&self) -> Option<&Carried> {
        self.carried.as_ref()
    }

    /// Whether some of the picture is still carried over from another.
    pub fn is_seen(&self) -> bool {
        self.carried.as_ref().is_some_and(Carried::has_earlier) && !self.tiles.is_empty()
    }

    /// Whether the next frame has something to do for it.
    pub fn has_backlog(&self) -> bool {
        self.has_backlog
    }

    /// Compares what is carried over with the samples of these tiles.
    pub(super) fn learn(&mut self, film: &RenderFilm, changed: &[Tile]) {
        if let Some(carried) = &mut self.carried {
            carried.learn(changed, &film.film);
        }
    }

    /// Compares it with a denoised picture.
    pub(super) fn learn_clean(&mut self, film: &RenderFilm, clean: Clean) {
        if let Some(carried) = self.carried.as_mut().filter(|carried| carried.is_of_size(&film.film)) {
            carried.learn_clean(&film.film, clean);
        }
    }

    /// Notes which of the painted tiles still show something that is not of the film. Carrying over ends when there are none.
    pub(super) fn note_painted(
        &mut self,
        film: &RenderFilm,
        painted: &[Tile],
        still: Vec<Tile>,
        garbage: &DeferredDrop,
    ) {
        for tile in painted {
            self.tiles.remove(tile);
        }
        self.tiles.extend(still);
        if self.tiles.is_empty() && film.samples > 0 {
            self.end(garbage);
            // The texture already shows the film alone.
            self.has_ended = false;
        }
    }

    /// Whether all has to be painted because nothing is carried over any more, once for each end.
    pub(super) fn take_end(&mut self) -> bool {
        std::mem::take(&mut self.has_ended)
    }

    /// Shows the present film alone from now on.
    fn end(&mut self, garbage: &DeferredDrop) {
        if let Some(carried) = self.carried.take() {
            self.has_ended = true;
            garbage.drop_later(carried);
        }
        self.coarse = None;
        self.tiles.clear();
        self.has_backlog = false;
    }

    /// Reserves the memory for pictures of this view. False if there is too little.
    fn reserve(&mut self, view: &View) -> bool {
        let bytes = COPIES * Earlier::bytes(u64::from(view.width) * u64::from(view.height));
        let reserved = match &mut self.memory {
            Some(memory) => memory.resize(bytes),
            None => memory::reserve(bytes).map(|memory| self.memory = Some(memory)),
        };
        reserved.is_ok()
    }

    /// Keeps the picture as it is shown, for the next one.
    fn keep(&mut self, film: &RenderFilm, clean: Option<Clean>) {
        let view = film.view.as_ref().filter(|view| view.shown == Shown::Radiance);
        let Some(view) = view.filter(|view| self.reserve(view)) else {
            return;
        };
        self.earlier = match self.carried.take() {
            Some(carried) if film.is_coarse && carried.has_earlier() && carried.coverage() > ENOUGH => {
                carried.into_before()
            }
            Some(carried) => carried.into_earlier(&film.film, clean),
            None => Earlier::of_film(&view.camera, &film.film, clean, &film.gbuffer).map(Arc::new),
        };
    }

    /// Begins to carry the kept picture over to a new film.
    fn begin(&mut self, film: &mut RenderFilm, garbage: &DeferredDrop) {
        self.end(garbage);
        (self.job, self.taken) = (film.job, 0);
        let earlier = self.earlier.take();
        let view = film.view.as_ref().filter(|view| view.shown == Shown::Radiance);
        // A picture that fills the memory is shown without the one before.
        if let Some(view) = view.filter(|view| self.reserve(view)) {
            let mut carried = Carried::begin(earlier, &view.camera, UVec2::new(view.width, view.height));
            self.is_guided |= view.guide.is_some();
            if self.is_guided {
                carried.expect_guided_paths();
            }
            self.carried = Some(carried);
            self.tiles = tiles(view.width, view.height).into_iter().collect();
            film.mark_all();
        }
    }

    /// Finds the pixels of tiles whose G-buffer has come, for as long as a frame may take.
    fn take_gbuffer(&mut self, film: &mut RenderFilm) {
        let Some(carried) = &mut self.carried else { return };
        let begun = Instant::now();
        while self.taken < film.gbuffer.len() && begun.elapsed() < LONGEST {
            let next = (self.taken + TOGETHER).min(film.gbuffer.len());
            let new = &film.gbuffer[self.taken..next];
            carried.add(new);
            let new: Vec<Tile> = new.iter().map(|tile| tile.tile).collect();
            new.into_iter().for_each(|tile| film.mark(tile));
            self.taken = next;
        }
        self.has_backlog = self.taken < film.gbuffer.len();
    }

    /// Takes up the coarse picture once it is there.
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
            // Without it the picture stays as sampled.
            Ok(Err(_)) | Err(TryRecvError::Disconnected) => {}
        }
        self.coarse = None;
    }
}

/// Asks the engine for what pictures are carried over with.
pub(crate) fn ask_for_gbuffer(
    carrying: Res<Carrying>,
    mut control: ResMut<RenderControl>,
    settings: Res<ViewSettings>,
    preferences: Res<Preferences>,
    mix: Res<LightMix>,
    comparison: Res<Comparison>,
    film: Res<RenderFilm>,
) {
    // A picture that was kept may be without what that takes, until another scene is opened.
    if film.is_empty() && control.lights_are_free != carrying.is_watched {
        control.lights_are_free = carrying.is_watched;
    }
    // Mixed lights and comparisons show what is in the film.
    let is_plain =
        settings.display.mode == DisplayMode::Shaded && mix.is_neutral() && comparison.view == CompareView::Off;
    let is_on = carrying.is_watched && preferences.carries_over && is_plain;
    if control.gbuffer != is_on {
        control.gbuffer = is_on;
    }
}

/// Follows the film: keeps pictures that are about to go, and carries them over.
pub(crate) fn follow_carrying(
    mut carrying: ResMut<Carrying>,
    mut film: ResMut<RenderFilm>,
    control: Res<RenderControl>,
    status: Res<RenderStatus>,
    denoiser: Res<Denoiser>,
    wake_up: Res<WakeUp>,
    gate: Res<Gate>,
    garbage: Res<DeferredDrop>,
) {
    let carrying = carrying.bypass_change_detection();
    let film = film.bypass_change_detection();
    let is_new = carrying.job != film.job;
    let restarts = carrying.last_restart.replace(status.last_restart) != Some(status.last_restart);
    if !control.gbuffer || film.is_empty() {
        carrying.end(&garbage);
        (carrying.earlier, carrying.memory, carrying.job) = (None, None, film.job);
        carrying.is_guided = false;
        return;
    }
    let is_relit = is_new && film.relit.is_some() && carrying.job + 1 == film.job;
    if is_relit {
        // What is carried over is corrected by the samples, which have the new light.
        carrying.job = film.job;
    } else if is_new {
        carrying.begin(film, &garbage);
    }
    if restarts {
        // The cores are needed for the next picture.
        carrying.coarse = None;
        if carrying.earlier.is_none() {
            let clean = denoiser.picture();
            let clean = clean.filter(|picture| picture.job == film.job && picture.mix.is_empty());
            carrying.keep(film, clean.map(Denoised::clean));
        }
    }
    if status.state == RenderState::Done && status.is_up_to_date {
        return carrying.end(&garbage);
    }
    carrying.take_gbuffer(film);
    carrying.take_coarse(film);
    let Some(carried) = &mut carrying.carried else { return };
    carried.set_progress(film.samples as f32 / status.target.max(1) as f32);
    if film.samples == 0
        && let Some(coarse) = carried.coarse(&film.film)
    {
        let threads = control.threads.get();
        let filter = move |cancel: &AtomicBool| coarse.enlarge(threads, cancel);
        carrying.coarse = FilterWork::begin("coarse", Some(&gate), &wake_up, filter).ok();
    }
    if carrying.has_backlog
        && let Some(wake) = &wake_up.0
    {
        wake();
    }
}
