//! The state of the monkey: its options, the awaited event, and its record.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy::prelude::*;

use super::act::{Act, OwnFile};
use super::folder::Folder;
use super::frames::{Span, Stopwatch};
use super::gauge::Gauge;
use super::random::Random;
use super::report::{Bounds, Criterion, Mark, Record};
use super::snapshot::Snapshot;
use crate::app::editor::session::options::{Length, MonkeyOptions};
use crate::files::{LARGEST_DATA, open};

/// The work of the next frame.
pub(super) enum Phase {
    /// Copies the scene of this number.
    Copy(usize),
    /// Writes a copy once its scene is open.
    Copying(usize),
    Begin,
    Play,
    Close,
    /// Compares the saved scene, once it is open, with these numbers of things of each kind.
    Compare([usize; 4]),
    Over,
}

/// The event that must happen before the next step.
pub(super) enum Waiting {
    Nothing,
    Frames(usize),
    /// A scene is read: more loads or failures are counted than these.
    Scene(u64, u64),
    /// The picture of the present scene has a sample of every pixel, or will never have one.
    Picture,
    /// The open scene's file is read with this text.
    Text(String),
}

/// The longest wait, above which it is a fault.
pub(super) const PATIENCE: Duration = Duration::from_secs(60);
/// The longest wait for a scene, which may be large.
pub(super) const PATIENCE_FOR_SCENES: Duration = Duration::from_secs(600);

/// A round: an opened scene and the acts on it.
pub(super) struct Round {
    pub own_file: OwnFile,
    pub steps_left: usize,
    pub start: Option<Snapshot>,
    pub begun: Instant,
}

/// The monkey at work.
#[derive(Resource)]
pub struct Monkey {
    pub(super) options: MonkeyOptions,
    pub(super) random: Random,
    pub(super) folder: Folder,
    pub(super) log: Option<BufWriter<File>>,
    pub(super) phase: Phase,
    pub(super) waiting: Waiting,
    pub(super) waiting_since: Instant,
    pub(super) round: Round,
    /// The size in points before the monkey has changed it.
    pub(super) window_size: Option<Vec2>,
    /// The planned acts, one for each of the next frames.
    pub(super) coming: VecDeque<Act>,
    /// The present activity, for the list of long frames.
    pub(super) doing: String,
    pub(super) begun: Instant,
    /// The time of the monkey's own work in this frame, which does not count as the window's.
    pub(super) own_work: Span,
    /// The time of this frame that the editor spent on the monkey's commands.
    pub(super) editing: Span,
    pub(super) frame: Stopwatch,
    pub(super) next_mark: Duration,
    pub(super) longest_since_mark: Duration,
    pub(super) record: Record,
}

/// The settings folder of an editor with this monkey.
pub(crate) fn settings_folder(monkey: &Monkey) -> PathBuf {
    monkey.folder.path().join("settings")
}

/// The first line of a log.
const LOG: &str = "# The acts of a monkey";

/// Creates the file of the log. It replaces another log, but no other file, which the scenes might need.
fn create_log(path: &Path) -> std::io::Result<File> {
    let mut begin = Vec::new();
    if path.is_file() {
        let file = open(path, LARGEST_DATA).map_err(std::io::Error::other)?;
        file.take(LOG.len() as u64).read_to_end(&mut begin)?;
    }
    if !begin.is_empty() && begin != LOG.as_bytes() {
        return Err(std::io::Error::other(format!(
            "{} is there already and is no log of a monkey: it is not replaced; name another file by --monkey-log",
            path.display()
        )));
    }
    File::create(path)
}

impl Monkey {
    /// Prepares a run. An error if its folder cannot be created.
    pub fn new(options: MonkeyOptions) -> std::io::Result<Self> {
        let mut random = Random::new(options.seed);
        let folder = Folder::new(&mut random)?;
        let log = options.log.as_deref().map(create_log).transpose()?;
        let record = Record {
            seed: options.seed,
            scenes: options.scenes.len(),
            ..Record::default()
        };
        let mut monkey = Self {
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
        };
        monkey.write_log(LOG);
        Ok(monkey)
    }

    pub(super) fn bounds(&self) -> Bounds {
        Bounds {
            longest_frame: self.options.longest_frame,
        }
    }

    /// The share of the run that is done, from 0 on.
    pub(super) fn progress(&self) -> f32 {
        match self.options.length {
            Length::Time(time) => self.begun.elapsed().as_secs_f32() / time.as_secs_f32(),
            Length::Steps(steps) => self.record.steps() as f32 / steps.max(1) as f32,
        }
    }

    pub(super) fn write_log(&mut self, line: &str) {
        if let Some(log) = &mut self.log {
            // A missing log does not change the run.
            let _ = writeln!(log, "{line}");
        }
    }

    pub(super) fn mark(&mut self, world: &World, at_start_of_round: bool) {
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
    pub(super) fn end(&mut self, world: &mut World) {
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

    pub(super) fn fault(&mut self, criterion: Criterion, text: String) {
        let text = format!(
            "after step {} of seed {}: {text}",
            self.record.steps(),
            self.options.seed
        );
        self.write_log(&format!("# fault: {text}"));
        self.record.fault(criterion, text);
    }
}
