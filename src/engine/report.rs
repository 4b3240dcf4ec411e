//! Brings the status up to date, once per frame, after all other systems.

use bevy::prelude::*;

use super::auto::AutoIntegrator;
use super::blas_cache::BlasCache;
use super::choosing::{self, PilotSearch};
use super::control::RenderControl;
use super::detect::Dirty;
use super::extract::Extracted;
use super::job::Job;
use super::renderer::Renderer;
use super::status::{GuideStatus, RenderState, RenderStatus};
use super::stop_condition::StopCondition;
use crate::scene::{IntegratorSettings, SceneState, SceneStatus};

/// The most messages shown; a scene with a thousand invalid spheres needs no more.
const MOST_ERRORS: usize = 50;

pub(super) fn report_status(
    mut status: ResMut<RenderStatus>,
    renderer: Res<Renderer>,
    control: Res<RenderControl>,
    extracted: Res<Extracted>,
    cache: Res<BlasCache>,
    dirty: Res<Dirty>,
    scene: Res<SceneStatus>,
    (auto, search, integrator): (Res<AutoIntegrator>, Res<PilotSearch>, Res<IntegratorSettings>),
) {
    let job = renderer.job();
    let stop = StopCondition::new(&control, extracted.film_limits());
    let reached = job.and_then(|job| job.reached(&stop));
    let samples = job.map_or(0, Job::least_samples);
    let seconds = job.map_or(0.0, Job::seconds);
    let per_second = |count: u64| {
        if seconds > 0.0 {
            count as f64 / seconds / 1e6
        } else {
            0.0
        }
    };
    let failure = job.and_then(|job| job.failure.as_ref()).or(renderer.failure.as_ref());
    let builds_running = cache.builds_running() as u32 + u32::from(extracted.packing.is_some());
    status.state = if failure.is_some() {
        RenderState::Failed
    } else if control.paused {
        RenderState::Paused
    } else if job.is_some_and(Job::is_running) {
        RenderState::Rendering
    } else if extracted.meshes_loading > 0 {
        RenderState::Loading
    } else if builds_running > 0 {
        RenderState::Building
    } else if renderer.waiting {
        RenderState::Loading
    } else if job.is_none() {
        RenderState::Idle
    } else if reached.is_some() {
        RenderState::Done
    } else {
        RenderState::Rendering
    };
    status.is_up_to_date = !dirty.any()
        && builds_running == 0
        && extracted.meshes_loading == 0
        && scene.files_loading() == 0
        && scene.state != SceneState::Loading;
    status.samples = samples;
    status.first = job.and_then(|job| job.share).unwrap_or(0);
    status.target = stop.samples;
    choosing::report(&mut status, (&auto, &search), &extracted, &integrator, &control);
    status.time_limit = stop.seconds;
    status.noise_target = stop.noise;
    status.stopped_by = reached;
    status.noise = job.and_then(|job| job.noise);
    status.size = job.map_or(UVec2::ZERO, |job| UVec2::new(job.view.width, job.view.height));
    status.is_beyond_film = job.is_some_and(|job| job.view.film_camera.is_some());
    status.full_size = extracted.full_size;
    status.seconds = seconds;
    status.rays = job.map_or(0, |job| job.rays);
    status.guide = job.filter(|job| job.view.guide.is_some()).map(|job| GuideStatus {
        rays: job.guide_rays,
        bytes: job.guide_bytes(),
    });
    status.mrays_per_s = per_second(status.rays);
    let worked = job.map_or(0.0, |job| job.worked().as_secs_f64());
    status.undisturbed_mrays_per_s = match worked > 0.0 {
        true => status.rays as f64 / worked / 1e6 * control.threads.get() as f64,
        false => 0.0,
    };
    status.msamples_per_s = per_second(job.map_or(0, |job| job.samples));
    status.invalid_samples = job.map_or(0, |job| job.invalid);
    status.clamped = job.and_then(|job| job.clamped());
    status.triangles = extracted.triangles;
    status.bvh = extracted.bvh;
    status.meshes_loading = extracted.meshes_loading;
    status.builds_running = builds_running;
    status.errors.clear();
    status.errors.extend(failure.cloned());
    status.errors.extend(extracted.errors().take(MOST_ERRORS).cloned());
    status.shortages.clear();
    status
        .shortages
        .extend(extracted.shortages().iter().take(MOST_ERRORS).cloned());
}
