//! The job of one picture: a scene and a view that do not change, and the samples so far. Pausing ends the [`Run`], and
//! continuing starts another; the samples stay.

mod beginning;
mod guides;
mod lamps;
mod relight;
mod rounds;
mod state;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::math::{Rect, UVec2};
use crossbeam_channel::TryRecvError;

pub(super) use self::beginning::Beginning;
use self::lamps::Relighting;
pub(super) use self::lamps::Wanted;
use super::adaptation::Adaptation;
use super::backend::{Backend, TileResult};
use super::control::Gate;
use super::deferred_drop::DeferredDrop;
use super::event_loop_waker::EventLoopWaker;
use super::film::RenderFilm;
use super::light_groups::{Lamps, LightGroup};
use super::resolution::is_same_at_other_size;
use super::run::Run;
use super::schedule::{WorkQueue, sort_from_center, tiles_in};
use super::status::Outdated;
use super::stop_condition::{JudgedNoise, Rounds, SAMPLES_AROUND_FILM, StopCondition, StopReason};
use crate::render::clamp::BrightnessLimit;
use crate::render::noise::PictureNoise;
use crate::render::noise::replicas::Replicas;
use crate::render::passes::pass_end;
use crate::render::scene::RenderScene;
use crate::render::shutter::Shutter;
use crate::render::tile::{Tile, TilePreview, TileSamples, tiles};
use crate::render::view::{Integrator, View};

/// The edge of preview blocks around a region, in a picture that begins without a preview.
const STEP_AROUND_REGION: u32 = 2;

/// Results that have been added to the film, to be dropped.
#[derive(Default)]
struct Spent {
    samples: Vec<TileSamples>,
    previews: Vec<Option<TilePreview>>,
}

pub(super) struct Job {
    pub scene: RenderScene,
    pub view: View,
    shutter: Option<Shutter>,
    /// The lights of each group of the view.
    pub light_groups: Arc<[LightGroup]>,
    pub begun: Instant,
    /// Whether the resolution is lower than asked for.
    pub is_coarse: bool,
    /// The first sample, if the picture is a share.
    pub share: Option<u32>,
    /// The time of the change that led to this job; taken by its first tile.
    pub since: Option<Instant>,
    pub rays: u64,
    /// The part of `rays` by which a guide was learnt.
    pub guide_rays: u64,
    /// The number of camera samples collected, over all pixels.
    pub samples: u64,
    pub invalid: u64,
    pub failure: Option<String>,
    /// The relative noise within the region, for the samples collected.
    pub noise: Option<f32>,
    noise_of_tiles: PictureNoise,
    /// The noise when all pixels of the region last had the same number of samples.
    judged: Option<JudgedNoise>,
    /// The settings that ask for the current round, and its end in samples.
    round: (Rounds, u32),
    adaptation: Adaptation,
    /// None until a limit of noise is set.
    replicas: Option<Replicas>,
    tiles: Arc<[Tile]>,
    region: Option<Rect>,
    /// The indices in `tiles` of the tiles in the region.
    active: Vec<usize>,
    /// The number of samples in the film for each tile.
    done: Vec<u32>,
    /// The numbers of samples at which a pass ended early, because they were the target at that time.
    cuts: BTreeSet<u32>,
    /// The exact numbers of samples that were requested and reached.
    stops: BTreeSet<u32>,
    /// Results that arrived before earlier samples of the same tile, by tile and first sample.
    early: BTreeMap<(usize, u32), TileSamples>,
    /// The lights of the scene.
    lamps: Arc<Lamps>,
    relighting: Relighting,
    beginning: Beginning,
    /// Whether it resumes an older picture, of which only previews around the region are missing.
    is_resumed: bool,
    /// The tiles whose G-buffer is requested and not yet collected.
    gbuffer_left: BTreeSet<usize>,
    /// The number of tiles whose preview is not yet collected.
    preview_left: usize,
    run: Option<Run>,
    running_since: Option<Instant>,
    ran: Duration,
    /// The processor time of the workers of earlier runs.
    worked: Duration,
}

impl Job {
    pub fn new(
        scene: RenderScene,
        view: View,
        shutter: Option<Shutter>,
        lamps: Arc<Lamps>,
        light_groups: Arc<[LightGroup]>,
        beginning: Beginning,
        is_coarse: bool,
        since: Option<Instant>,
    ) -> Self {
        let mut order = tiles(view.width, view.height);
        sort_from_center(&mut order, view.width, view.height);
        let adaptation = Adaptation::new(&order, view.width);
        Self {
            scene,
            view,
            shutter,
            light_groups,
            begun: Instant::now(),
            since,
            is_coarse,
            share: None,
            rays: 0,
            guide_rays: 0,
            samples: 0,
            invalid: 0,
            failure: None,
            noise: None,
            noise_of_tiles: PictureNoise::new(order.len()),
            judged: None,
            round: (Rounds::default(), 0),
            adaptation,
            replicas: None,
            region: None,
            active: (0..order.len()).collect(),
            done: vec![0; order.len()],
            cuts: BTreeSet::new(),
            stops: BTreeSet::new(),
            early: BTreeMap::new(),
            lamps,
            relighting: Relighting::default(),
            is_resumed: false,
            gbuffer_left: BTreeSet::new(),
            preview_left: order.len(),
            beginning,
            tiles: order.into(),
            run: None,
            running_since: None,
            ran: Duration::ZERO,
            worked: Duration::ZERO,
        }
    }

    /// Whether it renders exactly this scene and view, with these light groups.
    pub fn is_of(&self, scene: &RenderScene, view: &View, light_groups: &[LightGroup]) -> bool {
        self.view == *view && *self.light_groups == *light_groups && self.is_of_scene(scene)
    }

    /// The brightness limit of samples; None without a clamp, and until the limit is known.
    pub fn clamped(&self) -> Option<BrightnessLimit> {
        match &self.shutter {
            Some(shutter) => shutter.clamped(),
            None => self.view.clamp.as_ref()?.found(),
        }
    }

    /// Whether its samples see the moments of this shutter.
    pub fn has_shutter(&self, shutter: Option<&Shutter>) -> bool {
        match (&self.shutter, shutter) {
            (Some(own), Some(other)) => own.is_same(other),
            (own, other) => own.is_none() && other.is_none(),
        }
    }

    fn is_of_scene(&self, scene: &RenderScene) -> bool {
        self.scene.is_same(scene)
    }

    /// Whether it renders the same picture with another number of pixels, or by another integrator.
    pub fn sees_the_same(&self, scene: &RenderScene, view: &View) -> bool {
        let own = View {
            integrator: view.integrator,
            ..self.view.clone()
        };
        self.view != *view && self.is_of_scene(scene) && is_same_at_other_size(&own, view)
    }

    /// The change since the picture was begun, if rendering now would give another one. Another number of pixels does
    /// not count, nor does a choice of the integrator `auto`.
    pub fn outdated(&self, scene: &RenderScene, view: &View) -> Option<Outdated> {
        if !self.is_of_scene(scene) || self.view.integrator.settings() != view.integrator.settings() {
            return Some(Outdated::Scene);
        }
        let own = View {
            integrator: view.integrator,
            guide: view.guide.clone(),
            ..self.view.clone()
        };
        (!is_same_at_other_size(&own, view)).then_some(Outdated::View)
    }

    pub fn is_running(&self) -> bool {
        self.run.is_some()
    }

    pub fn preview_pending(&self) -> bool {
        self.preview_left > 0
    }

    /// The number of samples that every pixel of the region has.
    pub fn least_samples(&self) -> u32 {
        self.active.iter().map(|&index| self.done[index]).min().unwrap_or(0)
    }

    /// The limit of `stop` that is reached, if any.
    pub fn reached(&self, stop: &StopCondition) -> Option<StopReason> {
        let samples = self.least_samples();
        // A limit that is set after the noise was judged applies at the end of the current pass.
        let judged = self.judged_at(samples).filter(|_| self.are_equal(samples));
        let judged = judged.filter(|judged| judged.is_corrected || !self.has_replicas_at(samples));
        stop.reached(samples, self.seconds(), judged.map(|judged| judged.noise))
    }

    /// Whether continuing leads to a picture of exactly this number of samples, summed up in the same passes as if
    /// nothing else had been rendered before. Tiles outside of the region have the samples of an earlier exact picture,
    /// or none.
    pub fn can_end_exactly_at(&self, samples: u32) -> bool {
        let mut is_active = vec![false; self.tiles.len()];
        self.active.iter().for_each(|&index| is_active[index] = true);
        let is_as_asked = |(&done, is_active): (&u32, bool)| match is_active {
            true => done <= samples,
            false => done == 0 || self.stops.contains(&done),
        };
        self.done.iter().zip(is_active).all(is_as_asked)
            && self.cuts.range(..samples).next().is_none()
            && !self.adaptation.has_differences(&Vec::from_iter(0..self.tiles.len()))
    }

    /// Restricts rendering to the region from now on; the samples of other tiles stay.
    fn set_region(&mut self, region: Option<Rect>, film: &mut RenderFilm) {
        if self.region != region {
            self.pause();
            self.correct_noise(1.0, film);
            self.region = region;
            self.active = tiles_in(region, &self.tiles, UVec2::new(self.view.width, self.view.height));
            self.noise = None;
            self.judged = None;
            self.replicas = None;
            self.round = (Rounds::default(), 0);
        }
    }

    /// Time spent rendering.
    pub fn seconds(&self) -> f64 {
        let now = self.running_since.map_or(Duration::ZERO, |since| since.elapsed());
        (self.ran + now).as_secs_f64()
    }

    /// The processor time of all workers together on this job's items.
    pub fn worked(&self) -> Duration {
        self.worked + self.run.as_ref().map_or(Duration::ZERO, Run::worked)
    }

    /// Starts or continues the job, or pauses it if a limit of `stop` is reached.
    pub fn run(
        &mut self,
        backend: &Backend,
        stop: &StopCondition,
        film: &mut RenderFilm,
        waker: EventLoopWaker,
        gate: &Gate,
    ) {
        let has_surroundings = || self.done.iter().all(|&done| done >= SAMPLES_AROUND_FILM);
        let region = stop.region.or_else(|| stop.film.filter(|_| has_surroundings()));
        self.set_region(region, film);
        let reached = self.reached(stop);
        if stop.is_exact && reached.is_some() && !self.is_running() {
            self.stops.insert(stop.samples);
        }
        if matches!(reached, Some(StopReason::Time | StopReason::Noise)) {
            self.pause();
        }
        // All samples of a round see the same photons.
        let is_adaptive = stop.is_adaptive && !matches!(self.view.integrator, Integrator::Merging(..));
        let asked = (stop.noise, is_adaptive);
        if let Some(run) = &self.run {
            if film.is_of(self.begun)
                && let Some(urgent) = film.take_urgent()
            {
                run.queue.set_urgent(self.indices_of(urgent));
            }
            if self.round.0 != asked {
                // A round begins as soon as all pixels have the same number of samples.
                let is_divided = asked != Rounds::default() || self.adaptation.has_differences(&self.active);
                self.round = (asked, if is_divided { run.queue.finish_pass() } else { u32::MAX });
            }
            run.queue.set_target(stop.samples.min(self.round.1));
            return;
        }
        if self.failure.is_some() || reached.is_some() {
            return;
        }
        let step = match self.beginning {
            Beginning::Whole => STEP_AROUND_REGION,
            Beginning::Preview(step) => step,
        };
        let previews = match self.preview_left {
            0 => Vec::new(),
            _ => self.previews(),
        };
        self.preview_left = previews.len();
        // Samples continue as without an interruption, not with the previews.
        let queue = match self.is_resumed && !previews.is_empty() {
            true => WorkQueue::new(&[], 0, &previews, step),
            false => self.next_queue(stop, asked, film, &previews, step),
        };
        // In the order of the tiles, which begins at the centre of the picture.
        queue.begin_with_gbuffer(self.gbuffer_left.iter().copied());
        if film.is_of(self.begun) {
            queue.set_urgent(self.indices_of(film.urgent()));
        }
        self.running_since = Some(Instant::now());
        let work = backend.work(
            self.scene.clone(),
            self.view.clone(),
            self.shutter.clone(),
            self.tiles.clone(),
        );
        let first = self.gbuffer_left.len() + self.preview_left;
        self.run = Some(Run::start(backend, queue, first, work, waker, gate.clone()));
    }

    /// The indices of some tiles of the picture, in ascending order.
    fn indices_of(&self, some: &HashSet<Tile>) -> Vec<usize> {
        let indices = 0..self.tiles.len();
        indices.filter(|&index| some.contains(&self.tiles[index])).collect()
    }

    /// The tiles with a coarse preview, those of the region first. Nothing of an older picture may stay around the
    /// region, however the picture begins.
    fn previews(&self) -> Vec<usize> {
        let mut is_active = vec![false; self.tiles.len()];
        self.active.iter().for_each(|&index| is_active[index] = true);
        let inside = self
            .active
            .iter()
            .copied()
            .filter(|_| self.beginning != Beginning::Whole && !self.is_resumed);
        inside
            .chain((0..self.tiles.len()).filter(|&index| !is_active[index]))
            .collect()
    }

    /// Stops the workers; undelivered results are lost and will be rendered again.
    pub fn pause(&mut self) {
        self.worked = self.worked();
        self.run = None;
        self.early.clear();
        if let Some(since) = self.running_since.take() {
            self.ran += since.elapsed();
        }
    }

    /// Tells the workers to stop, before the job is dropped.
    pub fn cancel(&self) {
        if let Some(run) = &self.run {
            run.cancel();
        }
    }

    /// Makes the current pass the last one, and returns the samples at its end.
    pub fn finish_pass(&self) -> Option<u32> {
        self.run.as_ref().map(|run| run.queue.finish_pass())
    }

    /// Whether there are results to collect.
    pub fn has_results(&self) -> bool {
        self.run.as_ref().is_some_and(|run| !run.results.is_empty())
    }

    /// The time at which a worker of the current run finished its first tile.
    pub fn first_result(&self) -> Option<Instant> {
        self.run.as_ref()?.first_result.get().copied()
    }

    /// Makes the film that of this job. Returns the previews of the previous picture.
    pub fn begin_in(&self, film: &mut RenderFilm) -> Vec<Option<TilePreview>> {
        let is_new = !film.is_of(self.begun);
        let previews = film.begin(self.begun, &self.view, &self.light_groups, self.is_coarse);
        if is_new && self.share.is_some_and(|first| first > 0) {
            film.film.keep_chunks();
        }
        previews
    }

    /// Adds the results that have arrived to the film, until `deadline`. Returns the number of tiles. Memory that is no
    /// longer needed goes to `deferred`.
    pub fn collect(&mut self, film: &mut RenderFilm, deadline: Instant, deferred: &DeferredDrop) -> usize {
        let mut collected = 0;
        let mut spent = Spent::default();
        while let Some(run) = &self.run {
            match run.results.try_recv() {
                Ok(result) => collected += self.take(result, film, &mut spent),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => self.pause(),
            }
            if Instant::now() >= deadline {
                break;
            }
        }
        if collected > 0 {
            deferred.drop_later(spent);
            self.settle(film);
        }
        collected
    }

    /// Adds a result to the film. Returns the number of results that this completes.
    fn take(&mut self, result: TileResult, film: &mut RenderFilm, spent: &mut Spent) -> usize {
        match result {
            TileResult::GBuffer { index, tile } => {
                spent.previews.extend(self.begin_in(film));
                self.rays += tile.rays;
                self.gbuffer_left.remove(&index);
                film.gbuffer.push(tile);
                1
            }
            TileResult::Preview(preview) => {
                spent.previews.extend(self.begin_in(film));
                self.rays += preview.rays;
                self.preview_left -= 1;
                film.is_lit = true;
                film.mark(preview.tile);
                film.film.add_preview(preview);
                1
            }
            TileResult::Replicas(rendered) => {
                self.rays += rendered.rays;
                if let Some(replicas) = &mut self.replicas {
                    replicas.add(&rendered);
                }
                1
            }
            TileResult::Samples { index, samples } => {
                spent.previews.extend(self.begin_in(film));
                self.early.insert((index, samples.samples.start), samples);
                self.add_in_order(index, film, spent);
                1
            }
            TileResult::Failed(text) => {
                self.failure = Some(text);
                self.pause();
                0
            }
        }
    }

    /// Updates the values of the whole picture that depend on its tiles.
    fn settle(&mut self, film: &mut RenderFilm) {
        self.count_rays_of_guides();
        let samples = self.least_samples();
        if film.film.has_splats() && samples > film.samples {
            self.tiles.iter().for_each(|&tile| film.mark(tile));
        }
        film.samples = samples;
        self.forget_lamps();
        self.judge(film);
        self.note_noise();
    }

    fn add_in_order(&mut self, index: usize, film: &mut RenderFilm, spent: &mut Spent) {
        while let Some(samples) = self.early.remove(&(index, self.done[index])) {
            spent.previews.push(film.film.add(&samples));
            film.is_lit = true;
            film.mark(samples.tile);
            self.noise_of_tiles.update(index, &film.film, samples.tile);
            self.done[index] = samples.samples.end;
            self.adaptation.note(index, &samples, &film.film);
            if samples.blocks.is_none() && samples.samples.end != pass_end(samples.samples.start) {
                self.cuts.insert(samples.samples.end);
            }
            self.rays += samples.rays;
            self.invalid += u64::from(samples.invalid);
            self.samples += samples.total();
            spent.samples.push(samples);
        }
    }
}
