//! A monkey that uses the editor: random commands, camera flights, changed and broken files, resizing, undo and redo, for hours if need be. It
//! finds what tests of single features do not: memory, threads and files that grow, frames that take long, and histories that do not lead
//! back.
//!
//! A run is a sequence of rounds. Each opens a copy of one of the scenes, does some hundred acts, undoes all of them, compares the scene with
//! the start of the round, does them again, compares with the end, saves, and opens what was saved. All decisions come from one seed, and
//! what depends on another thread's time is waited for before anything is decided by it: the same seed gives the same acts.

mod acts;
pub mod edits;
mod folder;
mod frames;
pub mod gauge;
mod play;
pub mod random;
pub mod report;
mod snapshot;
mod tampering;
mod windowless;

use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;

use super::EditorSystems;
use super::latency::{self, FrameTimes};
use acts::{Act, OwnFile};
use folder::Folder;
use frames::{Span, Stopwatch};
use gauge::Gauge;
use random::Random;
use report::{Bounds, Criterion, Mark, Record};
pub use snapshot::Snapshot;
pub use windowless::{run_windowless, windowless};

/// How long the monkey plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    Time(Duration),
    /// So many acts: such a run can be repeated exactly.
    Steps(usize),
}

/// What is asked of the monkey.
#[derive(Clone, Debug, PartialEq)]
pub struct MonkeyOptions {
    pub length: Length,
    pub seed: u64,
    /// Copies of them are edited; at least one. Others than these are never touched.
    pub scenes: Vec<PathBuf>,
    /// Gets every act, one a line. What is no comment is a line of a script.
    pub log: Option<PathBuf>,
    /// Longer frames of the window's own systems are faults; None: frames are not judged.
    pub longest_frame: Option<Duration>,
}

/// What the next frame is for.
enum Phase {
    /// Copies the scene of this number.
    Copy(usize),
    /// Writes that copy once its scene is open.
    Copying(usize),
    Begin,
    Play,
    Close,
    /// The saved scene is open; it must have as many things of each kind.
    Compare([usize; 4]),
    Over,
}

/// What is waited for before the next step.
enum Waiting {
    Nothing,
    Frames(usize),
    /// For a scene to be read after this many loads and failures.
    Scene(u64, u64),
    /// For the open scene's file to be read with this text.
    Text(String),
}

/// What is waited for longer than this is a fault.
const PATIENCE: Duration = Duration::from_secs(60);
/// Scenes may be large.
const PATIENCE_FOR_SCENES: Duration = Duration::from_secs(600);

/// One opened scene and what is done to it.
struct Round {
    own_file: OwnFile,
    steps_left: usize,
    start: Option<Snapshot>,
    begun: Instant,
}

/// The monkey at work.
#[derive(Resource)]
pub struct Monkey {
    options: MonkeyOptions,
    random: Random,
    folder: Folder,
    log: Option<BufWriter<File>>,
    phase: Phase,
    waiting: Waiting,
    waiting_since: Instant,
    round: Round,
    /// Points, before the monkey has changed it.
    window_size: Option<Vec2>,
    /// Acts that are decided, one for each of the next frames.
    coming: VecDeque<Act>,
    /// What is being done, for the list of long frames.
    doing: String,
    begun: Instant,
    /// The monkey's own work in this frame, which is no part of the window's.
    own_work: Span,
    /// What the editor has taken of this frame for the monkey's commands.
    editing: Span,
    frame: Stopwatch,
    next_mark: Duration,
    longest_since_mark: Duration,
    record: Record,
}

/// The folder in which an editor that a monkey uses keeps its settings.
pub fn settings_folder(monkey: &Monkey) -> PathBuf {
    monkey.folder.path().join("settings")
}

impl Monkey {
    /// An error: there is no place for its files.
    pub fn new(options: MonkeyOptions) -> std::io::Result<Self> {
        let mut random = Random::new(options.seed);
        let folder = Folder::new(&mut random)?;
        let log = options.log.as_ref().map(File::create).transpose()?;
        let record = Record {
            seed: options.seed,
            scenes: options.scenes.len(),
            ..Record::default()
        };
        Ok(Self {
            random,
            folder,
            log: log.map(BufWriter::new),
            phase: Phase::Copy(0),
            waiting: Waiting::Nothing,
            waiting_since: Instant::now(),
            round: Round {
                own_file: OwnFile::Harmless,
                steps_left: 0,
                start: None,
                begun: Instant::now(),
            },
            window_size: None,
            coming: VecDeque::new(),
            doing: String::new(),
            begun: Instant::now(),
            own_work: Span::default(),
            editing: Span::default(),
            frame: Stopwatch::start(),
            next_mark: Duration::ZERO,
            longest_since_mark: Duration::ZERO,
            record,
            options,
        })
    }

    fn bounds(&self) -> Bounds {
        Bounds {
            longest_frame: self.options.longest_frame,
        }
    }

    /// The share of the run that is done, from 0 on.
    fn progress(&self) -> f32 {
        match self.options.length {
            Length::Time(time) => self.begun.elapsed().as_secs_f32() / time.as_secs_f32(),
            Length::Steps(steps) => self.record.steps() as f32 / steps.max(1) as f32,
        }
    }

    fn write_log(&mut self, line: &str) {
        if let Some(log) = &mut self.log {
            // Without a log the run is as good.
            let _ = writeln!(log, "{line}");
        }
    }

    fn mark(&mut self, world: &World, at_start_of_round: bool) {
        let Some(gauge) = Gauge::read() else {
            return;
        };
        self.record.marks.push(Mark {
            at: self.begun.elapsed(),
            progress: self.progress(),
            gauge,
            entities: world.entities().count_spawned() as usize,
            steps: self.record.steps(),
            longest_frame: std::mem::take(&mut self.longest_since_mark),
            at_start_of_round,
        });
    }

    /// Prints the report and ends the program.
    fn end(&mut self, world: &mut World) {
        self.phase = Phase::Over;
        self.record.duration = self.begun.elapsed();
        if let Some(log) = &mut self.log {
            let _ = log.flush();
        }
        let verdicts = self.record.verdicts(&self.bounds());
        let has_failed = verdicts.iter().any(|verdict| verdict.holds == Some(false));
        let mut out = std::io::stdout().lock();
        // A closed pipe is no reason to fail.
        let _ = writeln!(out, "{}", self.record);
        for verdict in &verdicts {
            let _ = writeln!(out, "{verdict}");
        }
        if has_failed {
            for (_, fault) in &self.record.faults {
                let _ = writeln!(out, "fault: {fault}");
            }
            let _ = writeln!(out, "the files are kept in {}", self.folder.keep().display());
        }
        world.write_message(match has_failed {
            true => AppExit::error(),
            false => AppExit::Success,
        });
    }

    fn fault(&mut self, criterion: Criterion, text: String) {
        let text = format!(
            "after step {} of seed {}: {text}",
            self.record.steps(),
            self.options.seed
        );
        self.write_log(&format!("# fault: {text}"));
        self.record.fault(criterion, text);
    }
}

/// Lets the monkey play in an editor.
pub fn add_to(app: &mut App, monkey: Monkey) {
    app.insert_resource(monkey)
        .add_systems(First, begin_frame.after(latency::time_frames))
        .add_systems(
            PostUpdate,
            play::play
                .before(EditorSystems::Apply)
                .after(EguiPostUpdateSet::EndPass),
        )
        .add_systems(Last, end_frame.after(latency::time_systems));
}

fn begin_frame(mut monkey: ResMut<Monkey>) {
    monkey.own_work = Span::default();
    monkey.frame = Stopwatch::start();
}

fn end_frame(mut monkey: ResMut<Monkey>, frames: Res<FrameTimes>) {
    let monkey = &mut *monkey;
    if monkey.record.rounds == 0 || matches!(monkey.phase, Phase::Over) {
        return;
    }
    // The whole frame as the editor itself measures it.
    let wall = Duration::from_secs_f32(1e-3 * frames.own_ms());
    let measured = monkey.frame.elapsed();
    let time = Span { wall, ..measured } - monkey.own_work;
    monkey.longest_since_mark = monkey.longest_since_mark.max(time.own);
    let frame = report::Frame {
        time,
        at: monkey.begun.elapsed(),
        doing: monkey.doing.clone(),
        load: gauge::threads_per_core(),
    };
    let bounds = monkey.bounds();
    monkey.record.note_frame(frame, &bounds);
}
