//! A bake as a job: it prepares a level, gathers light in rounds that can be watched and cancelled, and makes pictures
//! of the light.
//!
//! A callback gets the progress on the thread that runs the job, between pieces of work of about half a second. It may
//! look at the job meanwhile, for instance to show the unfinished lightmaps.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use glam::{UVec2, Vec3};
use rayon::ThreadPool;

use super::blueprint::{Baked, Blueprint};
use super::error::BakeError;
use super::files::Content;
use super::in_sight::keep_in_sight;
use super::layers::{LampLayers, texture_texels};
use super::level::unwrap_level;
use super::lightmap::Lightmaps;
use super::limits::{BakeLimits, USUAL_SAMPLES};
use super::manifest::BakedLight;
use super::preview::{BakedSurfaces, LitBy, SeenPixels};
use super::probes::{AskedProbe, Probe, ProbeSettings, ProbeSites, plan};
use super::progress::{Gathered, Pace, Progress, Stage, Work, watched};
use super::seams::{Seam, smooth_seams};
use super::sides::lit_sides;
use super::texels::{BakeSurface, Texel, Texels, covered_texels};
use super::unwrap::{Told, UnwrapSettings};
use crate::color::Rgb;
use crate::gltf::write::GltfWriter;
use crate::memory::{self, Reservation, Shortage};
use crate::render::camera::Camera;
use crate::render::gathering::Gathering;
use crate::render::irradiance::ReceivedLight;
use crate::render::light_layers::LightGroups;
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::render::visibility::outer_walls::OuterWalls;
use crate::render::visibility::sight::Sight;

/// The input of a bake.
pub struct BakeSource {
    /// The scene that emits and reflects the light.
    pub scene: RenderScene,
    /// The settings of paths, the medium around all surfaces, and the random numbers with their seed.
    pub view: View,
    /// The level as an unfinished glTF file.
    pub level: GltfWriter,
    /// The probes of the scene.
    pub probes: Vec<AskedProbe>,
    /// The threads that trace rays.
    pub pool: Arc<ThreadPool>,
    /// Whether the lit level will be viewed, see [`BakeJob::see`].
    pub is_seen: bool,
    /// When set, the result of the job is unwanted: it does not even finish the light gathered so far.
    pub discards: Arc<AtomicBool>,
    /// The lamps whose light is kept by itself as well; None for a bake without layers.
    pub layers: Option<LampLayers>,
}

/// The settings of a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeSettings {
    /// The size of lightmaps and of their texels.
    pub unwrap: UnwrapSettings,
    /// The light that the lightmaps hold: all of it, or indirect light alone.
    pub light: BakedLight,
    /// The settings of probes; None for a bake without probes.
    pub probes: Option<ProbeSettings>,
    /// Whether noise is removed.
    pub denoise: bool,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            unwrap: UnwrapSettings::default(),
            light: BakedLight::All,
            probes: Some(ProbeSettings::default()),
            denoise: true,
        }
    }
}

/// How a job has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BakeEnding {
    /// Everything is baked.
    Done,
    /// It was cancelled.
    Cancelled,
}

/// Gets the progress and the job in its present state.
pub type Watch<'a> = &'a mut dyn FnMut(&BakeJob, &Progress);

/// A bake that is prepared or running.
pub struct BakeJob {
    pub(super) blueprint: Blueprint,
    scene: RenderScene,
    view: View,
    pool: Arc<ThreadPool>,
    discards: Arc<AtomicBool>,
    /// The outer walls, which views that pass the backs of surfaces leave out; found when first needed.
    outer_walls: OnceLock<OuterWalls>,
    texels: Texels,
    /// The surfaces with texels, if the level may be viewed.
    surfaces: Vec<BakeSurface>,
    /// The same surfaces with an acceleration structure, made at the first view.
    seen: OnceLock<BakedSurfaces>,
    /// The light of the lightmaps, followed by that of each probe.
    pub(super) lights: Vec<Lightmaps>,
    /// The finished pictures; None before the lightmaps are finished.
    baked: Option<Baked>,
    /// The time spent gathering each element of `lights`.
    pub(super) spent: Vec<Duration>,
    warnings: Vec<String>,
    /// The reserved part of the memory budget.
    pub(super) memory: Vec<Reservation>,
}

impl BakeJob {
    /// Places the probes, unwraps the meshes of the level into lightmaps, and finds the texels. `watch` gets the
    /// progress and the name of the present step.
    pub fn prepare(
        source: BakeSource,
        settings: &BakeSettings,
        cancel: &AtomicBool,
        watch: &mut dyn FnMut(&Progress, &str),
    ) -> Result<Self, BakeError> {
        let BakeSource {
            scene,
            mut view,
            mut level,
            probes,
            pool,
            is_seen,
            discards,
            layers: lamps,
        } = source;
        // Those of the scene are for pictures.
        view.light_groups = LightGroups::default();
        let gathering = Gathering {
            scene: &scene,
            view: &view,
            light: received(settings.light),
        };
        let is_cancelled = || match cancel.load(Ordering::Relaxed) {
            true => Err(BakeError::Cancelled),
            false => Ok(()),
        };
        let plan = match &settings.probes {
            Some(settings) => {
                let (begin, stage) = (Instant::now(), Stage::PlacingProbes);
                let work = &mut Work {
                    pool: &pool,
                    cancel,
                    watch: &mut |done| watch(&Progress::new(stage, done, begin.elapsed()), &stage.words(None)),
                };
                Some(plan(&probes, settings, &gathering, work)?)
            }
            None => None,
        };
        is_cancelled()?;
        let begin = Instant::now();
        let mut unwrapping = |done: f64, words: &str| {
            watch(&Progress::new(Stage::Unwrapping, done, begin.elapsed()), words);
        };
        unwrapping(0.0, &Stage::Unwrapping.words(None));
        let lit = |triangles: &[[Vec3; 3]]| lit_sides(&gathering, triangles, cancel);
        let unwrap = |told: Told| pool.install(|| unwrap_level(&mut level, &settings.unwrap, lit, cancel, told));
        let baked = watched(unwrap, &mut unwrapping);
        is_cancelled()?;
        let baked = baked?;
        let find = || covered_texels(&baked.surfaces, baked.size, baked.pages, cancel);
        let mut texels = pool.install(find);
        is_cancelled()?;
        pool.install(|| keep_in_sight(&mut texels, &scene.geometry, cancel));
        is_cancelled()?;
        if texels.texels.is_empty() {
            return Err(BakeError::NoTexels);
        }
        let mut seams: Vec<Vec<Seam>> = vec![Vec::new(); baked.pages as usize];
        for surface in &baked.surfaces {
            is_cancelled()?;
            seams[surface.page as usize].extend(smooth_seams(surface));
        }
        is_cancelled()?;
        let (probes, memory_of_probes, warnings) = match plan {
            Some(plan) => (plan.probes, Some(plan.memory), plan.warnings),
            None => Default::default(),
        };
        let texels_in_games = texture_texels(texels.size, texels.pages.len(), &probes);
        let division = lamps.as_ref().map(|lamps| lamps.division(texels_in_games, &mut level));
        let blueprint = Blueprint {
            level: level.binary()?,
            light: settings.light,
            seed: view.seed,
            denoise: settings.denoise,
            texels_per_unit: baked.texels_per_unit,
            nodes: baked.nodes,
            places: places(&texels),
            seams,
            probes,
            division: division.unwrap_or_default(),
        };
        let memory_of_layers = memory::reserve(blueprint.memory_of_layers()).map_err(BakeError::MemoryOfLayers)?;
        let layers = blueprint.division.layers.len();
        let lights = blueprint.texel_counts();
        let lights: Vec<Lightmaps> = lights
            .map(|texels| Lightmaps::new(texels).with_layers(layers))
            .collect();
        if let Some(lamps) = lamps {
            view.light_groups = lamps.groups;
        }
        Ok(Self {
            blueprint,
            scene,
            view,
            pool,
            discards,
            outer_walls: OnceLock::new(),
            texels,
            surfaces: if is_seen { baked.surfaces } else { Vec::new() },
            seen: OnceLock::new(),
            spent: vec![Duration::ZERO; lights.len()],
            lights,
            baked: None,
            warnings,
            memory: [baked.layout.memory, memory_of_layers]
                .into_iter()
                .chain(memory_of_probes)
                .collect(),
        })
    }

    /// The prepared level, without light.
    pub fn blueprint(&self) -> &Blueprint {
        &self.blueprint
    }

    /// Sentences about requests that could not be met.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The light of the lightmaps gathered so far; see [`Blueprint::lightmap`].
    pub fn light(&self) -> &Lightmaps {
        &self.lights[0]
    }

    /// The finished pictures; None before the lightmaps are finished.
    pub fn baked(&self) -> Option<&Baked> {
        self.baked.as_ref()
    }

    /// The surfaces that a camera sees in each pixel, without emissive ones if `hides_emitters`. An error if the memory
    /// budget has no room. It traces a ray or two for each pixel; the first call also prepares the surfaces, which have
    /// light if [`BakeSource::is_seen`]. The outer walls of `sight` are replaced by those of the scene of the job.
    pub fn see(
        &self,
        camera: &Camera,
        size: UVec2,
        sight: &Sight,
        hides_emitters: bool,
    ) -> Result<SeenPixels, Shortage> {
        let surfaces = match self.seen.get() {
            Some(surfaces) => surfaces,
            None => {
                let density = self.blueprint.texels_per_unit;
                let prepare = || BakedSurfaces::new(&self.surfaces, &self.texels, density);
                let surfaces = self.pool.install(prepare)?;
                self.seen.get_or_init(|| surfaces)
            }
        };
        let sight = &Sight {
            outer_walls: match sight.passes_backs {
                true => self
                    .outer_walls
                    .get_or_init(|| OuterWalls::find(&self.scene.geometry))
                    .clone(),
                false => OuterWalls::default(),
            },
            ..sight.clone()
        };
        let see = || surfaces.see(&self.scene, camera, size, sight, hides_emitters);
        self.pool.install(see)
    }

    /// The radiance of pixels lit by the present lightmaps, row by row from the top, linear Rec. 709.
    pub fn lit(&self, seen: &SeenPixels) -> Vec<Rgb> {
        let light = match &self.baked {
            Some(baked) => LitBy::Finished(&baked.lightmaps),
            None => LitBy::Gathered(self.light()),
        };
        let surfaces = self.seen.get();
        surfaces.map_or_else(Vec::new, |surfaces| self.pool.install(|| seen.lit(surfaces, light)))
    }

    /// Rays traced, shadow rays included, in all runs of the job.
    pub fn rays(&self) -> u64 {
        self.lights.iter().map(|light| light.rays).sum()
    }

    /// The number of samples that were not finite, which count as black.
    pub fn invalid_samples(&self) -> u64 {
        self.lights.iter().map(|light| light.invalid).sum()
    }

    /// Gathers the light of the lightmaps and finishes them, then does the same for the probes. It ends soon after
    /// `cancel` is set; another call goes on from there.
    pub fn run(&mut self, limits: &BakeLimits, cancel: &AtomicBool, watch: Watch) -> Result<BakeEnding, BakeError> {
        let target = limits.target();
        if self.baked.is_none() {
            if !self.gather(0, target, limits, cancel, watch) {
                return Ok(BakeEnding::Cancelled);
            }
            self.finish_lightmaps(watch)?;
        }
        // The limits of time and noise are for lightmaps only.
        let samples = limits.samples.unwrap_or(USUAL_SAMPLES);
        for number in 0..self.blueprint.probes.len() {
            if self.baked.as_ref().is_some_and(|baked| baked.probes[number].is_some()) {
                continue;
            }
            let target = self.blueprint.probes[number].samples(samples);
            if !self.gather(1 + number, target, &BakeLimits::default(), cancel, watch)
                || !self.finish_probe(number, cancel, watch)?
            {
                return Ok(BakeEnding::Cancelled);
            }
        }
        Ok(BakeEnding::Done)
    }

    /// The amount of light in a bake that is finished now.
    pub fn content(&self) -> Content {
        let probes = self.baked.iter().flat_map(|baked| &baked.probes);
        Content {
            samples: self.light().samples(),
            probes: probes.flatten().count(),
        }
    }

    /// After a cancelled run: finishes lightmaps with the light gathered so far. Unfinished probes are left out. An
    /// error if texels have no light.
    pub fn finish_so_far(&mut self, watch: Watch) -> Result<(), BakeError> {
        match self.lights[0].samples() {
            0 => Err(BakeError::Cancelled),
            _ if self.baked.is_some() => Ok(()),
            _ => self.finish_lightmaps(watch),
        }
    }

    /// Gathers light until a limit is reached; false if cancelled. `number` is 0 for the lightmaps, else the index of a
    /// probe + 1.
    pub(super) fn gather(
        &mut self,
        number: usize,
        target: u32,
        limits: &BakeLimits,
        cancel: &AtomicBool,
        watch: Watch,
    ) -> bool {
        let probe = number.checked_sub(1).map(|number| &self.blueprint.probes[number]);
        let sites = probe.map(Probe::sites);
        let begin = Instant::now();
        let (samples_before, spent_before) = (self.lights[number].mean_samples(), self.spent[number]);
        let mut pace = Pace::new(self.threads());
        let mut noise = self.lights[number].noise();
        loop {
            let light = &self.lights[number];
            let spent = spent_before + begin.elapsed();
            self.spent[number] = spent;
            let traced = (light.mean_samples() - samples_before) * light.texel_count() as f64;
            let progress = Progress {
                stage: if number == 0 {
                    Stage::Lightmaps
                } else {
                    Stage::Probe(number - 1)
                },
                done: limits.done(light, target, spent, noise),
                spent,
                gathered: Some(Gathered {
                    samples: light.samples(),
                    mean_samples: light.mean_samples(),
                    target: match target {
                        u32::MAX => target,
                        _ => target - light.first,
                    },
                    noise,
                    samples_per_second: traced / begin.elapsed().as_secs_f64().max(1e-9),
                }),
            };
            watch(self, &progress);
            if cancel.load(Ordering::Relaxed) {
                return false;
            }
            let light = &self.lights[number];
            // A round that has begun is finished first.
            let is_between_rounds = light.mean_samples() == f64::from(light.samples());
            if light.reached() >= target || is_between_rounds && limits.are_reached(light.samples(), spent, noise) {
                return true;
            }
            let (end, blocks) = (light.round_end(target), pace.blocks());
            if pace.measure(|| self.go_on(number, sites.as_ref(), end, blocks, cancel)) {
                noise = self.lights[number].noise();
            }
        }
    }

    fn go_on(
        &mut self,
        number: usize,
        sites: Option<&ProbeSites>,
        end: u32,
        blocks: usize,
        cancel: &AtomicBool,
    ) -> bool {
        // Punctual lights, which the level has as nodes, light moving objects directly, with shadows.
        let light = match number {
            0 => received(self.blueprint.light),
            _ => ReceivedLight::WithoutPunctual,
        };
        let gathering = Gathering {
            scene: &self.scene,
            view: &self.view,
            light,
        };
        let light = &mut self.lights[number];
        let texels = &self.texels;
        self.pool.install(|| match sites {
            None => light.go_on(&gathering, texels, end, blocks, cancel),
            Some(ProbeSites::Points(texels)) => light.go_on(&gathering, texels, end, blocks, cancel),
            Some(ProbeSites::Outlook(texels)) => light.go_on(&gathering, texels, end, blocks, cancel),
        })
    }

    fn finish_lightmaps(&mut self, watch: Watch) -> Result<(), BakeError> {
        let begin = Instant::now();
        let told = |done| Progress::new(Stage::FinishingLightmaps, done, begin.elapsed());
        let light = &self.lights[0];
        let baked = self
            .blueprint
            .lightmaps(light, self.threads(), &self.discards, |done| watch(self, &told(done)))?;
        self.baked = Some(baked);
        Ok(())
    }

    fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Makes the pictures of a probe. False if cancelled.
    fn finish_probe(&mut self, number: usize, cancel: &AtomicBool, watch: Watch) -> Result<bool, BakeError> {
        let begin = Instant::now();
        let mut told = |done| {
            watch(
                self,
                &Progress::new(Stage::FinishingProbe(number), done, begin.elapsed()),
            )
        };
        let work = &mut Work {
            pool: &self.pool,
            cancel,
            watch: &mut told,
        };
        let probe = self.blueprint.probe(number, &self.lights[1 + number], work)?;
        let is_finished = probe.is_some();
        if let Some((baked, probe)) = self.baked.as_mut().zip(probe) {
            baked.take_probe(number, probe);
        }
        Ok(is_finished)
    }
}

fn received(light: BakedLight) -> ReceivedLight {
    match light {
        BakedLight::All => ReceivedLight::All,
        BakedLight::WithoutDirectPunctual => ReceivedLight::WithoutPunctual,
    }
}

fn places(texels: &Texels) -> Texels<()> {
    let place = |texel: &Texel| Texel {
        place: texel.place,
        receiver: (),
    };
    Texels {
        size: texels.size,
        texels: texels.texels.iter().map(place).collect(),
        pages: texels.pages.clone(),
        spreads: Vec::new(),
    }
}
