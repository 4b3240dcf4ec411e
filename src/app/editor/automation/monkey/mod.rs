//! A monkey that uses the editor: random commands, camera flights, changed and broken files, resizing, undo and redo,
//! for hours if need be. It finds faults that tests of single features do not: memory, threads and files that grow,
//! frames that take long, and histories that do not lead back.
//!
//! A run is a sequence of rounds. Each opens a copy of one of the scenes, does some hundred acts, undoes all of them,
//! compares the scene with the start of the round, redoes them, compares with the end, saves, and opens the saved
//! scene. All decisions come from one seed, and results of other threads are awaited before a decision depends on them:
//! the same seed gives the same acts.

mod act;
mod acts;
pub mod edits;
mod folder;
pub(super) mod frames;
pub mod gauge;
mod play;
pub mod random;
pub mod report;
mod snapshot;
mod state;
mod tampering;
mod windowless;

use std::time::Duration;

use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;

use crate::app::editor::picture::frame_times::{self, FrameTimes};
use crate::app::editor::session::systems::EditorSystems;
use frames::{Span, Stopwatch};
pub use snapshot::Snapshot;
pub use state::Monkey;
use state::Phase;
pub(crate) use state::settings_folder;
pub use windowless::run_windowless;

/// Lets the monkey play in an editor.
pub(crate) fn add_to(app: &mut App, monkey: Monkey) {
    app.insert_resource(monkey)
        .add_systems(First, begin_frame.after(frame_times::time_frames))
        .add_systems(
            PostUpdate,
            play::play
                .before(EditorSystems::Apply)
                .after(EguiPostUpdateSet::EndPass),
        )
        .add_systems(Last, end_frame.after(frame_times::time_systems));
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
