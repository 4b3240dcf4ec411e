//! Starts, pauses and continues the job that renders the extracted scene.

use std::sync::Arc;

use bevy::prelude::*;

use super::blas_cache::BlasCache;
use super::control::{Filling, Gate, RenderControl, WakeUp};
use super::deferred_drop::DeferredDrop;
use super::event_loop_waker::EventLoopWaker;
use super::extract::Extracted;
use super::film::RenderFilm;
use super::job::{Beginning, Job, Wanted};
use super::renderer::Renderer;
use super::saved::Resumed;
use super::shutter::OpenShutter;
use super::status::{Outdated, RenderStatus};
use super::stop_condition::StopCondition;
use crate::render::view::View;
use crate::scene::{SceneState, SceneStatus};

#[derive(bevy::ecs::system::SystemParam)]
pub(super) struct Demand<'w> {
    extracted: ResMut<'w, Extracted>,
    shutter: Res<'w, OpenShutter>,
    cache: Res<'w, BlasCache>,
    scene_status: Res<'w, SceneStatus>,
    wake_up: Res<'w, WakeUp>,
    gate: Res<'w, Gate>,
    deferred: Res<'w, DeferredDrop>,
    resumed: ResMut<'w, Resumed>,
}

impl Demand<'_> {
    /// Whether a part of the scene is still being read or built.
    fn is_incomplete(&self) -> bool {
        self.extracted.meshes_loading > 0
            || self.scene_status.pictures_loading > 0
            || self.scene_status.volumes_loading > 0
            || self.cache.builds_running() > 0
            || self.scene_status.state == SceneState::Loading
    }

    /// Makes the job of `view`, and drops the old one.
    fn begin(
        &mut self,
        old: &mut Option<Job>,
        view: View,
        control: &RenderControl,
        samples: u32,
        film: &mut RenderFilm,
    ) -> Job {
        let extracted = &mut *self.extracted;
        let since = extracted.since.take();
        let begins = match (control.interactive, &*old) {
            (false, _) => Beginning::Whole,
            // The picture from there stays until there are pixels of the other size, if it is not carried over.
            (true, Some(old)) if old.samples > 0 && !control.gbuffer && old.sees_the_same(&extracted.scene, &view) => {
                Beginning::Whole
            }
            (true, _) => Beginning::preview(control.motion_scale),
        };
        // The old job goes first, so that its workers stop while the new one is being set up.
        if let Some(mut old) = old.take() {
            old.cancel();
            old.forget_all_lamps();
            self.deferred.drop_later(old);
        }
        let reserved = film.reserve(&view, control, samples);
        let mut new = Job::new(
            extracted.scene.clone(),
            view,
            self.shutter.shutter.clone(),
            extracted.lamps.clone(),
            extracted.light_groups.clone(),
            begins,
            control.motion_scale < 1.0,
            since,
        );
        if control.gbuffer {
            new = new.with_gbuffer();
        }
        if let Some(first) = control.share {
            new = new.into_share(first);
        }
        new.failure = reserved.err().map(|shortage| shortage.to_string());
        if let Some(saved) = self.resumed.0.take()
            && saved.is_of(&extracted.scene, extracted.view.as_ref())
            && let Err(error) = new.resume(&saved.job, saved.film, film)
        {
            new.failure = Some(error.to_string());
        }
        new
    }
}

pub(super) fn dispatch_job(
    mut renderer: ResMut<Renderer>,
    mut control: ResMut<RenderControl>,
    mut film: ResMut<RenderFilm>,
    mut status: ResMut<RenderStatus>,
    mut demand: Demand,
) {
    status.outdated = None;
    if film.relit.as_ref().is_some_and(|before| !before.is_empty()) {
        film.bypass_change_detection().relit = Some(Arc::default());
    }
    let Some(mut view) = demand.extracted.view.clone() else {
        return;
    };
    view.before = demand.shutter.before.clone();
    renderer.prepare_backend(control.threads.get(), control.interactive);
    // A picture of the scene before would be taken for one of the scene that is being opened.
    let is_of_another = demand.extracted.is_of_another(&demand.scene_status);
    renderer.waiting = demand.is_incomplete() && !control.interactive || is_of_another;
    if control.paused || renderer.waiting {
        if control.paused {
            let job = renderer.job();
            status.outdated = match job {
                Some(job) => job.outdated(&demand.extracted.scene, &view),
                None => Some(Outdated::Scene),
            };
        }
        if let Some(job) = renderer.job_mut() {
            job.pause();
        }
        return;
    }
    let Renderer {
        backend: Some(backend),
        job,
        ..
    } = &mut *renderer
    else {
        return;
    };
    let current = job.as_ref().is_some_and(|job| {
        job.is_of(&demand.extracted.scene, &view, &demand.extracted.light_groups)
            && job.has_shutter(demand.shutter.shutter.as_ref())
    });
    let stop = StopCondition::new(&control, demand.extracted.film_limits());
    let stop = stop.in_picture_of(&view, control.filling == Filling::AroundFilm);
    let can_relight =
        !current && control.lights_are_free && !control.restart_requested && !demand.extracted.has_glowing_media();
    let wanted = Wanted {
        scene: &demand.extracted.scene,
        view: &view,
        lamps: &demand.extracted.lamps,
        light_groups: &demand.extracted.light_groups,
    };
    let relit = job
        .as_mut()
        .filter(|_| can_relight)
        .is_some_and(|job| job.relight(&wanted, &stop, film.bypass_change_detection()));
    if relit {
        film.set_changed();
    }
    if relit && let Some(since) = demand.extracted.since.take() {
        status.latency.record(1e3 * since.elapsed().as_secs_f32());
    }
    let current = current || relit;
    let is_inexact = stop.is_exact && job.as_ref().is_some_and(|job| !job.can_end_exactly_at(stop.samples));
    if !current || control.restart_requested || is_inexact {
        // A write marks the control as changed, whatever it says.
        if control.restart_requested {
            control.restart_requested = false;
        }
        let new = demand.begin(job, view, &control, stop.samples, film.bypass_change_detection());
        status.last_restart = new.begun;
        *job = Some(new);
    }
    if let Some(job) = job {
        let shown = film.bypass_change_detection();
        let waker = EventLoopWaker::new(&demand.wake_up);
        job.run(backend, &stop, shown, waker, &demand.gate);
        if !control.interactive && job.failure.is_none() {
            // The last picture stays in the film until the first tile of the new one has arrived.
            job.begin_in(film.bypass_change_detection());
        }
    }
}
