//! Denoises the picture on a thread of its own, from a copy of the film, so that neither rendering nor the panels wait.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use bevy::prelude::*;
use crossbeam_channel::{Receiver, bounded};

use crate::app::editor::command::light_mix::{FilmLights, LightMix};
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::color::Rgb;
use crate::engine::{RenderControl, RenderFilm, WakeUp};
use crate::render::denoise::{DenoiseError, DenoiseInput, DenoiseQuality, denoise};

/// A denoised picture, as large as the film it was made from.
pub(crate) struct Denoised {
    pub radiance: Vec<Rgb>,
    /// The factors on the layers of the film that it was made with.
    pub mix: Vec<Rgb>,
    pub seconds: f32,
    /// The samples per pixel that it was made from.
    pub samples: u32,
    /// Tells denoised pictures apart.
    pub number: u64,
    job: u64,
}

/// The denoiser's work, at most one at a time; its result is shown until the film is begun anew.
#[derive(Resource, Default)]
pub(crate) struct Denoiser {
    work: Option<Work>,
    shown: Option<Denoised>,
    started: u64,
    /// Whether it was asked for before there was a sample of every pixel.
    is_wanted: bool,
    unavailable: bool,
}

struct Work {
    cancel: Arc<AtomicBool>,
    result: Receiver<Result<Denoised, DenoiseError>>,
    job: u64,
}

impl Drop for Work {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Denoiser {
    pub fn new() -> Self {
        Self {
            unavailable: !cfg!(feature = "denoise"),
            ..Self::default()
        }
    }

    pub fn picture(&self) -> Option<&Denoised> {
        self.shown.as_ref()
    }

    pub fn state(&self) -> DenoiserState {
        match (&self.work, &self.shown) {
            _ if self.unavailable => DenoiserState::Unavailable,
            (Some(_), _) => DenoiserState::Running,
            _ if self.is_wanted => DenoiserState::Running,
            (None, Some(shown)) => DenoiserState::Shown {
                seconds: shown.seconds,
                samples: shown.samples,
            },
            (None, None) => DenoiserState::Idle,
        }
    }

    /// Starts with the film as it is now, or once it has a sample of every pixel of its region, and cancels work that is under way. `mix` has the
    /// factors on the layers of the film, `threads` is the number that it may use.
    pub fn start(&mut self, film: &RenderFilm, mix: Vec<Rgb>, threads: NonZeroUsize, wake_up: WakeUp) {
        let samples = film.samples;
        self.is_wanted = samples == 0 && !self.unavailable;
        if self.is_wanted || self.unavailable {
            return;
        }
        self.started += 1;
        let cancel = Arc::new(AtomicBool::new(false));
        let (sender, result) = bounded(1);
        let (flag, number, job, source) = (cancel.clone(), self.started, film.job, film.film.clone());
        let work = move || {
            let started = Instant::now();
            let (color, albedo, normal) = (source.mixed(&mix), source.albedo(), source.normal());
            let input = DenoiseInput {
                width: source.width(),
                height: source.height(),
                color: &color,
                albedo: Some(&albedo),
                normal: Some(&normal),
                prefilter: true,
                quality: DenoiseQuality::Balanced,
                threads: Some(threads.get()),
            };
            let outcome = denoise(&input, &flag).map(|radiance| Denoised {
                radiance,
                mix,
                seconds: started.elapsed().as_secs_f32(),
                samples,
                number,
                job,
            });
            // The receiver is gone if the work was cancelled.
            let _ = sender.send(outcome);
            if let Some(wake) = wake_up.0 {
                wake();
            }
        };
        match std::thread::Builder::new().name("denoise".to_owned()).spawn(work) {
            Ok(_) => self.work = Some(Work { cancel, result, job }),
            Err(error) => error!("The denoiser's thread could not be started: {error}"),
        }
    }

    /// Shows the picture as sampled again.
    pub fn clear(&mut self) {
        self.work = None;
        self.shown = None;
        self.is_wanted = false;
    }
}

/// Takes a finished picture; drops the result of a film that no longer exists. A failure is returned as a message.
pub(crate) fn collect_denoised(
    mut denoiser: ResMut<Denoiser>,
    film: Res<RenderFilm>,
    control: Res<RenderControl>,
    wake_up: Res<WakeUp>,
    mix: Res<LightMix>,
    lights: Res<FilmLights>,
    mut toasts: ResMut<Toasts>,
) {
    if denoiser.is_wanted && film.samples > 0 {
        let mix = mix.factors(&film.light_groups, &lights);
        denoiser.start(&film, mix, control.threads, wake_up.clone());
    }
    let is_stale = |job: u64| job != film.job;
    if denoiser.work.as_ref().is_some_and(|work| is_stale(work.job)) {
        denoiser.work = None;
    }
    if denoiser.shown.as_ref().is_some_and(|shown| is_stale(shown.job)) {
        denoiser.shown = None;
    }
    let Some(outcome) = denoiser.work.as_ref().and_then(|work| work.result.try_recv().ok()) else {
        return;
    };
    denoiser.work = None;
    match outcome {
        Ok(denoised) => denoiser.shown = Some(denoised),
        Err(DenoiseError::Cancelled) => {}
        Err(error) => toasts.error(Topic::Other, error.to_string(), None),
    }
}

/// The state of the denoiser that the menu and the status line show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DenoiserState {
    /// The picture is shown as sampled.
    #[default]
    Idle,
    /// A filter is at work in the background.
    Running,
    /// The denoised picture is shown.
    Shown {
        /// The time that the filter took.
        seconds: f32,
        /// The samples per pixel that it had.
        samples: u32,
    },
    /// The program was built without it, or it failed.
    Unavailable,
}
