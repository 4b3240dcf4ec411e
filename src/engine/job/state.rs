//! The state of a job in a checkpoint, beside the film: enough to continue as if it had not been interrupted.

use bevy::math::{Rect, UVec2, Vec2};

use super::Job;
use crate::engine::film::RenderFilm;
use crate::engine::stop_condition::JudgedNoise;
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::film::Film;
use crate::render::noise::replicas::Replicas;
use crate::render::tile::Tile;

impl Job {
    /// Writes the state. Unfinished passes are not saved; they are rendered again.
    pub fn write(&self) -> Vec<u8> {
        let mut to = Writer::default();
        to.put_all(&self.done);
        to.put(self.cuts.len() as u32);
        self.cuts.iter().for_each(|&cut| to.put(cut));
        to.put([self.rays, self.samples, self.invalid]);
        to.put(self.seconds());
        to.put(u32::from(self.region.is_some()));
        if let Some(Rect { min, max }) = self.region {
            to.put([min, max]);
        }
        let ((noise, is_adaptive), end) = self.round;
        write_optional(noise, &mut to);
        to.put([u32::from(is_adaptive), end, u32::from(self.judged.is_some())]);
        if let Some(judged) = self.judged {
            to.put(judged.samples);
            write_optional(judged.noise, &mut to);
            to.put(u32::from(judged.is_corrected));
        }
        to.put(u32::from(self.replicas.is_some()));
        if let Some(replicas) = &self.replicas {
            to.put(self.noise_of_tiles.correction());
            replicas.write(&mut to);
        }
        self.adaptation.write(&mut to);
        to.0
    }

    /// Restores the state that [`Self::write`] has written for the same picture, and its film. The job has not run yet.
    /// The region must be that of the saved job, to which the current round, the judged noise and the replicas belong.
    /// [`Damaged`] if the state ends too early or is inconsistent.
    pub fn resume(&mut self, state: &[u8], saved: Film, film: &mut RenderFilm) -> Result<(), Damaged> {
        let mut from = Reader(state);
        from.fill(&mut self.done)?;
        for _ in 0..from.take::<u32>()? {
            self.cuts.insert(from.take()?);
        }
        (self.rays, self.samples, self.invalid) = (from.count()?, from.count()?, from.count()?);
        self.ran = from.duration()?;
        let region = read_region(&mut from)?;
        self.set_region(region, film);
        let (noise, is_adaptive) = (read_optional(&mut from)?, from.flag()?);
        self.round = ((noise, is_adaptive), from.take()?);
        self.judged = match from.flag()? {
            true => Some(JudgedNoise {
                samples: from.take()?,
                noise: read_optional(&mut from)?,
                is_corrected: from.flag()?,
            }),
            false => None,
        };
        let mut correction = 1.0;
        if from.flag()? {
            correction = from.finite()?;
            Damaged::unless(correction > 0.0)?;
            // Replicas are chosen by the errors of pixels, which have two samples.
            let is_known = |(tile, done): (&Tile, &u32)| {
                let mut pixels =
                    (tile.y..tile.y + tile.height).flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| (x, y)));
                pixels.all(|(x, y)| saved.samples(x, y) >= (*done).min(2))
            };
            Damaged::unless(self.tiles.iter().zip(&self.done).all(is_known))?;
            let size = UVec2::new(self.view.width, self.view.height);
            self.replicas = Some(Replicas::read(&mut from, size)?);
        }
        self.adaptation.read(&mut from)?;
        self.is_resumed = true;
        film.begin_with(self.begun, &self.view, &self.light_groups, self.is_coarse, saved);
        (film.samples, film.is_lit) = (self.least_samples(), true);
        for (index, &tile) in self.tiles.iter().enumerate().filter(|(index, _)| self.done[*index] > 0) {
            self.noise_of_tiles.update(index, &film.film, tile);
            film.mark(tile);
        }
        self.correct_noise(correction, film);
        self.note_noise();
        Ok(())
    }
}

fn read_region(from: &mut Reader) -> Result<Option<Rect>, Damaged> {
    if !from.flag()? {
        return Ok(None);
    }
    let mut sides = [0.0; 4];
    from.finites(&mut sides)?;
    let [left, top, right, bottom] = sides;
    Ok(Some(Rect {
        min: Vec2::new(left, top),
        max: Vec2::new(right, bottom),
    }))
}

fn write_optional(number: Option<f32>, to: &mut Writer) {
    to.put(u32::from(number.is_some()));
    to.put(number.unwrap_or(0.0));
}

fn read_optional(from: &mut Reader) -> Result<Option<f32>, Damaged> {
    let (is_there, number) = (from.flag()?, from.finite()?);
    Ok(is_there.then_some(number))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;
    use std::time::{Duration, Instant};

    use bevy::asset::AssetPlugin;
    use bevy::prelude::*;

    use super::*;
    use crate::color::Rgb;
    use crate::engine::backend::{Backend, Work};
    use crate::engine::job::{Beginning, Spent};
    use crate::engine::packed_scene::PackedScene;
    use crate::engine::stop_condition::{FilmLimits, StopCondition};
    use crate::engine::{EnginePlugin, RenderControl};
    use crate::render::scene::RenderScene;
    use crate::render::tile::Tile;
    use crate::render::view::View;
    use crate::sampling::hash::pcg4d;
    use crate::scene::{
        ActiveSensor, AreaLight, DocumentOrder, Emitter, EmitterKind, IntegratorSettings, ScenePlugin, Sensor, Shape,
        ShapeKind, Strategy, ToWorld,
    };

    /// A ball in front of an even sky, and a lamp that is found by chance, so that some pixels are much noisier than
    /// others. Two tiles by two, of which three are small.
    fn scene_and_view() -> (RenderScene, View) {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), ScenePlugin, EnginePlugin));
        let world = app.world_mut();
        let radiance = Rgb::splat(0.5);
        world.spawn((DocumentOrder(0), Emitter::from(EmitterKind::Constant { radiance })));
        let sphere = |center, radius| Shape {
            kind: ShapeKind::Sphere { center, radius },
            ..Shape::default()
        };
        world.spawn((DocumentOrder(1), sphere(Vec3::Z * 4.0, 1.0)));
        let lamp = AreaLight {
            radiance: Rgb::splat(40.0).into(),
            ..default()
        };
        world.spawn((DocumentOrder(2), sphere(Vec3::new(0.8, 1.5, 2.6), 0.2), lamp));
        let film = crate::scene::Film {
            width: 40,
            height: 36,
            ..default()
        };
        let sensor = world.spawn((DocumentOrder(3), Sensor::default(), ToWorld::default(), film));
        let sensor = sensor.id();
        world.insert_resource(ActiveSensor(Some(sensor)));
        let mut integrator = world.resource_mut::<IntegratorSettings>();
        (integrator.strategy, integrator.max_depth) = (Strategy::Bsdf, Some(2));
        world.resource_mut::<RenderControl>().paused = true;
        let begin = Instant::now();
        loop {
            app.update();
            let PackedScene { scene, view, .. } = app.world().resource();
            if let (Some(scene), Some(view)) = (scene, view) {
                return (scene.clone(), view.clone());
            }
            assert!(begin.elapsed() < Duration::from_secs(600), "the scene is not packed");
        }
    }

    struct Picture {
        job: Job,
        film: RenderFilm,
        work: Box<Work>,
    }

    impl Picture {
        fn new(scene: &RenderScene, view: &View) -> Self {
            let (scene, view) = (scene.clone(), view.clone());
            let backend = Backend::cpu(1, false).expect("a thread can be started");
            let job = Job::new(
                scene,
                view,
                None,
                Default::default(),
                Default::default(),
                Beginning::Whole,
                false,
                None,
            );
            Self {
                work: backend.work(job.scene.clone(), job.view.clone(), None, job.tiles.clone()),
                job,
                film: RenderFilm::default(),
            }
        }

        /// Renders until a limit is reached, or at most `most` work items. Returns their number.
        fn render(&mut self, stop: &StopCondition, most: usize) -> usize {
            self.job.set_region(stop.region, &mut self.film);
            let mut count = 0;
            while self.job.reached(stop).is_none() {
                let asked = (stop.noise, stop.is_adaptive);
                let queue = self.job.next_queue(stop, asked, &mut self.film, &[], 1);
                while let Some(item) = queue.claim() {
                    if count == most {
                        return count;
                    }
                    count += 1;
                    let result = (self.work)(&item, &AtomicBool::new(false)).expect("nothing cancels it");
                    self.job.take(result, &mut self.film, &mut Spent::default());
                    self.job.settle(&mut self.film);
                }
            }
            count
        }

        /// The film's data of each tile with samples, as in a checkpoint.
        fn tiles(&self) -> Vec<(Tile, Vec<u8>)> {
            let film = &self.film.film;
            let begun = self.job.tiles.iter().filter(|tile| film.samples(tile.x, tile.y) > 0);
            let content = |tile| {
                let mut content = Writer::default();
                film.write_tile(tile, &mut content);
                content.0
            };
            begun.map(|&tile| (tile, content(tile))).collect()
        }

        /// The same picture from a checkpoint.
        fn resumed(&self) -> Self {
            let mut new = Self::new(&self.job.scene, &self.job.view);
            let state = self.job.write();
            let resumed = new.job.resume(&state, self.saved(), &mut new.film);
            resumed.expect("it was just written");
            new
        }

        /// The film as read from a checkpoint.
        fn saved(&self) -> Film {
            let view = &self.job.view;
            let mut saved = Film::with_layers(view.width, view.height, view.film_layers());
            for (tile, content) in self.tiles() {
                saved
                    .read_tile(tile, &mut Reader(&content))
                    .expect("it was just written");
            }
            saved
        }
    }

    /// All decisions about samples must be independent of the moments at which a picture was interrupted.
    #[test]
    fn checkpoints_at_any_moment_lead_to_the_same_picture() {
        let (scene, view) = scene_and_view();
        let part = Some(Rect::new(0.0, 0.0, 1.0, 0.8));
        for (noise, is_adaptive, samples, region) in [
            (None, false, 100, None),
            (None, true, 300, None),
            (Some(0.12), false, 1000, None),
            (Some(0.12), true, 1000, None),
            (Some(0.12), false, 1000, part),
        ] {
            let limits = FilmLimits {
                samples,
                noise,
                is_adaptive,
            };
            let control = RenderControl {
                region,
                ..RenderControl::default()
            };
            let stop = StopCondition::new(&control, limits);
            let mut whole = Picture::new(&scene, &view);
            let count = whole.render(&stop, usize::MAX);
            assert!(
                noise.is_none() || whole.job.least_samples() < samples,
                "the noise is not reached"
            );
            assert_eq!(whole.job.adaptation.has_differences(&whole.job.active), is_adaptive);
            for between in [5, 7, 18, 50] {
                let mut picture = Picture::new(&scene, &view);
                let mut interruptions = 0;
                while picture.render(&stop, between) == between {
                    picture = picture.resumed();
                    interruptions += 1;
                    assert!(interruptions < 10 * count, "{limits:?} in {region:?} does not get on");
                }
                let what = format!("{limits:?} in {region:?}, {interruptions} interruptions");
                assert!(interruptions >= count / between, "{what}");
                assert_eq!(picture.job.least_samples(), whole.job.least_samples(), "{what}");
                assert!(picture.tiles() == whole.tiles(), "{what}: the films differ");
            }
        }
    }

    /// A damaged state is either refused or can be continued.
    #[test]
    fn damaged_states_are_refused_or_go_on() {
        let (scene, view) = scene_and_view();
        let limits = FilmLimits {
            samples: 1000,
            noise: Some(0.12),
            is_adaptive: true,
        };
        let stop = StopCondition::new(&RenderControl::default(), limits);
        let mut picture = Picture::new(&scene, &view);
        picture.render(&stop, 150);
        assert!(picture.job.replicas.is_some() && picture.job.judged.is_some());
        let state = picture.job.write();
        let mut drawn = 0;
        let mut random = || {
            drawn += 1;
            pcg4d([drawn, 5, 0, 0])[0] as usize
        };
        let words = [
            0,
            1,
            2,
            17,
            1 << 24,
            i32::MAX as u32,
            u32::MAX,
            f32::NAN.to_bits(),
            1e38_f32.to_bits(),
        ];
        let (mut refused, mut taken) = (0, 0);
        for _ in 0..2000 {
            let mut damaged = state.clone();
            for _ in 0..1 + random() % 3 {
                // Most of the state are the replicas' pixels: the numbers before them are damaged as often.
                let end = [24, 96, 256, damaged.len()][random() % 4];
                let place = 4 * (random() % (end / 4));
                let word = match random() % 2 {
                    0 => words[random() % words.len()],
                    _ => random() as u32,
                };
                damaged[place..place + 4].copy_from_slice(&word.to_le_bytes());
            }
            if random() % 8 == 0 {
                damaged.truncate(random() % damaged.len());
            }
            let mut resumed = Picture::new(&scene, &view);
            if resumed
                .job
                .resume(&damaged, picture.saved(), &mut resumed.film)
                .is_err()
            {
                refused += 1;
                continue;
            }
            taken += 1;
            resumed.render(&stop, 3);
        }
        assert!(refused > 100 && taken > 100, "{refused} refused, {taken} taken up");
    }

    #[test]
    fn another_region_after_a_checkpoint_leads_to_the_same_picture() {
        let (scene, view) = scene_and_view();
        let stop = |right: f32| {
            let control = RenderControl {
                region: Some(Rect::new(0.0, 0.0, right, 0.8)),
                ..RenderControl::default()
            };
            let (samples, noise, is_adaptive) = (1000, Some(0.12), false);
            let limits = FilmLimits {
                samples,
                noise,
                is_adaptive,
            };
            StopCondition::new(&control, limits)
        };
        let mut picture = Picture::new(&scene, &view);
        picture.render(&stop(0.5), usize::MAX);
        let mut resumed = picture.resumed();
        assert_eq!(resumed.job.region, picture.job.region);
        for picture in [&mut picture, &mut resumed] {
            assert!(picture.job.judged.is_some() && picture.job.replicas.is_some());
            picture.render(&stop(1.0), usize::MAX);
        }
        assert!(picture.tiles() == resumed.tiles(), "the films differ");
    }

    #[test]
    fn a_limit_of_noise_that_comes_later_lets_the_pass_end() {
        let (scene, view) = scene_and_view();
        let stop = |noise| {
            let (samples, is_adaptive) = (1000, false);
            let limits = FilmLimits {
                samples,
                noise,
                is_adaptive,
            };
            StopCondition::new(&RenderControl::default(), limits)
        };
        let mut picture = Picture::new(&scene, &view);
        // Five passes of four tiles have 16 samples, with which the noise is judged; then the next pass begins.
        picture.render(&stop(None), 5 * 4 + 1);
        assert_eq!(
            (
                picture.job.least_samples(),
                picture.job.judged.map(|judged| judged.samples)
            ),
            (16, Some(16))
        );
        assert_eq!(picture.job.reached(&stop(Some(100.0))), None);
        // Three tiles end the pass, and replicas measure whether the noise is low.
        assert!((4..30).contains(&picture.render(&stop(Some(100.0)), usize::MAX)));
        assert!(picture.job.are_equal(32));
    }
}
