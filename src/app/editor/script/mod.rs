//! The replay door: a file of named commands, one a line, done one after the other as a user would.
//!
//! A line begins when what the one before asked for is loaded. The first that fails ends the run.

pub mod assign;
pub mod parse;
mod rendering;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};

use super::command::Command;
use super::commands;
use super::exit_door::{ExitDoor, save_window};
use super::state::EditorState;
use crate::document::Severity;
use crate::engine::{RenderState, RenderStatus};
use crate::files::{self, FileError, LARGEST_NOTE};
use crate::scene::{SceneState, SceneStatus};
use parse::Step;

/// Frames after which what a command has led to has begun: it is applied in one, noticed in the next.
const FRAMES_TO_BEGIN: u32 = 3;

#[derive(Resource, Debug)]
pub struct Script {
    path: PathBuf,
    /// With their numbers from 1 on.
    lines: VecDeque<(usize, String)>,
    /// Frames since the last command.
    frames: u32,
    samples_awaited: Option<u32>,
    screenshot_awaited: bool,
    failed: bool,
    /// The line that was begun last.
    number: usize,
    /// It opens a scene.
    opens: bool,
}

impl Script {
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let text = files::read_text(path, LARGEST_NOTE)?;
        Ok(Self {
            path: path.to_owned(),
            lines: (1..).zip(text.lines().map(str::to_owned)).collect(),
            frames: 0,
            samples_awaited: None,
            screenshot_awaited: false,
            failed: false,
            number: 0,
            opens: false,
        })
    }

    /// All lines are done, and their pictures saved; what the last one has led to may still be on its way.
    pub fn is_done(&self) -> bool {
        self.lines.is_empty()
            && self.samples_awaited.is_none()
            && !self.screenshot_awaited
            && self.frames >= FRAMES_TO_BEGIN
    }
}

/// Does the next line when its time has come.
pub fn run_script(world: &mut World) {
    let Some(mut script) = world.remove_resource::<Script>() else {
        return;
    };
    script.frames += 1;
    if !script.failed {
        match is_ready(world, &mut script) {
            Ok(true) => script.next(world),
            Ok(false) => {}
            Err(error) => script.fail(world, &error),
        }
    }
    world.insert_resource(script);
}

/// The error: it never will be.
fn is_ready(world: &World, script: &mut Script) -> Result<bool, String> {
    if script.frames < FRAMES_TO_BEGIN || script.screenshot_awaited {
        return Ok(false);
    }
    let scene = world.resource::<SceneStatus>();
    if scene.state == SceneState::Loading || scene.files_loading() > 0 {
        return Ok(false);
    }
    if script.opens && scene.state == SceneState::Failed {
        let mut found = scene.diagnostics.list.iter();
        let first = found.find(|found| found.severity == Severity::Error);
        let reason = first.map_or(String::new(), |error| format!(": {}", scene.diagnostics.line(error)));
        return Err(format!("the scene cannot be read{reason}"));
    }
    let status = world.resource::<RenderStatus>();
    if let Some(samples) = script.samples_awaited {
        match status.state {
            RenderState::Loading | RenderState::Building => return Ok(false),
            RenderState::Rendering if status.samples < samples => return Ok(false),
            RenderState::Rendering | RenderState::Done => script.samples_awaited = None,
            RenderState::Idle => return Err("there is no camera: no samples can be waited for".to_owned()),
            RenderState::Paused => return Err("rendering is paused: no samples can be waited for".to_owned()),
            RenderState::Failed => return Err("rendering has failed: no samples can be waited for".to_owned()),
        }
    }
    Ok(true)
}

impl Script {
    fn next(&mut self, world: &mut World) {
        while let Some((number, text)) = self.lines.pop_front() {
            let outcome = match parse::line(world, &text) {
                Ok(None) => continue,
                Ok(Some(step)) => self.begin(world, step),
                Err(error) => Err(error),
            };
            self.number = number;
            if let Err(error) = outcome {
                self.fail(world, &error);
            }
            return;
        }
    }

    fn fail(&mut self, world: &mut World, error: &str) {
        eprintln!("error: {}:{}: {error}", self.path.display(), self.number);
        let door = world.get_resource_mut::<ExitDoor>();
        if let Some(picture) = door.and_then(|mut door| door.give_up()) {
            eprintln!("error: {}: no picture was written", picture.display());
        }
        self.lines.clear();
        self.failed = true;
        world.write_message(AppExit::error());
    }

    fn begin(&mut self, world: &mut World, step: Step) -> Result<(), String> {
        self.frames = 0;
        match step {
            Step::Do(command) => {
                world.resource_mut::<EditorState>().interaction += 1;
                self.opens = matches!(command, Command::OpenScene(_));
                commands::apply_now(world, command)?;
            }
            Step::WaitForSamples(samples) => self.samples_awaited = Some(samples),
            Step::Screenshot(path) => {
                self.screenshot_awaited = true;
                world.spawn(Screenshot::primary_window()).observe(
                    move |captured: On<ScreenshotCaptured>,
                          mut script: ResMut<Script>,
                          mut exit: MessageWriter<AppExit>| {
                        script.screenshot_awaited = false;
                        if let Err(message) = save_window(&captured.image, &path) {
                            let (file, line) = (script.path.display(), script.number);
                            eprintln!("error: {file}:{line}: {message}");
                            exit.write(AppExit::error());
                        }
                    },
                );
            }
        }
        Ok(())
    }
}
