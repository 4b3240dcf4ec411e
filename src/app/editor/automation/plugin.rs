//! Automation of the window without a user: the exit door, a script, measurements and the monkey.

use std::fmt::Display;
use std::io;

use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;

use super::exit_door::ExitDoor;
use super::latency::LatencyProbe;
use super::monkey::Monkey;
use super::script::Script;
use super::{latency, monkey, script, settling};
use crate::app::editor::picture::frame_times;
use crate::app::editor::session::options::WindowOptions;
use crate::app::editor::session::systems::EditorSystems;
use crate::app::terminal;

/// Adds the automation in the options.
pub(crate) fn add_to(app: &mut App, options: &WindowOptions, monkey: io::Result<Option<Monkey>>) {
    app.insert_resource(ExitDoor::new(
        options.screenshot.clone(),
        options.after_spp,
        options.exit,
        options.timeout,
    ));
    if let Some(moves) = options.measure_latency {
        app.insert_resource(LatencyProbe::new(moves))
            .add_systems(First, latency::begin_frame.after(frame_times::time_frames))
            .add_systems(Last, latency::end_frame.after(frame_times::time_systems))
            .add_systems(
                PostUpdate,
                (
                    latency::act_for_probe
                        .before(EditorSystems::Apply)
                        .after(EguiPostUpdateSet::EndPass),
                    latency::watch_probe.after(EditorSystems::Show),
                ),
            );
    }
    if let Some(measured) = &options.measure_settling {
        settling::add_to(app, measured, options.scene.as_deref());
    }
    match monkey {
        Ok(Some(monkey)) => monkey::add_to(app, monkey),
        Ok(None) => {}
        Err(error) => fail(app, format_args!("the monkey's files cannot be written: {error}")),
    }
    match options.script.as_deref().map(Script::read) {
        Some(Ok(script)) => {
            app.insert_resource(script).add_systems(
                PostUpdate,
                script::run_script
                    .before(EditorSystems::Apply)
                    .after(EguiPostUpdateSet::EndPass),
            );
        }
        Some(Err(error)) => fail(app, error),
        None => {}
    }
}

/// Ends the program with an error as soon as it runs.
fn fail(app: &mut App, error: impl Display) {
    terminal::line(format_args!("error: {error}"));
    app.add_systems(Startup, |mut exit: MessageWriter<AppExit>| {
        exit.write(AppExit::error());
    });
}
