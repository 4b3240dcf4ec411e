//! Measures how quickly the window responds: frame times, and the time from a command to the first changed pixels in
//! the texture.

use std::io::Write;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use tempfile::TempDir;

use super::acts;
use super::monkey::frames::Stopwatch;
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::{Command, SceneEdit, SelectionCommand};
use crate::app::editor::picture::frame_times::{Frame, FrameTimes, median};
use crate::app::editor::picture::resolution::PicturePlace;
use crate::app::editor::picture::texture::Picture;
use crate::app::editor::session::history::History;
use crate::app::editor::session::requests::CommandQueue;
use crate::engine::{RenderFilm, RenderState, RenderStatus};

/// The measurement of the command line: this many edits of each kind, one after the other.
#[derive(Resource)]
pub struct LatencyProbe {
    /// Edits of each kind.
    count: usize,
    phase: Phase,
    kind: usize,
    results: Vec<f32>,
    frames: Vec<Frame>,
    /// The present frame.
    watch: Stopwatch,
    /// The milliseconds of the last frame's systems, without the time in which other threads had the cores.
    unhindered: f32,
    all_unhindered: Vec<f32>,
    /// The folder for saves of the scene.
    folder: Option<TempDir>,
    /// The number of edits of this kind that have changed nothing.
    skipped: usize,
    pub done: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Phase {
    /// Lets the picture render for a while, so that the edit interrupts real work.
    Rest(Instant),
    Waiting {
        since: Instant,
        job: u64,
        revision: u64,
        /// The frames that have ended since.
        frames: u32,
    },
}

/// The longest wait for an edit to show. After it the edit counts as one that changed nothing.
const PATIENCE: Duration = Duration::from_secs(5);

/// The number of edits of a kind without a change after which the next kind is measured.
const MOST_SKIPPED: usize = 2;

/// The rest between two edits that are independent.
const REST: Duration = Duration::from_millis(400);

enum Act {
    /// The command that performs the measured act for the given time; None if the scene has nothing to apply it to.
    Command(fn(&mut World, usize) -> Option<Command>),
    /// The command that performs the act on one shape, which is selected first.
    OnShape(fn(Entity, usize) -> Command),
    /// The command for an act on one shape that shows only in panels, not in the picture.
    InPanels(fn(Entity, usize) -> Command),
    /// Saves the scene into a temporary file.
    Save,
    /// Reads the file of the largest mesh again, as if it had changed: a new mesh and a new acceleration structure.
    ReadMesh,
}

/// The kinds of edits that are measured, with the rest before each: without a rest the picture counts as moving, see
/// [`crate::app::editor::picture::motion`].
const KINDS: [(&str, Act, Duration); 15] = [
    ("fly", Act::Command(acts::fly), REST),
    ("fly on and on", Act::Command(acts::fly), Duration::ZERO),
    ("drag a mesh", Act::Command(acts::drag), REST),
    ("drag it on and on", Act::Command(acts::drag), Duration::ZERO),
    ("material slider", Act::Command(acts::change_material), REST),
    ("light slider", Act::Command(acts::change_light), REST),
    ("select", Act::InPanels(acts::select), REST),
    ("rename", Act::InPanels(acts::rename), REST),
    ("hide", Act::OnShape(acts::hide), REST),
    (
        "duplicate",
        Act::OnShape(|_, _| Command::from(SceneEdit::Duplicate)),
        REST,
    ),
    ("add", Act::Command(acts::add), REST),
    ("delete", Act::OnShape(|_, _| Command::from(SceneEdit::Delete)), REST),
    ("undo and redo", Act::Command(acts::undo), REST),
    ("save", Act::Save, REST),
    ("read a mesh again", Act::ReadMesh, REST),
];

impl Act {
    /// Performs the act; returns false if the scene has nothing to apply it to.
    fn begin(&self, world: &mut World, time: usize, folder: &mut Option<TempDir>) -> bool {
        match self {
            Self::Command(command) => {
                let command = command(world, time);
                let is_possible = command.is_some();
                world.resource_mut::<CommandQueue>().0.extend(command);
                is_possible
            }
            Self::OnShape(command) | Self::InPanels(command) => {
                let Some(shape) = acts::middle_shape(world, time) else {
                    return false;
                };
                let commands = [
                    Command::from(SelectionCommand::Select(vec![shape], Extend::Replace)),
                    command(shape, time),
                ];
                world.resource_mut::<CommandQueue>().0.extend(commands);
                true
            }
            Self::Save => acts::save(world, folder).is_some(),
            Self::ReadMesh => acts::read_mesh(world).is_some(),
        }
    }

    /// Whether the act changes the picture.
    fn shows_in_picture(&self) -> bool {
        !matches!(self, Self::InPanels(_) | Self::Save)
    }
}

impl LatencyProbe {
    pub fn new(count: u32) -> Self {
        Self {
            count: count as usize,
            phase: Phase::Rest(Instant::now()),
            kind: 0,
            results: Vec::new(),
            frames: Vec::new(),
            watch: Stopwatch::start(),
            unhindered: 0.0,
            all_unhindered: Vec::new(),
            folder: None,
            skipped: 0,
            done: count == 0,
        }
    }

    fn next_kind(&mut self) {
        self.results.clear();
        self.skipped = 0;
        self.frames.clear();
        self.all_unhindered.clear();
        self.kind += 1;
        self.done = self.kind >= KINDS.len();
    }
}

/// Starts the stopwatch of a frame. To run on the thread of the other systems.
pub(crate) fn begin_frame(mut probe: ResMut<LatencyProbe>) {
    probe.watch = Stopwatch::start();
}

/// Stops the stopwatch of [`begin_frame`].
pub(crate) fn end_frame(mut probe: ResMut<LatencyProbe>) {
    probe.unhindered = 1e3 * probe.watch.elapsed().own.as_secs_f32();
}

/// Queues the next command, as a panel would.
pub fn act_for_probe(world: &mut World) {
    let Some(mut probe) = world.remove_resource::<LatencyProbe>() else {
        return;
    };
    let status = world.resource::<RenderStatus>();
    let has_picture = matches!(status.state, RenderState::Rendering | RenderState::Done) && status.samples > 0;
    if let Phase::Rest(since) = probe.phase
        && has_picture
        && world.resource::<PicturePlace>().is_settled()
        && !probe.done
        && since.elapsed() >= KINDS[probe.kind].2
    {
        let (name, act, _) = &KINDS[probe.kind];
        let time = probe.results.len() + probe.skipped;
        if act.begin(world, time, &mut probe.folder) {
            probe.phase = Phase::Waiting {
                since: Instant::now(),
                job: world.resource::<RenderFilm>().job,
                revision: world.resource::<Picture>().revision,
                frames: 0,
            };
        } else {
            say(format_args!("{name}: the scene has nothing for it"));
            probe.next_kind();
        }
    }
    world.insert_resource(probe);
}

/// Stops the clock when the new picture's first pixels are in the texture, or when the panels have shown the change.
pub fn watch_probe(
    mut probe: ResMut<LatencyProbe>,
    film: Res<RenderFilm>,
    picture: Res<Picture>,
    frames: Res<FrameTimes>,
    status: Res<RenderStatus>,
    history: Res<History>,
) {
    probe.frames.push(frames.last_frame());
    let unhindered = probe.unhindered;
    probe.all_unhindered.push(unhindered);
    let in_picture = KINDS.get(probe.kind).is_some_and(|(_, act, _)| act.shows_in_picture());
    let Phase::Waiting {
        since,
        job,
        revision,
        frames: ended,
    } = &mut probe.phase
    else {
        return;
    };
    let (since, ended_before) = (*since, *ended);
    let is_shown = match in_picture {
        true => film.job != *job && film.is_lit && picture.revision != *revision,
        // Panels show a command in the frame after the one that applies it.
        false => ended_before > 0 && !history.is_saving(),
    };
    *ended += 1;
    if since.elapsed() > PATIENCE && !history.is_saving() {
        // The value was set already, or the thing is hidden: nothing has changed.
        probe.phase = Phase::Rest(Instant::now());
        probe.skipped += 1;
        if probe.skipped > MOST_SKIPPED {
            say(format_args!("{}: nothing changes", KINDS[probe.kind].0));
            probe.next_kind();
        }
        return;
    }
    if !is_shown {
        return;
    }
    probe.results.push(1e3 * since.elapsed().as_secs_f32());
    probe.phase = Phase::Rest(Instant::now());
    if probe.results.len() < probe.count {
        return;
    }
    let of = |values: &[f32], q| median(values.to_vec(), q).unwrap_or(f32::NAN);
    say(format_args!(
        "{}: command to first changed {}: median {:.1} ms, 95 % {:.1} ms, worst {:.1} ms, {} times, {}x{} pixels",
        KINDS[probe.kind].0,
        if in_picture { "pixel" } else { "panel" },
        of(&probe.results, 0.5),
        of(&probe.results, 0.95),
        of(&probe.results, 1.0),
        probe.results.len(),
        status.size.x,
        status.size.y,
    ));
    let figures = |name: &str, times: &[f32]| {
        let [median, most, worst] = [0.5, 0.95, 1.0].map(|q| of(times, q));
        say(format_args!(
            "  {name}: median {median:.1} ms, 95 % {most:.1} ms, worst {worst:.1} ms"
        ));
    };
    let part = |part: fn(&Frame) -> Option<f32>| -> Vec<f32> { probe.frames.iter().filter_map(part).collect() };
    figures("frames from one to the next", &part(|frame| frame.whole));
    figures("  of that the window's own systems", &part(|frame| Some(frame.own)));
    figures("    without waits for a core", &probe.all_unhindered);
    figures(
        "  beside them the drawing thread and the driver",
        &part(|frame| Some(frame.drawing)),
    );
    probe.next_kind();
}

/// Prints a line, and ignores a closed pipe.
fn say(line: std::fmt::Arguments) {
    let _ = writeln!(std::io::stdout(), "{line}");
}
