//! What the light that is wanted needs and takes longer than a frame, on threads of their own: the illuminance that
//! each lamp gives at the painted places, and the search for places, aims and times of lamps.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use bevy::prelude::*;

use super::search::Search;
use crate::color::Rgb;
use crate::engine::placing::{FoundLamps, LampSearch, NoPlace};
use crate::engine::{Lamps, LightGroup, PackedScene, RenderControl, WakeUp};
use crate::render::breakdown::Progress;
use crate::render::lamps_alone::{Quantity, light_of_pixels};
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The most pixels at which illuminance is measured.
pub const MOST_LUX_PIXELS: usize = 1024;
/// The samples of a pixel for each lamp.
const LUX_SAMPLES: u32 = 64;

/// The pixels whose illuminance is asked for.
#[derive(Clone, Debug)]
struct LuxQuestion {
    scene: RenderScene,
    view: View,
    lamps: Arc<Lamps>,
    groups: Arc<[LightGroup]>,
    pixels: Arc<[UVec2]>,
}

impl LuxQuestion {
    fn is_same(&self, other: &Self) -> bool {
        self.pixels == other.pixels
            && self.groups == other.groups
            && self.scene.is_same(&other.scene)
            && self.view == other.view
    }
}

/// The irradiance that each group of lamps gives at some pixels, in W/m².
#[derive(Debug)]
pub struct LuxLight {
    question: LuxQuestion,
    number: HashMap<UVec2, usize>,
    /// By group, then by pixel; None where there is no surface.
    groups: Vec<Vec<Option<Rgb>>>,
}

impl LuxLight {
    /// The irradiance from each group at a pixel; None where there is no surface or nothing was measured.
    pub fn at(&self, x: u32, y: u32) -> Option<impl Iterator<Item = Rgb>> {
        let number = *self.number.get(&UVec2::new(x, y))?;
        self.groups.first()?[number]?;
        Some(self.groups.iter().map(move |light| light[number].unwrap_or(Rgb::ZERO)))
    }

    /// Whether there is a surface at any of the pixels.
    pub fn has_surface(&self) -> bool {
        self.groups.iter().flatten().any(Option::is_some)
    }
}

/// The illuminance at the painted places.
#[derive(Resource, Debug, Default)]
pub struct StrokeLux {
    search: Search<LuxQuestion, LuxLight>,
    known: Option<Arc<LuxLight>>,
}

impl StrokeLux {
    /// Whether it is being measured.
    pub fn is_running(&self) -> bool {
        self.search.is_running()
    }

    /// Takes what was measured. Returns whether measuring has ended since the last time.
    pub fn collect(&mut self) -> bool {
        let was_running = self.search.is_running();
        if let Some((_, light)) = self.search.collect() {
            self.known = Some(Arc::new(light));
        }
        was_running && !self.search.is_running()
    }

    /// Forgets all.
    pub fn forget(&mut self) {
        if self.search.is_running() || self.known.is_some() {
            self.search.cancel();
            self.known = None;
        }
    }

    /// The irradiance at these pixels of a picture of the packed scene. None if it is being measured, which begins
    /// here.
    pub fn at(
        &mut self,
        pixels: Vec<UVec2>,
        (packed, view, groups): (&PackedScene, &View, &Arc<[LightGroup]>),
        threads: usize,
        wake_up: &WakeUp,
    ) -> Option<Arc<LuxLight>> {
        let question = LuxQuestion {
            scene: packed.scene.clone()?,
            view: view.clone(),
            lamps: packed.lamps.clone(),
            groups: groups.clone(),
            pixels: pixels.into(),
        };
        let is_known = |known: &Arc<LuxLight>| known.question.is_same(&question);
        if !self.known.as_ref().is_some_and(is_known) {
            if !self.search.is_about(|asked| asked.is_same(&question)) {
                self.search.start(question, threads, wake_up, measure);
            }
            return None;
        }
        self.known.clone()
    }
}

fn measure(question: LuxQuestion, progress: &Progress) -> Result<LuxLight, String> {
    let of_group = |group: &LightGroup| {
        let lights: Vec<_> = group
            .entities
            .iter()
            .flat_map(|&lamp| question.lamps.of(lamp))
            .collect();
        let alone = question.scene.lit_by_own(&lights);
        light_of_pixels(
            &alone,
            &question.view,
            Quantity::Irradiance,
            &question.pixels,
            LUX_SAMPLES,
            progress.flag(),
        )
    };
    let groups = question.groups.iter().map(of_group).collect::<Option<_>>();
    Ok(LuxLight {
        number: question.pixels.iter().copied().zip(0..).collect(),
        groups: groups.ok_or("the search was given up")?,
        question,
    })
}

/// The search for places, aims and times of lamps.
#[derive(Resource, Debug, Default)]
pub struct LampPlacing {
    search: Search<u64, Result<FoundLamps, NoPlace>>,
    /// The finished share in thousandths.
    done: Arc<AtomicU32>,
}

impl LampPlacing {
    /// The share of the running search that is done at least, from 0 to 1.
    pub fn progress(&self) -> Option<f32> {
        let done = self.done.load(Ordering::Relaxed) as f32 / 1000.0;
        self.search.is_running().then_some(done)
    }

    /// Begins a search in place of the one before. `revision` is that of the painting.
    pub fn start(&mut self, search: LampSearch, revision: u64, control: &RenderControl, wake_up: &WakeUp) {
        self.done = Arc::default();
        let (done, wake) = (self.done.clone(), wake_up.clone());
        let find = move |_: u64, progress: &Progress| {
            let mut watch = |share: f64, _: f64| {
                let share = (1000.0 * share) as u32;
                // A repaint for every percent.
                if share / 10 > done.swap(share, Ordering::Relaxed) / 10
                    && let Some(wake) = &wake.0
                {
                    wake();
                }
            };
            Ok(search.run(progress.flag(), &mut watch))
        };
        self.search.start(revision, control.threads.get(), wake_up, find);
    }

    /// Ends the search.
    pub fn cancel(&mut self) {
        self.search.cancel();
    }

    /// What was found, once, with the revision of the painting that it is for.
    pub fn collect(&mut self) -> Option<(u64, Result<FoundLamps, NoPlace>)> {
        self.search.collect()
    }
}
