//! The meters of the open scene: they are measured on threads of low priority once the picture can be judged, and again
//! after every change.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use rayon::ThreadPool;

use crate::app::editor::command::meter_choice::MeterChoice;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::metering::{MeterParts, Upward, meters_among, under_overcast_sky, upward};
use crate::app::threads::worker_count;
use crate::engine::{PackedScene, RenderState, RenderStatus, WakeUp, yield_to_rendering};
use crate::meter::glare::{Glare, glare};
use crate::meter::job::{MeterEnd, MeterJob, MeterReading, finds_no_light};
use crate::meter::sites::{AskedMeter, MeterLimits};
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::scene::Hidden;

/// The samples per pixel that the picture has before the meters take their share of the cores.
const PICTURE_FIRST: u32 = 16;
/// The time between two reports of values.
const BETWEEN: Duration = Duration::from_millis(150);
/// The limits of a measurement.
const END: MeterEnd = MeterEnd {
    noise: 0.005,
    samples: 1 << 18,
    time: Some(Duration::from_secs(30)),
};

/// The meters with their last values, for the window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShownMeters {
    /// The meters that are not hidden, in the order of the file.
    pub meters: Vec<ShownMeter>,
    /// Whether the values are becoming more exact, or are of the scene before the last change.
    pub is_measuring: bool,
    /// The reason why nothing is measured, as a sentence without a full stop.
    pub error: Option<String>,
    /// The quantities that are measured.
    pub choice: MeterChoice,
    /// The upward direction of the overcast sky under which daylight factors are measured.
    pub up: Option<Upward>,
    /// The glare of the view; None until it has been rated.
    pub glare: Option<Glare>,
}

/// A meter with its last values.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownMeter {
    /// The entity that a click selects.
    pub entity: Entity,
    /// The name.
    pub name: String,
    /// The last values; None before the first ones.
    pub reading: Option<MeterReading>,
}

/// The measurement of the open scene's meters.
#[derive(Resource, Default)]
pub(crate) struct Metering {
    measurement: Option<Measurement>,
    shown: Arc<ShownMeters>,
}

/// What was asked for, and the work on it.
struct Measurement {
    scene: RenderScene,
    view: View,
    asked: Vec<(Entity, AskedMeter)>,
    choice: MeterChoice,
    /// The upward direction of the overcast sky; None under the lights of the scene.
    up: Option<Upward>,
    /// Whether the thread has been started.
    is_begun: bool,
    cancel: Arc<AtomicBool>,
    reports: Arc<Mutex<Reports>>,
}

/// What the thread has reported and the window has not taken.
#[derive(Default)]
struct Reports {
    readings: Option<Vec<MeterReading>>,
    glare: Option<Glare>,
    ended: Option<Result<(), String>>,
}

impl Drop for Measurement {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

fn lock(reports: &Mutex<Reports>) -> MutexGuard<'_, Reports> {
    reports.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Metering {
    /// What the window shows.
    pub fn shown(&self) -> &Arc<ShownMeters> {
        &self.shown
    }

    /// Asks for these meters in place of what was asked for before. Old values stay until there are new ones.
    fn ask(
        &mut self,
        scene: &RenderScene,
        view: &View,
        asked: Vec<(Entity, AskedMeter)>,
        choice: MeterChoice,
        up: Option<Upward>,
    ) {
        // Lux are no daylight factors.
        let is_comparable = self.shown.choice.daylight == choice.daylight;
        let before = |entity: Entity| {
            let known = self.shown.meters.iter().find(|meter| meter.entity == entity)?;
            known.reading.clone().filter(|_| is_comparable)
        };
        let meters = asked.iter().map(|(entity, asked)| ShownMeter {
            entity: *entity,
            name: asked.name.clone(),
            reading: before(*entity),
        });
        self.shown = Arc::new(ShownMeters {
            meters: meters.collect(),
            is_measuring: true,
            error: finds_no_light(view).then(|| "max_depth 1 ends paths before any light".to_owned()),
            choice,
            up,
            glare: self.shown.glare.filter(|_| is_comparable && choice.glare),
        });
        self.measurement = Some(Measurement {
            scene: scene.clone(),
            view: view.clone(),
            asked,
            choice,
            up,
            is_begun: false,
            cancel: Arc::default(),
            reports: Arc::default(),
        });
    }

    /// Takes what the thread has reported.
    fn collect(&mut self) {
        let Some(measurement) = &self.measurement else { return };
        let Reports { readings, glare, ended } = std::mem::take(&mut *lock(&measurement.reports));
        if readings.is_none() && glare.is_none() && ended.is_none() {
            return;
        }
        let shown = Arc::make_mut(&mut self.shown);
        for (meter, reading) in shown.meters.iter_mut().zip(readings.into_iter().flatten()) {
            meter.reading = Some(reading);
        }
        shown.glare = glare.or(shown.glare);
        if let Some(ended) = ended {
            shown.is_measuring = false;
            shown.error = ended.err().or(shown.error.take());
        }
    }
}

impl Measurement {
    fn is_of(&self, scene: &RenderScene, view: &View, asked: &[(Entity, AskedMeter)], choice: MeterChoice) -> bool {
        let is_same_view = self.view.integrator == view.integrator
            && self.view.medium == view.medium
            && self.view.sequence == view.sequence
            && self.view.seed == view.seed;
        // Glare depends on the place and the direction of the eye.
        let is_same_eye = !choice.glare || self.view.camera == view.camera;
        is_same_view && is_same_eye && self.choice == choice && self.scene.is_same(scene) && self.asked == asked
    }

    /// Starts the thread.
    fn begin(&mut self, wake: &WakeUp) {
        self.is_begun = true;
        let asked = self.asked.iter().map(|(_, asked)| asked.clone()).collect();
        let (scene, view) = (self.scene.clone(), self.view.clone());
        let (up, rates_glare) = (self.up, self.choice.glare);
        let (cancel, reports, wake) = (self.cancel.clone(), self.reports.clone(), wake.clone());
        let work = move || {
            let measured = catch_unwind(AssertUnwindSafe(|| {
                let (scene, view) = match up {
                    Some(up) => under_overcast_sky(&scene, &view, up.direction),
                    None => (scene, view),
                };
                let rated = rates_glare.then(|| (scene.clone(), view.clone()));
                let pool = measure(scene, &view, asked, &cancel, &reports, &wake)?;
                if let Some((scene, view)) = rated {
                    let glare = pool.install(|| glare(&scene, &view, &view.of_film(), &cancel));
                    lock(&reports).glare = glare;
                }
                Ok(())
            }));
            lock(&reports).ended = Some(measured.unwrap_or_else(|_| Err("measuring has failed".to_owned())));
            tell(&wake);
        };
        if let Err(error) = std::thread::Builder::new().name("meters".to_owned()).spawn(work) {
            lock(&self.reports).ended = Some(Err(format!("no thread could be started for the meters: {error}")));
        }
    }
}

fn tell(wake: &WakeUp) {
    if let Some(wake) = &wake.0 {
        wake();
    }
}

/// Measures on this thread and on others of its priority, which are returned.
fn measure(
    scene: RenderScene,
    view: &View,
    asked: Vec<AskedMeter>,
    cancel: &AtomicBool,
    reports: &Mutex<Reports>,
    wake: &WakeUp,
) -> Result<Arc<ThreadPool>, String> {
    yield_to_rendering();
    let mut job = MeterJob::new(scene, view, asked).map_err(|error| error.to_string())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(worker_count(None, true).get());
    let pool = Arc::new(pool.build().map_err(|error| error.to_string())?);
    let mut last: Option<Instant> = None;
    let report = |job: &MeterJob| {
        if let Some(readings) = job.readings() {
            lock(reports).readings = Some(readings);
            tell(wake);
        }
    };
    job.run(&END, &pool, cancel, &mut |job, _| {
        if last.is_none_or(|last| last.elapsed() >= BETWEEN) {
            last = Some(Instant::now());
            report(job);
        }
    });
    report(&job);
    Ok(pool)
}

/// Follows the meters of the scene, and measures them anew when something has changed.
pub(crate) fn follow_meters(
    mut metering: ResMut<Metering>,
    packed: Res<PackedScene>,
    status: Res<RenderStatus>,
    wake: Res<WakeUp>,
    settings: Res<ViewSettings>,
    emitters: Query<MeterParts<'static>, Without<Hidden>>,
) {
    let mut asked = meters_among(emitters.iter());
    let choice = settings.meters;
    if choice.daylight {
        // The limits are asked of the lights of the scene.
        asked
            .iter_mut()
            .for_each(|(_, asked)| asked.limits = MeterLimits::default());
    }
    let is_idle = asked.is_empty() && !choice.glare;
    let (Some(scene), Some(view), false) = (&packed.scene, &packed.view, is_idle) else {
        if metering.measurement.is_some() {
            *metering = Metering::default();
        }
        return;
    };
    let is_same = |measurement: &Measurement| measurement.is_of(scene, view, &asked, choice);
    if !metering.measurement.as_ref().is_some_and(is_same) {
        let up = choice.daylight.then(|| upward(emitters.iter(), view));
        metering.ask(scene, view, asked, choice, up);
    }
    let is_judged = status.samples >= PICTURE_FIRST || matches!(status.state, RenderState::Done | RenderState::Paused);
    if let Some(measurement) = metering
        .measurement
        .as_mut()
        .filter(|measurement| !measurement.is_begun)
        && status.is_up_to_date
        && is_judged
    {
        measurement.begin(&wake);
    }
    metering.collect();
}
