//! Begins, pauses and continues the job that makes the picture of what was extracted.

use bevy::prelude::*;
use rayon::ThreadPool;

use super::blas_cache::BlasCache;
use super::control::{RenderControl, WakeUp};
use super::discard::Discard;
use super::extract::Extracted;
use super::film::RenderFilm;
use super::goal::Goal;
use super::job::{Beginning, Job};
use super::priority;
use super::status::RenderStatus;
use super::wake::Waker;
use crate::scene::{SceneState, SceneStatus};

/// The worker threads and what they work on.
#[derive(Resource, Default)]
pub(super) struct Renderer {
    pool: Option<ThreadPool>,
    job: Option<Job>,
    /// Why there are no threads.
    pub failure: Option<String>,
    /// Waiting for meshes or their acceleration structures before rendering may begin.
    pub waiting: bool,
}

impl Renderer {
    pub fn job(&self) -> Option<&Job> {
        self.job.as_ref()
    }

    pub fn job_mut(&mut self) -> Option<&mut Job> {
        self.job.as_mut()
    }

    /// A pool of so many threads, in place of one with another number; `yielding` to the window where there is one.
    fn prepare_pool(&mut self, threads: usize, yielding: bool) {
        if self
            .pool
            .as_ref()
            .is_some_and(|pool| pool.current_num_threads() == threads)
        {
            return;
        }
        if let Some(job) = &mut self.job {
            job.pause();
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("render {index}"))
            .start_handler(move |_| {
                if yielding {
                    priority::yield_to_window();
                }
            })
            .build();
        match pool {
            Ok(pool) => (self.pool, self.failure) = (Some(pool), None),
            Err(error) => self.failure = Some(format!("{threads} render threads cannot be started: {error}")),
        }
    }
}

#[derive(bevy::ecs::system::SystemParam)]
pub(super) struct Demand<'w> {
    extracted: ResMut<'w, Extracted>,
    cache: Res<'w, BlasCache>,
    scene_status: Res<'w, SceneStatus>,
    wake_up: Res<'w, WakeUp>,
    discard: Res<'w, Discard>,
}

pub(super) fn dispatch_job(
    mut renderer: ResMut<Renderer>,
    mut control: ResMut<RenderControl>,
    mut film: ResMut<RenderFilm>,
    mut status: ResMut<RenderStatus>,
    mut demand: Demand,
) {
    let Some(view) = demand.extracted.view.clone() else {
        return;
    };
    renderer.prepare_pool(control.threads.get(), control.interactive);
    let incomplete = demand.extracted.meshes_loading > 0
        || demand.scene_status.pictures_loading > 0
        || demand.cache.builds_running() > 0
        || demand.scene_status.state == SceneState::Loading;
    renderer.waiting = incomplete && !control.interactive;
    if control.paused || renderer.waiting {
        if let Some(job) = renderer.job_mut() {
            job.pause();
        }
        return;
    }
    let Renderer {
        pool: Some(pool), job, ..
    } = &mut *renderer
    else {
        return;
    };
    let current = job
        .as_ref()
        .is_some_and(|job| job.is_of(&demand.extracted.scene, &view, &demand.extracted.light_groups));
    let goal = Goal::new(&control, demand.extracted.sample_count);
    let is_inexact = goal.is_exact && job.as_ref().is_some_and(|job| !job.can_end_exactly_at(goal.samples));
    if !current || control.restart_requested || is_inexact {
        if control.restart_requested {
            control.restart_requested = false;
        }
        let since = demand.extracted.since.take();
        let begins = match (control.interactive, &*job) {
            (false, _) => Beginning::Whole,
            // What was seen from there stays until there are pixels of the other size.
            (true, Some(old)) if old.samples > 0 && old.is_of_other_size(&demand.extracted.scene, &view) => {
                Beginning::Whole
            }
            (true, _) => Beginning::preview(control.motion_scale),
        };
        // The old job goes first, so that its workers stop while the new one is being set up.
        if let Some(old) = job.take() {
            old.cancel();
            demand.discard.discard(old);
        }
        let reserved = film.bypass_change_detection().reserve(&view);
        let mut new = Job::new(
            demand.extracted.scene.clone(),
            view,
            demand.extracted.light_groups.clone(),
            begins,
            control.motion_scale < 1.0,
            since,
        );
        new.failure = reserved.err();
        status.last_restart = new.begun;
        *job = Some(new);
    }
    if let Some(job) = job {
        job.run(pool, &goal, Waker::new(&demand.wake_up));
        if !control.interactive && job.failure.is_none() {
            // Otherwise the last picture stays in the film until the first tile of the new one is there.
            film.bypass_change_detection().begin(job);
        }
    }
}
