//! Denoises the picture during rendering while the user has that switched on: first early and quickly, then at each
//! doubling of the samples, and carefully once it is finished. The filter has a thread of its own and a copy of the
//! film, so that neither rendering nor the panels wait.

use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use bevy::prelude::*;
use crossbeam_channel::TryRecvError;

use super::denoised::Denoised;
use super::denoiser_input::FilmCopy;
use super::filter_work::FilterWork;
use crate::app::editor::command::display::DisplayMode;
use crate::app::editor::command::light_mix::{FilmLights, LightMix};
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::color::Rgb;
use crate::engine::{Gate, RenderControl, RenderFilm, RenderState, RenderStatus, WakeUp};
use crate::render::denoise::{DenoiseError, denoise};

/// The samples per pixel of the first denoised picture where the filter is slow; where it is quick it is made of the
/// first sample.
const FIRST: u32 = 4;
/// The most seconds that a quick filter takes.
const QUICK: f32 = 1.0;
/// The picture is also denoised again after a pause of this many times the filter's duration, in which no samples are
/// made.
const REST: f32 = 8.0;
/// The assumed duration of the filter before its first use, in seconds.
const EXPECTED: f32 = 0.3;

/// The denoiser's work, at most one at a time; its result is shown until the film restarts or a newer result replaces
/// it.
#[derive(Resource)]
pub(crate) struct Denoiser {
    stage: Stage,
    /// Cancelled work that still runs, since a filter checks for cancellation only now and then. The next work waits
    /// for its end.
    ending: Option<Work>,
    shown: Option<Denoised>,
    started: u64,
    unavailable: bool,
    /// The job of a film that could not be denoised.
    failed: Option<u64>,
    /// The job of a film that is still shown although the next one has been requested.
    abandoned: Option<u64>,
    last_restart: Option<Instant>,
    /// The last job of the film.
    job: u64,
    /// The time at which that job or the pause after the last work began.
    rests_since: Instant,
    /// The usual seconds of quick work.
    usual: f32,
}

enum Stage {
    Idle,
    Copying(FilmCopy),
    Working(Work),
}

struct Work {
    filter: FilterWork<Result<Denoised, DenoiseError>>,
    job: u64,
    mix: Vec<Rgb>,
}

/// The state of the film that the denoiser decides by.
struct Now<'a> {
    job: u64,
    samples: u32,
    is_finished: bool,
    mix: &'a [Rgb],
}

/// The quality of a denoised picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Care {
    /// The picture will have more samples soon.
    Quick,
    /// The picture is finished.
    Careful,
}

impl Default for Denoiser {
    fn default() -> Self {
        Self {
            stage: Stage::Idle,
            ending: None,
            shown: None,
            started: 0,
            unavailable: false,
            failed: None,
            abandoned: None,
            last_restart: None,
            job: 0,
            rests_since: Instant::now(),
            usual: EXPECTED,
        }
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

    pub fn is_available(&self) -> bool {
        !self.unavailable
    }

    /// Whether the next frame has more of the film to copy.
    pub fn is_copying(&self) -> bool {
        matches!(self.stage, Stage::Copying(_))
    }

    /// Whether a filter runs.
    pub fn is_working(&self) -> bool {
        matches!(self.stage, Stage::Working(_))
    }

    /// The state to show. `is_on`: whether the user has switched it on; `seen`: the number of the denoised picture that
    /// is in the window.
    pub fn state(&self, is_on: bool, seen: Option<u64>) -> DenoiserState {
        // The first tile of the next film may replace an abandoned film before the state is drawn.
        let is_seen = |shown: &&Denoised| seen == Some(shown.number) && self.abandoned != Some(shown.job);
        match self.shown.as_ref().filter(is_seen) {
            _ if self.unavailable => DenoiserState::Unavailable,
            _ if !is_on => DenoiserState::Off,
            Some(shown) => DenoiserState::Shown {
                seconds: shown.seconds,
                samples: shown.samples,
            },
            None => DenoiserState::Waiting,
        }
    }

    /// Whether the final denoised picture of a film that gets no more samples is still to come. `mix` has the factors
    /// on its layers.
    pub fn owes(&self, film: &RenderFilm, mix: &[Rgb]) -> bool {
        let now = Now {
            job: film.job,
            samples: film.samples.max(1),
            is_finished: true,
            mix,
        };
        self.abandoned != Some(film.job) && self.care_due(&now).is_some()
    }

    /// Whether the film has no denoised picture yet, but will have.
    pub fn awaits_first(&self, film: &RenderFilm) -> bool {
        !self.unavailable && self.shown.is_none() && self.failed != Some(film.job)
    }

    /// Cancels running work: the scene or the view is about to change.
    pub fn interrupt(&mut self) {
        if let Stage::Working(work) = std::mem::replace(&mut self.stage, Stage::Idle) {
            work.filter.stop();
            self.ending = Some(work);
        }
    }

    /// Whether a filter that was cancelled still runs.
    fn is_ending(&mut self) -> bool {
        if !self.ending.as_ref().is_some_and(|work| work.filter.is_working()) {
            self.ending = None;
        }
        self.ending.is_some()
    }

    /// The quality in which the film is to be denoised now; None if it is not due.
    fn care_due(&self, now: &Now) -> Option<Care> {
        if self.unavailable || self.failed == Some(now.job) || now.samples == 0 {
            return None;
        }
        let shown = self.shown.as_ref();
        let shown = shown.filter(|shown| shown.job == now.job && shown.mix == now.mix);
        if now.is_finished {
            let is_best = shown.is_some_and(|shown| shown.is_careful && shown.samples >= now.samples);
            return (!is_best).then_some(Care::Careful);
        }
        let before = shown.filter(|shown| !shown.is_relit).map_or(0, |shown| shown.samples);
        let next = match before {
            0 if self.usual <= QUICK => 1,
            0 => FIRST,
            before => before.saturating_mul(2),
        };
        let has_rested = self.rests_since.elapsed().as_secs_f32() >= REST * self.usual;
        (now.samples >= next || now.samples > before && has_rested).then_some(Care::Quick)
    }

    /// Relights the shown picture if lamps have changed and the samples have stayed. A new one is due soon.
    fn relight(&mut self, film: &RenderFilm) {
        if let Some(before) = film.relit.as_deref().filter(|_| self.job + 1 == film.job)
            && let Some(shown) = self.shown.take_if(|shown| shown.job == self.job)
        {
            self.started += 1;
            self.shown = shown.relit(film, before, self.started);
        }
    }

    /// Notes the film's present job, and drops results of another one.
    fn follow(&mut self, now: &Now, last_restart: Instant) {
        // The old film stays until the first tile of the new one arrives, but the cores are needed at once.
        if self.last_restart.replace(last_restart) != Some(last_restart) {
            self.interrupt();
            self.abandoned = (self.job == now.job).then_some(now.job);
        }
        if self.job != now.job {
            (self.job, self.rests_since) = (now.job, Instant::now());
        }
        if self.shown.as_ref().is_some_and(|shown| shown.job != now.job) {
            self.shown = None;
        }
        let is_other = match &self.stage {
            Stage::Idle => false,
            Stage::Copying(copy) => copy.job != now.job || copy.mix != now.mix,
            Stage::Working(work) => work.job != now.job || work.mix != now.mix,
        };
        if is_other {
            self.interrupt();
        }
    }

    /// Copies more of the film, and starts the filter once all of it is copied.
    fn go_on_copying(
        &mut self,
        mut copy: FilmCopy,
        film: &RenderFilm,
        threads: NonZeroUsize,
        (wake_up, gate): (&WakeUp, &Gate),
    ) {
        if !copy.step(&film.film) {
            self.stage = Stage::Copying(copy);
            // The rest is for the next frame.
            if let Some(wake) = &wake_up.0 {
                wake();
            }
            return;
        }
        self.started += 1;
        let (number, job, mix) = (self.started, copy.job, copy.mix.clone());
        // A careful filter may take seconds, in which samples may be requested.
        let gate = (copy.care == Care::Quick).then_some(gate);
        let filter = move |cancel: &AtomicBool| {
            let started = Instant::now();
            denoise(&copy.input(threads), cancel).map(|radiance| Denoised {
                radiance,
                mix: copy.mix,
                seconds: started.elapsed().as_secs_f32(),
                samples: copy.samples,
                number,
                job: copy.job,
                is_careful: copy.care == Care::Careful,
                is_relit: false,
            })
        };
        match FilterWork::begin("denoise", gate, wake_up, filter) {
            Ok(filter) => self.stage = Stage::Working(Work { filter, job, mix }),
            Err(error) => {
                error!("The denoiser's thread could not be started: {error}");
                self.failed = Some(job);
            }
        }
    }
}

/// Follows the film: starts and cancels work, and shows denoised pictures. A failure becomes a message.
pub(crate) fn follow_denoiser(
    mut denoiser: ResMut<Denoiser>,
    film: Res<RenderFilm>,
    status: Res<RenderStatus>,
    control: Res<RenderControl>,
    settings: Res<ViewSettings>,
    wake_up: Res<WakeUp>,
    gate: Res<Gate>,
    mix: Res<LightMix>,
    lights: Res<FilmLights>,
    mut toasts: ResMut<Toasts>,
) {
    let denoiser = denoiser.bypass_change_detection();
    if !settings.denoising {
        denoiser.interrupt();
        (denoiser.shown, denoiser.failed) = (None, None);
        return;
    }
    let mix = mix.factors(&film.light_groups, &lights);
    let now = Now {
        job: film.job,
        samples: film.samples,
        is_finished: matches!(status.state, RenderState::Done | RenderState::Paused),
        mix: &mix,
    };
    denoiser.relight(&film);
    denoiser.follow(&now, status.last_restart);
    let begin = |denoiser: &mut Denoiser| {
        // Other display modes do not show it.
        let is_seen = settings.display.mode == DisplayMode::Shaded && !film.is_coarse;
        if is_seen
            && denoiser.abandoned != Some(now.job)
            && let Some(care) = denoiser.care_due(&now)
        {
            let copy = FilmCopy::begin(&film, mix.clone(), care);
            denoiser.go_on_copying(copy, &film, control.threads, (&wake_up, &gate));
        }
    };
    match std::mem::replace(&mut denoiser.stage, Stage::Idle) {
        Stage::Idle if denoiser.is_ending() => {}
        Stage::Idle => begin(denoiser),
        Stage::Copying(copy) => denoiser.go_on_copying(copy, &film, control.threads, (&wake_up, &gate)),
        Stage::Working(work) => match work.filter.result() {
            Err(TryRecvError::Empty) => denoiser.stage = Stage::Working(work),
            Err(TryRecvError::Disconnected) => {
                denoiser.failed = Some(work.job);
                toasts.error(Topic::Other, "The denoiser broke off".to_owned(), None);
            }
            Ok(outcome) => {
                denoiser.rests_since = Instant::now();
                match outcome {
                    Ok(denoised) => {
                        if !denoised.is_careful {
                            denoiser.usual = denoised.seconds;
                        }
                        denoiser.shown = Some(denoised);
                    }
                    Err(DenoiseError::Cancelled) => {}
                    Err(error) => {
                        denoiser.failed = Some(work.job);
                        toasts.error(Topic::Other, error.to_string(), None);
                    }
                }
                begin(denoiser);
            }
        },
    }
}

/// The state of the denoiser that the menu and the picture show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DenoiserState {
    /// The picture is shown as sampled.
    #[default]
    Off,
    /// The picture is shown as sampled: it has too few samples, the first filter runs, or the display mode shows no
    /// light.
    Waiting,
    /// The denoised picture is shown.
    Shown {
        /// The time that the filter took.
        seconds: f32,
        /// The samples per pixel of its input.
        samples: u32,
    },
    /// The program was built without a denoiser.
    Unavailable,
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::Ordering;

    use super::*;

    fn shown(samples: u32, is_careful: bool) -> Option<Denoised> {
        Some(Denoised {
            radiance: Vec::new(),
            mix: Vec::new(),
            seconds: 0.2,
            samples,
            number: 1,
            job: 7,
            is_careful,
            is_relit: false,
        })
    }

    fn now(samples: u32, is_finished: bool) -> Now<'static> {
        Now {
            job: 7,
            samples,
            is_finished,
            mix: &[],
        }
    }

    /// The numbers of samples at which a picture that renders up to 64 samples is denoised at once.
    fn stops(denoiser: &mut Denoiser) -> Vec<u32> {
        let mut stops = Vec::new();
        for samples in 0..=64 {
            if denoiser.care_due(&now(samples, false)).is_some() {
                denoiser.shown = shown(samples, false);
                stops.push(samples);
            }
        }
        stops
    }

    #[test]
    fn pictures_are_denoised_each_time_that_they_have_twice_the_samples() {
        // The pause lasts for ever.
        let mut slow = Denoiser {
            usual: f32::MAX,
            ..Denoiser::default()
        };
        assert_eq!(stops(&mut slow), [4, 8, 16, 32, 64]);
        let mut quick = Denoiser {
            usual: QUICK,
            rests_since: Instant::now() + std::time::Duration::from_secs(3600),
            ..Denoiser::default()
        };
        assert_eq!(stops(&mut quick), [1, 2, 4, 8, 16, 32, 64]);
        // After a pause any new sample suffices.
        let mut rested = Denoiser {
            usual: 0.0,
            ..Denoiser::default()
        };
        assert_eq!(stops(&mut rested).len(), 64);
    }

    #[test]
    fn a_finished_picture_is_denoised_with_care_once() {
        let mut denoiser = Denoiser::default();
        let due = |denoiser: &Denoiser, samples, is_finished| denoiser.care_due(&now(samples, is_finished));
        assert_eq!(due(&denoiser, 3, true), Some(Care::Careful));
        denoiser.shown = shown(64, false);
        assert_eq!(due(&denoiser, 64, true), Some(Care::Careful));
        denoiser.shown = shown(64, true);
        assert_eq!(due(&denoiser, 64, true), None);
        assert_eq!(due(&denoiser, 65, true), Some(Care::Careful));
        // It goes on, and another film is another picture.
        denoiser.usual = f32::MAX;
        assert_eq!(
            (due(&denoiser, 127, false), due(&denoiser, 128, false)),
            (None, Some(Care::Quick))
        );
        let other = Now {
            job: 8,
            ..now(64, true)
        };
        assert_eq!(denoiser.care_due(&other), Some(Care::Careful));
        denoiser.failed = Some(7);
        assert_eq!(due(&denoiser, 1000, true), None);
    }

    #[test]
    fn a_film_that_is_about_to_be_replaced_is_left_alone() {
        let mut denoiser = Denoiser::default();
        let begun = Instant::now();
        denoiser.follow(&now(9, false), begun);
        assert_eq!(denoiser.abandoned, None);
        let again = begun + std::time::Duration::from_millis(1);
        denoiser.follow(&now(9, false), again);
        assert_eq!(denoiser.abandoned, Some(7));
        let next = Now {
            job: 8,
            ..now(1, false)
        };
        denoiser.follow(&next, again);
        assert_ne!(denoiser.abandoned, Some(next.job));
    }

    #[test]
    fn the_next_filter_waits_for_the_end_of_one_that_was_cancelled() {
        let (sender, released) = crossbeam_channel::bounded::<()>(1);
        let was_cancelled = Arc::new(AtomicBool::new(false));
        let noted = was_cancelled.clone();
        let slow = move |cancel: &AtomicBool| {
            let _ = released.recv();
            noted.store(cancel.load(Ordering::Relaxed), Ordering::Relaxed);
            Err(DenoiseError::Cancelled)
        };
        let filter = FilterWork::begin("denoise", None, &WakeUp::default(), slow);
        let mut denoiser = Denoiser {
            stage: Stage::Working(Work {
                filter: filter.expect("a thread"),
                job: 7,
                mix: Vec::new(),
            }),
            ..Denoiser::default()
        };
        denoiser.follow(&now(9, false), Instant::now());
        assert!(!denoiser.is_working());
        assert!(denoiser.is_ending() && denoiser.is_ending());
        // A further change of the picture leaves it so.
        denoiser.follow(&now(9, false), Instant::now());
        assert!(denoiser.is_ending());
        sender.send(()).expect("it is waited for");
        while denoiser.is_ending() {
            std::thread::yield_now();
        }
        assert!(was_cancelled.load(Ordering::Relaxed));
    }
}
