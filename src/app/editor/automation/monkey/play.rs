//! Plays a frame of the monkey: waits for pending events, does one act, and goes from round to round.

use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy::window::PrimaryWindow;

use super::super::script::parse::{self, Step};
use super::act::{Act, OwnFile};
use super::acts::next_acts;
use super::frames::{Span, Stopwatch};
use super::report::Criterion;
use super::snapshot::Snapshot;
use super::state::{Monkey, PATIENCE, PATIENCE_FOR_SCENES, Phase, Round, Waiting};
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::{Command, DisplayCommand, FileCommand, HistoryCommand, RenderCommand, ShellCommand};
use crate::app::editor::commands;
use crate::app::editor::picture::pacing::Pacing;
use crate::app::editor::session::history::History;
use crate::app::editor::session::options::Length;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::Toasts;
use crate::document::Severity;
use crate::engine::{RenderState, RenderStatus};
use crate::scene::{SceneState, SceneStatus};

/// The number of acts of most rounds. It is so small that the history has room for all of them.
const SHORT: std::ops::Range<usize> = 30..150;
/// The number of acts of one round in [`LONG_EVERY`]. The history gets full then and drops entries.
const LONG: std::ops::Range<usize> = 1500..2500;
const LONG_EVERY: usize = 20;
/// The least number of rounds in a timed run, even if frames are slow: memory is compared between their starts.
const LEAST_ROUNDS: u32 = 12;
/// The number of marks in a run: the time between two is the run's length over this.
const PARTS: u32 = 60;

/// Does the monkey's work of this frame.
pub fn play(world: &mut World) {
    let Some(mut monkey) = world.remove_resource::<Monkey>() else {
        return;
    };
    if !matches!(monkey.phase, Phase::Over) {
        let whole = Stopwatch::start();
        monkey.editing = Span::default();
        monkey.step(world);
        monkey.own_work += whole.elapsed() - monkey.editing;
        // The window continues to draw as it does while it is used.
        world.resource_mut::<Pacing>().note_commands(false);
    }
    world.insert_resource(monkey);
}

impl Monkey {
    fn step(&mut self, world: &mut World) {
        if self.begun.elapsed() >= self.next_mark {
            let part = match self.options.length {
                Length::Time(time) => time / PARTS,
                Length::Steps(_) => Duration::from_secs(1),
            };
            self.next_mark = self.begun.elapsed() + part;
            self.mark(world, false);
        }
        if !self.has_waited(world) {
            return;
        }
        if let Some(act) = self.coming.pop_front() {
            return self.act(world, act);
        }
        match self.phase {
            Phase::Copy(number) => self.open_original(world, number),
            Phase::Copying(number) => self.copy(world, number),
            Phase::Begin => self.begin_round(world),
            Phase::Play => self.go_on(world),
            Phase::Close => self.close_round(world),
            Phase::Compare(counts) => self.compare(world, counts),
            Phase::Over => {}
        }
    }

    fn has_waited(&mut self, world: &World) -> bool {
        let status = world.resource::<SceneStatus>();
        let is_settled = status.state != SceneState::Loading && status.files_loading() == 0;
        let has_come = match &mut self.waiting {
            Waiting::Nothing => true,
            Waiting::Frames(left) => {
                *left = left.saturating_sub(1);
                *left == 0
            }
            Waiting::Scene(revision, failures) => {
                is_settled && (status.revision, status.failures) != (*revision, *failures)
            }
            Waiting::Picture => {
                let engine = world.resource::<RenderStatus>();
                let is_coming = matches!(
                    engine.state,
                    RenderState::Loading | RenderState::Building | RenderState::Rendering
                );
                engine.is_up_to_date && (engine.samples > 0 || !is_coming)
            }
            Waiting::Text(text) => {
                let source = status.diagnostics.sources.first();
                is_settled && source.is_some_and(|source| *source.text == **text)
            }
        };
        let patience = match self.waiting {
            Waiting::Scene(..) => PATIENCE_FOR_SCENES,
            _ => PATIENCE,
        };
        if has_come {
            self.record.noticed += usize::from(matches!(self.waiting, Waiting::Text(_)));
        } else if self.waiting_since.elapsed() > patience {
            let text = format!("waited {} s in vain after `{}`", patience.as_secs(), self.doing);
            self.fault(Criterion::Files, text);
        } else {
            return false;
        }
        self.waiting = Waiting::Nothing;
        true
    }

    fn wait(&mut self, waiting: Waiting) {
        self.waiting = waiting;
        self.waiting_since = Instant::now();
    }

    fn wait_for_scene(&mut self, world: &World) {
        let status = world.resource::<SceneStatus>();
        self.wait(Waiting::Scene(status.revision, status.failures));
    }

    fn open_original(&mut self, world: &mut World, number: usize) {
        let Some(path) = self.options.scenes.get(number).cloned() else {
            self.phase = if self.folder.copies().is_empty() {
                Phase::Over
            } else {
                Phase::Begin
            };
            if matches!(self.phase, Phase::Over) {
                self.fault(Criterion::Run, "there is no scene to play with".to_owned());
                self.end(world);
            }
            return;
        };
        self.wait_for_scene(world);
        self.apply(world, FileCommand::OpenScene(path));
        self.phase = Phase::Copying(number);
    }

    fn copy(&mut self, world: &mut World, number: usize) {
        self.phase = Phase::Copy(number + 1);
        if let Some(problem) = trouble(world) {
            return self.fault(Criterion::Run, problem);
        }
        let place = self.folder.place_for_copy(number);
        let outcome = self.attempt(world, FileCommand::SaveScene(place.clone()));
        let outcome = outcome.and_then(|()| self.folder.add_copy(place).map_err(CommandError::file));
        if let Err(error) = outcome {
            self.fault(Criterion::Run, format!("a copy of the scene cannot be made: {error}"));
        }
    }

    fn is_over(&self) -> bool {
        match self.options.length {
            Length::Time(time) => self.begun.elapsed() >= time,
            Length::Steps(steps) => self.record.steps() >= steps,
        }
    }

    fn begin_round(&mut self, world: &mut World) {
        if self.is_over() {
            return self.end(world);
        }
        let scene = self.random.below(self.folder.copies().len());
        let copy = &self.folder.copies()[scene];
        let path = copy.path.clone();
        if let Err(error) = copy.restore() {
            return self.fault(Criterion::Run, error.to_string());
        }
        let is_long = self.random.below(LONG_EVERY) == 0;
        let range = if is_long { LONG } else { SHORT };
        let own_file = match self.random.below(4) {
            0 => OwnFile::Changes,
            1 => OwnFile::Harmless,
            _ => OwnFile::Untouched,
        };
        self.round = Round {
            own_file,
            steps_left: range.start + self.random.below(range.len()),
            start: None,
            begun: Instant::now(),
        };
        self.wait_for_scene(world);
        self.write_log(&format!("open {}", path.file_name().unwrap_or_default().display()));
        self.doing = "open".to_owned();
        self.record.rounds += 1;
        self.record.has_window = world.query::<&Window>().iter(world).next().is_some();
        // These are the settings of an editor that has just been started.
        let defaults = [
            Command::from(FileCommand::OpenScene(path)),
            Command::from(RenderCommand::SetPaused(false)),
            Command::from(RenderCommand::SetRegion(None)),
            Command::from(RenderCommand::SetStrategySplit(false)),
            Command::from(RenderCommand::SetPathIsAuto(true)),
            Command::from(RenderCommand::SetLightLayers(false)),
            Command::from(DisplayCommand::SetLightMix(LightMix::default())),
            Command::from(RenderCommand::SetTimeLimit(None)),
            Command::from(RenderCommand::SetNoiseTarget(None)),
            Command::from(RenderCommand::SetTargetSamples(16)),
            Command::from(DisplayCommand::SetCompareView(CompareView::Off)),
            Command::from(DisplayCommand::SetDenoising(false)),
            Command::from(ShellCommand::ShowPanels(true)),
            Command::Shell(ShellCommand::ResetLayout),
        ];
        for command in defaults {
            self.apply(world, command);
        }
        self.phase = Phase::Play;
    }

    fn go_on(&mut self, world: &mut World) {
        if self.round.start.is_none() {
            if let Some(problem) = trouble(world) {
                self.fault(Criterion::Run, problem);
            }
            self.round.start = Some(Snapshot::of(world));
            self.mark(world, true);
        }
        let is_late = match self.options.length {
            Length::Time(time) => self.round.begun.elapsed() > time / LEAST_ROUNDS,
            Length::Steps(_) => false,
        };
        if self.round.steps_left == 0 || is_late || self.is_over() {
            self.phase = Phase::Close;
            return;
        }
        self.round.steps_left -= 1;
        let (kind, acts) = next_acts(world, &mut self.random, &self.folder, self.round.own_file);
        *self.record.done.entry(kind).or_default() += 1;
        self.coming.extend(acts);
        world.resource_mut::<Requests>().interaction += 1;
        if let Some(act) = self.coming.pop_front() {
            self.act(world, act);
        }
    }

    fn close_round(&mut self, world: &mut World) {
        self.write_log("# the round ends");
        self.doing = "undo everything, do it again, save".to_owned();
        if self.round.own_file != OwnFile::Changes {
            self.undo_and_redo(world);
        }
        let saved = self.folder.saved();
        let counts = Snapshot::of(world).counts();
        let outcome = self.attempt(world, FileCommand::SaveScene(saved.clone()));
        let toasts = world.resource::<Toasts>().texts().last();
        let trouble = toasts.filter(|text| text.starts_with("Saved, but")).map(str::to_owned);
        if let Some(trouble) = outcome.err().map(|error| error.to_string()).or(trouble) {
            self.fault(Criterion::Saving, trouble);
        }
        self.wait_for_scene(world);
        self.apply(world, FileCommand::OpenScene(saved));
        self.phase = Phase::Compare(counts);
    }

    /// Undoes everything, and redoes it.
    fn undo_and_redo(&mut self, world: &mut World) {
        let end = Snapshot::of(world);
        let (done, undone) = world.resource::<History>().len();
        let is_whole = world.resource::<History>().is_whole();
        self.apply(world, HistoryCommand::GoTo(0));
        let start = self.round.start.take().filter(|_| is_whole);
        if let Some(start) = start {
            self.record.undone_to_start += 1;
            if let Some(difference) = self.difference(&start, &Snapshot::of(world)) {
                let text = format!("the start of the round is not what it was: {difference}");
                self.fault(Criterion::Undo, text);
            }
        }
        self.apply(world, HistoryCommand::GoTo(done));
        if let Some(difference) = self.difference(&end, &Snapshot::of(world)) {
            let text = format!("undone and redone ({done} steps, {undone} ahead), it is not what it was: {difference}");
            self.fault(Criterion::Undo, text);
        }
    }

    /// The first difference of two scenes, ignoring data that saving and reading renew: saving gives ids to things and
    /// reading the file again renews their order, and undo reverts neither.
    fn difference(&self, one: &Snapshot, other: &Snapshot) -> Option<String> {
        match self.round.own_file {
            OwnFile::Untouched => one.difference(other),
            OwnFile::Harmless | OwnFile::Changes => one.difference_of_contents(other),
        }
    }

    fn compare(&mut self, world: &mut World, saved: [usize; 4]) {
        self.record.opened_again += 1;
        let found = Snapshot::of(world).counts();
        // A scene without a camera gets one when it is opened.
        let [shapes, emitters, sensors, groups] = saved;
        let expected = [shapes, emitters, sensors.max(1), groups];
        if let Some(problem) = trouble(world) {
            self.fault(Criterion::Saving, problem);
        } else if found != expected {
            let text =
                format!("saved with {saved:?} shapes, emitters, sensors and groups, opened again with {found:?}");
            self.fault(Criterion::Saving, text);
        }
        self.phase = Phase::Begin;
    }

    fn act(&mut self, world: &mut World, act: Act) {
        match act {
            Act::Say(lines) => {
                self.doing = lines.join("; ");
                let (done, undone) = world.resource::<History>().len();
                self.write_log(&format!("# {done} steps done, {undone} undone"));
                for line in lines {
                    self.write_log(&line);
                    match parse::line(world, &line) {
                        Ok(Some(Step::Do(command))) => self.apply(world, command),
                        Ok(_) => {}
                        Err(_) => self.record.refused += 1,
                    }
                }
            }
            Act::Do(command) => {
                self.doing = format!("{command:?}");
                self.write_log(&format!("# {command:?}"));
                self.apply(world, command);
            }
            Act::Write {
                path,
                content,
                how,
                awaited,
            } => {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                self.doing = format!("another program writes {name} ({how:?}, {} bytes)", content.len());
                self.write_log(&format!("# {}", self.doing));
                if let Err(error) = how.write(&path, &content) {
                    self.fault(Criterion::Run, format!("{}: {error}", path.display()));
                } else if awaited && let Ok(text) = String::from_utf8(content) {
                    self.wait(Waiting::Text(text));
                }
            }
            Act::Remove(path) => {
                self.doing = "another program deletes the scene's file".to_owned();
                self.write_log(&format!("# {}", self.doing));
                if let Err(error) = std::fs::remove_file(&path) {
                    self.fault(Criterion::Run, format!("{}: {error}", path.display()));
                }
            }
            Act::Resize(shares) => {
                self.doing = format!("resize the window to {:.2} x {:.2} of its size", shares.x, shares.y);
                self.write_log(&format!("# {}", self.doing));
                let mut windows = world.query_filtered::<&mut Window, With<PrimaryWindow>>();
                if let Ok(mut window) = windows.single_mut(world) {
                    let first = *self.window_size.get_or_insert(window.resolution.size());
                    let size = (first * shares).round();
                    window.resolution.set(size.x, size.y);
                }
            }
            Act::CloseSheet => world.resource_mut::<Requests>().sheet = None,
            Act::AwaitPicture => self.wait(Waiting::Picture),
            Act::Rest(frames) => self.wait(Waiting::Frames(frames)),
        }
        // Reading the scene again is awaited, because names depend on it.
        if world.resource::<SceneStatus>().state == SceneState::Loading && matches!(self.waiting, Waiting::Nothing) {
            self.wait_for_scene(world);
        }
    }

    fn apply(&mut self, world: &mut World, command: impl Into<Command>) {
        if self.attempt(world, command).is_err() {
            self.record.refused += 1;
        }
    }

    /// Applies a command. The error is the message that a user would see.
    fn attempt(&mut self, world: &mut World, command: impl Into<Command>) -> Result<(), CommandError> {
        let watch = Stopwatch::start();
        let outcome = commands::apply_now(world, command);
        self.editing += watch.elapsed();
        // The dialog is closed, since there is no user to choose a file.
        world.resource_mut::<Requests>().dialog = None;
        outcome
    }
}

/// The reason why the requested scene is not open, in words.
fn trouble(world: &World) -> Option<String> {
    let status = world.resource::<SceneStatus>();
    if status.state == SceneState::Ready {
        return None;
    }
    let mut found = status.diagnostics.list.iter();
    let first = found.find(|found| found.severity == Severity::Error);
    let path = status.subject().unwrap_or(std::path::Path::new("")).display();
    let reason = first.map_or("no reason is given".to_owned(), |first| status.diagnostics.line(first));
    Some(format!("{path} cannot be read: {reason}"))
}
