//! Measures the error of the picture in the window against the converged one soon after edits, with and without
//! carrying over the last picture. It follows the frames as they come, so that it compares the pictures that a user
//! would have seen.

mod edits;
mod figures;
mod table;

use std::fmt::Display;
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;

use super::script::Script;
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::command::light_mix::{FilmLights, LightMix};
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::resolution::Resolution;
use crate::app::editor::command::{Command, HistoryCommand, ViewCommand};
use crate::app::editor::picture::denoiser::Denoiser;
use crate::app::editor::picture::motion::Motion;
use crate::app::editor::picture::resolution::PicturePlace;
use crate::app::editor::picture::texture::Picture;
use crate::app::editor::session::history::History;
use crate::app::editor::session::options::SettlingOptions;
use crate::app::editor::session::requests::CommandQueue;
use crate::app::editor::session::systems::EditorSystems;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::terminal;
use crate::engine::{EngineSystems, RenderControl, RenderFilm, RenderState, RenderStatus};
use crate::files::write_atomically;
use crate::scene::SceneWatch;
use edits::EDITS;
use figures::{Figures, Shot};
use table::{EditRows, PICTURES, Report, Row, TIMES};

/// The longest wait for an edit to restart the picture. After it the edit counts as one that changed nothing.
const PATIENCE: Duration = Duration::from_secs(5);

/// The number of attempts at an edit, with different values, if it changes nothing.
const ATTEMPTS: usize = 2;

/// The measurement of the command line.
#[derive(Resource)]
pub(crate) struct SettlingProbe {
    options: SettlingOptions,
    stage: Stage,
    /// The index in [`EDITS`].
    edit: usize,
    attempt: usize,
    /// The chosen commands of this edit: with and without carrying over the same ones are applied.
    commands: Vec<Command>,
    /// The results so far, with or without carrying over.
    played: Vec<Played>,
    report: Report,
    /// The settings to restore at the end.
    before: Option<(RenderControl, bool)>,
    pub done: bool,
}

enum Stage {
    /// A script may have to end first.
    New,
    /// Waits for the converged picture, of a later job than this one if there is one.
    Converging(Option<u64>),
    /// The picture has converged, and the edit comes next.
    Ready(Shot),
    Acting(Acting),
    /// The edit is reverted after carrying over is switched. This restarts the picture if the edit did.
    Returning(Start, bool),
    /// The edit is reverted next.
    Switched(Start, bool),
    Over,
}

/// An edit whose picture is followed.
struct Acting {
    since: Instant,
    start: Start,
    /// The pictures of [`PICTURES`] taken so far, in their order.
    pictures: Vec<Timed>,
}

/// The state before an edit.
#[derive(Clone, Copy)]
struct Start {
    job: u64,
    pose: Option<Affine3A>,
    /// The steps of the history.
    steps: usize,
}

struct Timed {
    /// The seconds since the command; None before it.
    seconds: Option<f32>,
    shot: Shot,
}

struct Played {
    carries_over: bool,
    /// The pictures, one for each of [`PICTURES`].
    pictures: Vec<Timed>,
}

/// Adds the measurement to an editor with this scene.
pub(crate) fn add_to(app: &mut App, options: &SettlingOptions, scene: Option<&Path>) {
    let probe = SettlingProbe {
        options: options.clone(),
        stage: Stage::New,
        edit: 0,
        attempt: 0,
        commands: Vec::new(),
        played: Vec::new(),
        report: Report {
            scene: scene.map_or_else(String::new, |scene| scene.display().to_string()),
            samples: options.samples,
            ..Report::default()
        },
        before: None,
        done: false,
    };
    app.insert_resource(probe).add_systems(
        PostUpdate,
        (
            act.before(EditorSystems::Apply).after(EguiPostUpdateSet::EndPass),
            watch.after(EditorSystems::Show).after(EngineSystems::Report),
        ),
    );
}

/// Queues the next commands, as a panel would.
fn act(world: &mut World) {
    let Some(mut probe) = world.remove_resource::<SettlingProbe>() else {
        return;
    };
    probe.stage = match std::mem::replace(&mut probe.stage, Stage::Over) {
        Stage::New => probe.begin(world),
        Stage::Ready(kept) => probe.play(world, kept),
        Stage::Returning(start, restarts) => {
            // One frame before the picture from which the next edit is carried over: it may have to be kept for that.
            probe.set_way(world);
            Stage::Switched(start, restarts)
        }
        Stage::Switched(start, restarts) => probe.put_back(world, start, restarts),
        stage => stage,
    };
    world.insert_resource(probe);
}

/// Takes the picture that the window shows in this frame.
fn watch(mut probe: ResMut<SettlingProbe>, seen: Seen, scene: Res<SceneWatch>, mut exit: MessageWriter<AppExit>) {
    let probe = &mut *probe;
    if let Err(error) = probe.look(&seen, &scene) {
        terminal::line(format_args!("error: {error}"));
        probe.done = true;
        exit.write(AppExit::error());
    }
}

#[derive(SystemParam)]
struct Seen<'w> {
    picture: Res<'w, Picture>,
    images: Res<'w, Assets<Image>>,
    film: Res<'w, RenderFilm>,
    status: Res<'w, RenderStatus>,
    denoiser: Res<'w, Denoiser>,
    settings: Res<'w, ViewSettings>,
    mix: Res<'w, LightMix>,
    lights: Res<'w, FilmLights>,
    motion: Res<'w, Motion>,
    place: Res<'w, PicturePlace>,
}

impl Seen<'_> {
    fn shot(&self) -> Result<Shot, String> {
        let (size, rgba) = self
            .picture
            .pixels(&self.images)
            .ok_or("there is no picture to measure, or it is too large for a texture")?;
        let film_corners = self.picture.film_corners();
        Ok(Shot::of_film(size, rgba, film_corners))
    }

    /// Whether this is the final picture at so many samples per pixel, and of a later job than `left`.
    fn is_converged(&self, samples: u32, left: Option<u64>) -> bool {
        let is_later = left.is_none_or(|job| self.film.job != job);
        let is_there = self.status.state == RenderState::Done
            && self.status.is_up_to_date
            && self.status.samples.min(self.film.samples) >= samples;
        let is_full = !self.film.is_coarse && self.motion.is_settled() && self.place.is_settled();
        is_later && is_there && is_full && self.is_denoised()
    }

    /// Whether no better denoised picture is to come.
    fn is_denoised(&self) -> bool {
        if !self.settings.denoising || !self.denoiser.is_available() {
            return true;
        }
        let mix = self.mix.factors(&self.film.light_groups, &self.lights);
        !self.denoiser.owes(&self.film, &mix) && !self.denoiser.is_copying() && !self.denoiser.is_working()
    }
}

impl SettlingProbe {
    /// The present activity, for a message about a timeout.
    pub fn awaited(&self) -> String {
        match EDITS.get(self.edit) {
            Some((name, _)) => format!("while the edit `{name}` was measured"),
            None => "at the end of the measurement".to_owned(),
        }
    }

    /// Whether this run of the edit is carried over. Every edit runs with and without, in an order that alternates from
    /// edit to edit: data kept from the first run, such as a guide of paths, then favours neither.
    fn carries_over(&self) -> bool {
        !(self.edit + self.played.len()).is_multiple_of(2)
    }

    fn set_way(&self, world: &mut World) {
        let mut preferences = world.resource_mut::<Preferences>();
        if preferences.carries_over != self.carries_over() {
            preferences.carries_over = self.carries_over();
        }
    }

    fn begin(&mut self, world: &mut World) -> Stage {
        if world.get_resource::<Script>().is_some_and(|script| !script.is_done()) {
            return Stage::New;
        }
        let mut control = world.resource_mut::<RenderControl>();
        let before = control.clone();
        // No other limit ends the picture earlier.
        (control.target_samples, control.exact_samples) = (Some(self.options.samples), None);
        (control.time_limit, control.noise_target) = (None, Some(0.0));
        self.before = Some((before, world.resource::<Preferences>().carries_over));
        let mut settings = world.resource_mut::<ViewSettings>();
        if settings.resolution == Resolution::AfterRest {
            // The picture would restart with more pixels while it is followed.
            settings.resolution = Resolution::View;
        }
        self.set_way(world);
        Stage::Converging(None)
    }

    fn play(&mut self, world: &mut World, kept: Shot) -> Stage {
        let (name, choose) = EDITS[self.edit];
        let start = Start {
            job: world.resource::<RenderFilm>().job,
            pose: view_pose(world),
            steps: world.resource::<History>().len().0,
        };
        if self.commands.is_empty() {
            self.commands = choose(world, self.attempt).unwrap_or_default();
        }
        if self.commands.is_empty() {
            self.skip(format_args!("{name}: the scene has nothing for it"));
            return Stage::Returning(start, false);
        }
        let commands = self.commands.iter().cloned();
        world.resource_mut::<CommandQueue>().0.extend(commands);
        Stage::Acting(Acting {
            since: Instant::now(),
            start,
            pictures: vec![Timed {
                seconds: None,
                shot: kept,
            }],
        })
    }

    fn put_back(&mut self, world: &mut World, start: Start, restarts: bool) -> Stage {
        let left = Some(world.resource::<RenderFilm>().job);
        // The picture from which the next edit is carried over has to be made with the new setting.
        world.resource_mut::<RenderControl>().restart_requested |= !restarts;
        let is_edited = world.resource::<History>().len().0 > start.steps;
        let view = start.pose.filter(|pose| view_pose(world) != Some(*pose));
        let back = is_edited.then_some(Command::from(HistoryCommand::Undo)).into_iter();
        let back = back.chain(view.map(|it| ViewCommand::MoveView(it).into()));
        world.resource_mut::<CommandQueue>().0.extend(back);
        if self.edit == EDITS.len() {
            self.finish(world);
            return Stage::Over;
        }
        Stage::Converging(left)
    }

    fn finish(&mut self, world: &mut World) {
        if let Some((before, carries_over)) = self.before.take() {
            let mut control = world.resource_mut::<RenderControl>();
            (control.target_samples, control.exact_samples) = (before.target_samples, before.exact_samples);
            (control.time_limit, control.noise_target) = (before.time_limit, before.noise_target);
            world.resource_mut::<Preferences>().carries_over = carries_over;
        }
        self.report.take_means();
        if self.options.json {
            match serde_json::to_string_pretty(&self.report) {
                Ok(text) => say(text),
                Err(error) => terminal::line(format_args!("error: {error}")),
            }
        } else if !self.report.edits.is_empty() {
            say(table::lines("mean", &self.report.means));
        }
        self.done = true;
    }

    fn look(&mut self, seen: &Seen, scene: &SceneWatch) -> Result<(), String> {
        self.stage = match std::mem::replace(&mut self.stage, Stage::Over) {
            Stage::Converging(left) if seen.is_converged(self.options.samples, left) => Stage::Ready(seen.shot()?),
            Stage::Acting(acting) => self.follow(acting, seen, scene)?,
            stage => stage,
        };
        Ok(())
    }

    fn follow(&mut self, mut acting: Acting, seen: &Seen, scene: &SceneWatch) -> Result<Stage, String> {
        let elapsed = acting.since.elapsed();
        let seconds = elapsed.as_secs_f32();
        let timed = |shot| Timed {
            seconds: Some(seconds),
            shot,
        };
        while let Some(time) = TIMES.get(acting.pictures.len() - 1)
            && seconds >= *time
        {
            acting.pictures.push(timed(seen.shot()?));
        }
        let start = acting.start;
        let is_same = seen.film.job == start.job;
        if is_same && seen.status.is_up_to_date && elapsed > PATIENCE {
            self.try_again();
            return Ok(Stage::Returning(start, false));
        }
        let has_all = acting.pictures.len() == 1 + TIMES.len();
        if !has_all || !seen.is_converged(self.options.samples, Some(start.job)) {
            return Ok(Stage::Acting(acting));
        }
        acting.pictures.push(timed(seen.shot()?));
        self.report.denoised = seen.picture.denoised().is_some();
        self.played.push(Played {
            carries_over: self.carries_over(),
            pictures: acting.pictures,
        });
        if self.played.len() == 2 {
            self.judge(scene)?;
            self.next_edit();
        }
        Ok(Stage::Returning(start, true))
    }

    fn try_again(&mut self) {
        self.attempt += 1;
        (self.commands, self.played) = (Vec::new(), Vec::new());
        if self.attempt == ATTEMPTS {
            self.skip(format_args!("{}: it changes nothing in the scene", EDITS[self.edit].0));
        }
    }

    fn skip(&mut self, why: impl Display) {
        terminal::line(why);
        self.report.skipped.push(EDITS[self.edit].0);
        self.next_edit();
    }

    fn next_edit(&mut self) {
        (self.edit, self.attempt) = (self.edit + 1, 0);
        (self.commands, self.played) = (Vec::new(), Vec::new());
    }

    /// Compares the pictures of both runs with the converged one made without carrying over.
    fn judge(&mut self, scene: &SceneWatch) -> Result<(), String> {
        let of = |carries_over| {
            let mut played = self.played.iter();
            played.find(|played| played.carries_over == carries_over)
        };
        let (Some(carried), Some(anew)) = (of(true), of(false)) else {
            return Ok(());
        };
        let Some(Timed { shot: truth, .. }) = anew.pictures.last() else {
            return Ok(());
        };
        let name = EDITS[self.edit].0;
        let mut rows = Vec::new();
        let pictures = carried.pictures.iter().zip(&anew.pictures);
        for (picture, (carried, anew)) in PICTURES.into_iter().zip(pictures) {
            let is_truth = std::ptr::eq(&anew.shot, truth);
            let figures = |timed: &Timed| Figures::new(timed.seconds, &timed.shot, truth);
            rows.push(Row {
                picture,
                carried: figures(carried),
                anew: figures(anew).filter(|_| !is_truth),
            });
            if let Some(folder) = &self.options.pictures {
                let without = match is_truth {
                    true => "truth".to_owned(),
                    false => format!("{picture}-anew"),
                };
                let with = format!("{picture}-carried");
                write(&carried.shot, &folder.join(file_name(name, &with)), scene)?;
                write(&anew.shot, &folder.join(file_name(name, &without)), scene)?;
            }
        }
        (self.report.width, self.report.height) = truth.size.into();
        if !self.options.json {
            if self.report.edits.is_empty() {
                say(table::header());
            }
            say(table::lines(name, &rows));
        }
        self.report.edits.push(EditRows { edit: name, rows });
        Ok(())
    }
}

fn file_name(edit: &str, picture: &str) -> String {
    format!("{}-{picture}.png", edit.replace(' ', "-"))
}

/// Writes a picture as PNG. It does not replace files of the scene.
fn write(shot: &Shot, path: &Path, scene: &SceneWatch) -> Result<(), String> {
    let named = |error: &dyn Display| format!("{}: {error}", path.display());
    if scene.has_file(path) {
        return Err(named(&"the scene is made of this file; choose another folder"));
    }
    let png = shot.png().map_err(|error| named(&error))?;
    write_atomically(path, png).map_err(|error| named(&error))
}

/// Prints lines, and ignores a closed pipe.
fn say(lines: impl Display) {
    let _ = writeln!(std::io::stdout(), "{lines}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_called_after_edits_and_times() {
        assert_eq!(
            file_name("drag a thing", "0.3s-carried"),
            "drag-a-thing-0.3s-carried.png"
        );
        let mut names: Vec<&str> = EDITS.iter().map(|(name, _)| *name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), EDITS.len());
    }
}
