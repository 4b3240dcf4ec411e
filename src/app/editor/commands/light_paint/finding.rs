//! Finds the strengths and colours of lamps while one paints.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::prelude::*;

use super::film_lamps::{FilmLamps, LampList, channel_of, corners, resample, targets, wants_lux};
use super::{camera, group_name, is_elsewhere, notes, placing, show};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::{FilmLights, LightMix};
use crate::app::editor::command::light_paint::{Answer, Answered, LightPainting, TargetPicture};
use crate::app::editor::picture::light_search::{LampPlacing, LuxLight, MOST_LUX_PIXELS, StrokeLux};
use crate::color::Rgb;
use crate::engine::{PackedScene, RenderControl, RenderFilm, WakeUp};
use crate::inverse_lighting::{Painting, Unsolvable, solve as solve_observations};

/// The time in a frame for looking at painted pixels. What takes longer goes on in the next frame.
const FRAME: Duration = Duration::from_millis(8);

/// What is known of the light at the painted places.
#[derive(Resource, Default)]
pub struct Observing {
    pub painting: Painting,
    pub list: LampList,
    /// The film that it is of, by its job, and the samples that it had.
    of: Option<(u64, u32)>,
    /// Whether places are left to be looked at.
    is_unfinished: bool,
    picture: Option<Resampled>,
    pub lux: Option<Arc<LuxLight>>,
}

/// A wanted picture in the pixels of the film.
struct Resampled {
    of: Arc<TargetPicture>,
    size: [u32; 2],
    corners: [Vec2; 2],
    pixels: Arc<[Option<Rgb>]>,
}

/// Finds the lamps again when the painting has changed, and when the picture has twice as many samples.
pub fn follow(world: &mut World) {
    let Some(painting) = world.get_resource::<LightPainting>() else {
        return;
    };
    if painting.is_empty() {
        if let Some(mut lux) = world.get_resource_mut::<StrokeLux>() {
            lux.forget();
        }
        placing::forget(world);
        world.remove_resource::<Observing>();
        return;
    }
    placing::follow(world);
    let has_news = world
        .get_resource_mut::<StrokeLux>()
        .is_some_and(|mut lux| lux.collect());
    let film = world.resource::<RenderFilm>();
    if is_elsewhere(world) || !is_lit(film) || film.is_coarse {
        return;
    }
    let painting = world.resource::<LightPainting>();
    let is_due = painting.answered.is_none_or(|answered| {
        answered.revision != painting.revision
            || answered.job != film.job
            || film.samples >= answered.samples.saturating_mul(2)
    });
    let observing = world.get_resource::<Observing>();
    let is_unfinished = observing.is_some_and(|observing| observing.is_unfinished);
    if (is_due || is_unfinished || has_news)
        && let Err(error) = go_on(world, Some(FRAME))
    {
        let answer = Answer {
            notes: vec![error.to_string()],
            ..Answer::default()
        };
        note_answered(world);
        world.resource_mut::<LightPainting>().answer = Some(Arc::new(answer));
    }
}

/// Whether the film has the light of each lamp.
pub(super) fn is_lit(film: &RenderFilm) -> bool {
    film.samples > 0 && film.film.layers().groups > 0 && !film.light_groups.is_empty()
}

/// Finds the lamps with all samples of now.
pub(super) fn solve(world: &mut World) -> Result<(), CommandError> {
    if !is_lit(world.resource::<RenderFilm>()) {
        return Err("The picture does not have the light of each lamp yet.".into());
    }
    if is_elsewhere(world) {
        return Err("The strokes belong to another view.".into());
    }
    go_on(world, None)?;
    match is_measuring(world) {
        true => Err(MEASURING.into()),
        false => Ok(()),
    }
}

/// Whether strokes want illuminance that is not known yet.
pub(super) fn is_measuring(world: &World) -> bool {
    let is_known = world
        .get_resource::<Observing>()
        .is_some_and(|observing| observing.lux.is_some());
    wants_lux(world.resource::<LightPainting>()) && !is_known
}

/// The answer meanwhile.
pub(super) const MEASURING: &str = "The illuminance at the strokes is being measured.";

/// Looks at all that is wanted, for all samples of now.
pub(super) fn observe_all(world: &mut World) -> Result<(), CommandError> {
    observe(world, None).map(|_| ())
}

/// Goes on with looking at what is painted, and finds the lamps and shows their mix when all is known. Without a
/// `budget` that is now.
fn go_on(world: &mut World, budget: Option<Duration>) -> Result<(), CommandError> {
    let start = Instant::now();
    if !observe(world, budget)? {
        return Ok(());
    }
    note_answered(world);
    if is_measuring(world) {
        let answer = Answer {
            notes: vec![MEASURING.to_owned()],
            ..Answer::default()
        };
        world.resource_mut::<LightPainting>().answer = Some(Arc::new(answer));
        return Ok(());
    }
    let observing = world.resource::<Observing>();
    if observing.lux.as_ref().is_some_and(|lux| !lux.has_surface()) {
        return Err("There is no surface where lux are wanted.".into());
    }
    let painting = world.resource::<LightPainting>();
    let film = world.resource::<RenderFilm>();
    let (list, limits) = (&observing.list, observing.list.limits());
    let fit = solve_observations(&observing.painting.observations(), &limits).map_err(refusal)?;
    let mut mix = painting.base.clone();
    for (lamp, gain) in list.lamps.iter().zip(&fit.gains) {
        mix.set(lamp.entity, channel_of(lamp, *gain));
    }
    let names: Vec<String> = (list.lamps.iter())
        .map(|lamp| group_name(world, &film.light_groups[lamp.layer]))
        .collect();
    let notes = notes::notes(painting, &fit, &list.lamps, &names);
    show(world, mix);
    let milliseconds = 1e3 * start.elapsed().as_secs_f32();
    world.resource_mut::<LightPainting>().answer = Some(Arc::new(Answer { notes, milliseconds }));
    Ok(())
}

/// The reason why there is no answer, as a sentence.
pub(super) fn refusal(error: Unsolvable) -> CommandError {
    match error {
        Unsolvable::NoLamps => "No lamp may change: choose some.".into(),
        other => format!("No light was found: {other}.").into(),
    }
}

/// Notes that the painting and the film of now have an answer.
fn note_answered(world: &mut World) {
    let film = world.resource::<RenderFilm>();
    let samples = match world.get_resource::<Observing>().and_then(|observing| observing.of) {
        Some((job, samples)) if job == film.job => samples,
        _ => film.samples,
    };
    let answered = Answered {
        job: film.job,
        samples,
        revision: world.resource::<LightPainting>().revision,
    };
    let camera = camera(world);
    let mut painting = world.resource_mut::<LightPainting>();
    painting.camera = camera;
    painting.answered = Some(answered);
}

/// Looks at the painted places, until the budget is used up. Returns whether all is known.
fn observe(world: &mut World, budget: Option<Duration>) -> Result<bool, CommandError> {
    let start = Instant::now();
    let mut observing = world.remove_resource::<Observing>().unwrap_or_default();
    let result = observing.go_on(world, budget.is_none(), || {
        budget.is_some_and(|budget| start.elapsed() > budget)
    });
    world.insert_resource(observing);
    result
}

impl Observing {
    fn go_on(
        &mut self,
        world: &mut World,
        with_all_samples: bool,
        is_late: impl FnMut() -> bool,
    ) -> Result<bool, CommandError> {
        let painting = world.resource::<LightPainting>();
        let film = world.resource::<RenderFilm>();
        let list = LampList::new(
            film,
            painting,
            world.resource::<LightMix>(),
            world.resource::<FilmLights>(),
        );
        let size = [film.film.width(), film.film.height()];
        let picture = match &painting.picture {
            Some(picture) => Some(self.resampled(picture, size, corners(film))?),
            None => None,
        };
        self.painting
            .set(targets(painting, film, picture), size, list.lamps.len());
        // A film that grows while it is looked at over several frames, and a little afterwards, counts as the same.
        let is_same = self.of.is_some_and(|(job, samples)| {
            let has_few_more = self.is_unfinished || film.samples < samples.saturating_mul(2);
            let is_enough = if with_all_samples {
                film.samples == samples
            } else {
                has_few_more
            };
            job == film.job && is_enough
        });
        if !is_same || !self.list.shines_as(&list) {
            self.painting.forget();
            self.of = Some((film.job, film.samples));
        }
        self.list = list;
        let lux = match wants_lux(painting) {
            true => measured_lux(world, &self.painting),
            false => None,
        };
        if lux.as_ref().map(Arc::as_ptr) != self.lux.as_ref().map(Arc::as_ptr) {
            self.painting.forget_irradiance();
            self.lux = lux;
        }
        let lamps = FilmLamps {
            film: &world.resource::<RenderFilm>().film,
            list: &self.list,
            lux: self.lux.as_deref(),
        };
        self.is_unfinished = !self.painting.observe(&lamps, is_late);
        Ok(!self.is_unfinished)
    }

    fn resampled(
        &mut self,
        picture: &Arc<TargetPicture>,
        size: [u32; 2],
        corners: [Vec2; 2],
    ) -> Result<Arc<[Option<Rgb>]>, CommandError> {
        let is_same =
            |known: &&Resampled| Arc::ptr_eq(&known.of, picture) && (known.size, known.corners) == (size, corners);
        if let Some(known) = self.picture.as_ref().filter(is_same) {
            return Ok(known.pixels.clone());
        }
        let pixels = resample(picture, size, corners)?;
        self.picture = Some(Resampled {
            of: picture.clone(),
            size,
            corners,
            pixels: pixels.clone(),
        });
        Ok(pixels)
    }
}

/// The illuminance at the strokes that want some; None while it is being measured, which begins here.
fn measured_lux(world: &mut World, painting: &Painting) -> Option<Arc<LuxLight>> {
    let pixels = painting.pixels(true, MOST_LUX_PIXELS);
    world.try_resource_scope(|world, mut lux: Mut<StrokeLux>| {
        let film = world.resource::<RenderFilm>();
        let (packed, view) = (world.resource::<PackedScene>(), film.view.as_ref()?);
        let threads = world.resource::<RenderControl>().threads.get();
        let wake_up = world.resource::<WakeUp>();
        lux.at(pixels, (packed, view, &film.light_groups), threads, wake_up)
    })?
}

/// What a script has to wait for, in words: a search that runs.
pub fn search_under_way(world: &World) -> Option<&'static str> {
    let is_placing = |placing: &LampPlacing| placing.progress().is_some();
    if world.get_resource::<StrokeLux>().is_some_and(StrokeLux::is_running) {
        Some("the illuminance at the strokes")
    } else if world.get_resource::<LampPlacing>().is_some_and(is_placing) {
        Some("the places of lamps")
    } else {
        None
    }
}
