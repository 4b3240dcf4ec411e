//! Makes the choice of the integrator `auto`.
//!
//! Without a window the choice is made before the first sample ([`choose_integrator`](super::choose_integrator)). In a
//! window the first samples are path traced, so that a change is visible at once. The pilot starts on a thread of its
//! own when the picture has some samples; if it chooses another integrator, the picture starts again.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use bevy::prelude::*;

use super::auto::{AutoIntegrator, Seen, is_auto, samples_of};
use super::control::{RenderControl, WakeUp};
use super::deferred_drop::DeferredDrop;
use super::extract::Extracted;
use super::packed_scene::PackedScene;
use super::renderer::Renderer;
use super::status::{AutoStatus, RenderState, RenderStatus};
use super::stop_condition::StopCondition;
use crate::render::auto::{Choice, choose};
use crate::render::view::View;
use crate::scene::IntegratorSettings;

/// The samples of every pixel before which a window starts no pilot.
const FIRST: u32 = 16;

/// The pilot run of a window.
#[derive(Resource, Default)]
pub(super) struct PilotSearch(Option<RunningPilot>);

/// A running pilot.
struct RunningPilot {
    seen: Seen,
    cancel: Arc<AtomicBool>,
    found: Arc<OnceLock<Option<Choice>>>,
}

impl Drop for RunningPilot {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

/// Starts the pilot in a window when the picture has enough samples, and takes in its choice.
pub(super) fn seek_choice(
    mut auto: ResMut<AutoIntegrator>,
    mut search: ResMut<PilotSearch>,
    mut extracted: ResMut<Extracted>,
    mut packed: ResMut<PackedScene>,
    settings: Res<IntegratorSettings>,
    control: Res<RenderControl>,
    renderer: Res<Renderer>,
    wake_up: Res<WakeUp>,
    deferred: Res<DeferredDrop>,
) {
    // The old choice holds its scene, which may be large.
    let is_past = |(seen, _): &(Seen, Choice)| !seen.scene.is_same(&extracted.scene);
    if auto.0.as_ref().is_some_and(is_past) {
        deferred.drop_later(auto.0.take());
    }
    let Some(view) = extracted
        .view
        .clone()
        .filter(|_| control.interactive && is_auto(&settings, &control))
    else {
        search.0 = None;
        return;
    };
    let stop = StopCondition::new(&control, extracted.film_limits());
    if !auto.is_awaited(&extracted.scene, &view, stop.samples) {
        search.0 = None;
        return;
    }
    let seen = Seen::with_samples(&extracted.scene, &view, stop.samples);
    if let Some(under_way) = search.0.as_ref().filter(|search| search.seen.is_same(&seen)) {
        let Some(found) = under_way.found.get() else { return };
        auto.0 = found.map(|choice| (seen, choice));
        search.0 = None;
        apply(&auto, &mut extracted, &mut packed);
        return;
    }
    search.0 = None;
    let is_ready = |samples: u32| control.motion_scale >= 1.0 && samples >= FIRST.min(stop.samples);
    let is_of_view = |view: &View, other: &View| {
        view.integrator == other.integrator && view.guide.is_some() == other.guide.is_some()
    };
    let job = renderer.job().filter(|job| is_of_view(&job.view, &view));
    if control.paused || !job.is_some_and(|job| is_ready(job.least_samples())) {
        return;
    }
    let cancel = Arc::new(AtomicBool::new(false));
    let found = Arc::new(OnceLock::new());
    let samples = samples_of(&view, stop.samples);
    let (scene, guide) = (extracted.scene.clone(), extracted.guide.clone());
    let (result, stopped) = (found.clone(), cancel.clone());
    let wake_up = wake_up.clone();
    let thread = std::thread::Builder::new()
        .name("pilot of auto".to_owned())
        .spawn(move || {
            let choice = catch_unwind(AssertUnwindSafe(|| choose(&scene, &view, &guide, samples, 1, &stopped)));
            // Without a result it would be started again for ever.
            let _ = result.set(choice.ok().flatten().or(Some(Choice::UNTRIED)));
            if let Some(wake) = &wake_up.0 {
                wake();
            }
        });
    match thread {
        Ok(_) => search.0 = Some(RunningPilot { seen, cancel, found }),
        Err(_) => auto.0 = Some((seen, Choice::UNTRIED)),
    }
}

/// Sets the chosen integrator in the view that is rendered.
fn apply(auto: &AutoIntegrator, extracted: &mut Extracted, packed: &mut PackedScene) {
    extracted.take_choice(auto);
    packed.view.clone_from(&extracted.view);
}

/// The choice for the packed scene and view and a picture with this number of samples per pixel; None takes the film's
/// number. An existing choice stays. None without `auto`; an error if it was cancelled.
pub(super) fn find_choice(
    world: &World,
    samples: Option<u32>,
    cancel: &AtomicBool,
) -> Result<Option<Choice>, Cancelled> {
    let control = world.resource::<RenderControl>();
    let extracted = world.resource::<Extracted>();
    let is_asked = is_auto(world.resource(), control);
    let Some(view) = extracted.view.as_ref().filter(|_| is_asked) else {
        return Ok(None);
    };
    let scene = &extracted.scene;
    if let Some(known) = world.resource::<AutoIntegrator>().choice(scene, view) {
        return Ok(Some(known));
    }
    let samples = samples_of(view, samples.unwrap_or(extracted.sample_count));
    let choice = choose(scene, view, &extracted.guide, samples, control.threads.get(), cancel);
    choice.map(Some).ok_or(Cancelled)
}

/// The error that a choice was cancelled.
pub(super) struct Cancelled;

/// Sets the choice for the packed scene and view.
pub fn set_choice(world: &mut World, choice: Choice) {
    world.resource_scope(|world, mut extracted: Mut<Extracted>| {
        let Some(view) = &extracted.view else { return };
        let auto = AutoIntegrator(Some((Seen::of(&extracted.scene, view), choice)));
        apply(&auto, &mut extracted, &mut world.resource_mut::<PackedScene>());
        world.insert_resource(auto);
    });
}

/// Reports the choice in a status.
pub(super) fn report(
    status: &mut RenderStatus,
    (auto, search): (&AutoIntegrator, &PilotSearch),
    extracted: &Extracted,
    settings: &IntegratorSettings,
    control: &RenderControl,
) {
    let is_asked = is_auto(settings, control);
    let Some(view) = extracted.view.as_ref().filter(|_| is_asked) else {
        status.auto = None;
        return;
    };
    let choice = auto.choice(&extracted.scene, view);
    let has_media = view.integrator.settings().media;
    status.auto = Some(AutoStatus {
        integrator: choice
            .unwrap_or(Choice::UNTRIED)
            .or_guided(extracted.guide_is_asked)
            .name(has_media),
        is_searching: search.0.is_some(),
        guide_rays: extracted.guide.rays_of_pilot(),
        choice: choice.unwrap_or(Choice::UNTRIED),
    });
    // A picture that ended with fewer samples starts no pilot.
    let is_sought = search.0.is_some() || status.samples >= FIRST.min(status.target);
    let is_awaited = control.interactive && is_sought && auto.is_awaited(&extracted.scene, view, status.target);
    if status.state == RenderState::Done && is_awaited {
        status.state = RenderState::Rendering;
    }
}
