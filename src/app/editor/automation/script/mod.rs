//! Replays a script: a file of named commands, one a line, which are applied one after the other as a user would.
//!
//! No line is carried out if one has a fault that does not depend on the scene, such as a misspelt verb. A line begins
//! when the effects of the one before are loaded and in the picture. The first error ends the run. After `wait N` the
//! picture has exactly N samples per pixel and keeps that number until the next `wait`; lines that save or measure it
//! repeat that wait if the scene was changed in between, as they do after `wait done`. Saved files therefore do not
//! depend on the speed of the machine.

pub mod assign;
pub mod baking;
mod blocking;
pub mod error;
mod files;
mod keys;
mod light;
mod materials;
mod media;
mod names;
pub mod parse;
mod placing;
mod properties;
mod rendering;
mod set;
mod texturing;
mod things;
mod timeline;
pub mod verb;
mod view;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};

use super::exit_door::ExitDoor;
use super::screenshot::{WindowWait, save_window};
use crate::app::editor::command::{BakeCommand, Command, FileCommand};
use crate::app::editor::commands;
use crate::app::editor::commands::bare_world::bare_world;
use crate::app::editor::picture::awaited_image::{AwaitedImage, EndedImage};
use crate::app::editor::picture::resolution::PicturePlace;
use crate::app::editor::session::kept_picture::{KeptPictures, Returning};
use crate::app::editor::session::requests::Requests;
use crate::app::editor::words::figures::counted;
use crate::app::terminal;
use crate::engine::{RenderControl, RenderState, RenderStatus};
use crate::files::{LARGEST_NOTE, read_text};
use crate::scene::{SceneState, SceneStatus, SceneWatch};
use baking::BakeWait;
use error::{ScriptError, ScriptNotBegun};
use parse::{Step, Wait};

/// Frames after which the effect of a command has begun: it is applied in one, noticed in the next.
const FRAMES_TO_BEGIN: u32 = 3;

/// The name of the obstacle of lines that wait because of [`Script::wait`].
const SAMPLES: &str = "samples";

#[derive(Resource, Debug)]
pub(crate) struct Script {
    path: PathBuf,
    /// The lines with their numbers, from 1.
    lines: VecDeque<(usize, String)>,
    /// Frames since the last command.
    frames: u32,
    /// A parsed line that has to wait.
    step: Option<Step>,
    wait: Option<Wait>,
    /// Whether the last `wait` was for the end of the picture.
    waited_for_end: bool,
    /// The obstacle that the next line waits for, in words.
    obstacle: Option<&'static str>,
    /// The event of the bake that the next line waits for.
    bake: Option<BakeWait>,
    screenshot_awaited: bool,
    /// The wait before a screenshot.
    window_wait: WindowWait,
    /// Whether the full film is being rendered for an image to save.
    image_awaited: bool,
    failed: bool,
    /// The number of the last line begun.
    number: usize,
    /// Whether it opens a scene.
    opens: bool,
}

impl Script {
    /// Reads a script. An error if a line has a fault that does not depend on the scene: then no line is carried out.
    pub fn read(path: &Path) -> Result<Self, ScriptNotBegun> {
        let path = path.to_owned();
        let text = match read_text(&path, LARGEST_NOTE) {
            Ok(text) => text,
            Err(error) => return Err(ScriptNotBegun::File { path, error }),
        };
        let lines: VecDeque<(usize, String)> = (1..).zip(text.lines().map(str::to_owned)).collect();
        if let Some((line, error)) = first_fault(&lines) {
            return Err(ScriptNotBegun::Line { path, line, error });
        }
        Ok(Self {
            path,
            lines,
            frames: 0,
            step: None,
            wait: None,
            waited_for_end: false,
            obstacle: None,
            bake: None,
            screenshot_awaited: false,
            window_wait: WindowWait::default(),
            image_awaited: false,
            failed: false,
            number: 0,
            opens: false,
        })
    }

    /// Whether all lines are carried out and their pictures saved. The effects of the last line may still be pending.
    pub fn is_done(&self) -> bool {
        self.lines.is_empty()
            && self.step.is_none()
            && self.wait.is_none()
            && self.bake.is_none()
            && !self.screenshot_awaited
            && !self.image_awaited
            && self.frames >= FRAMES_TO_BEGIN
    }

    /// The pending wait in words: the line, and the progress of the picture.
    pub fn awaited(&self, status: &RenderStatus) -> String {
        let place = format!("{}:{}", self.path.display(), self.number);
        let samples = counted(status.samples.into(), "sample");
        if let Some(obstacle) = self.obstacle.filter(|obstacle| *obstacle != SAMPLES) {
            return format!("at {place}, which waits for {obstacle}: the picture has {samples} per pixel");
        }
        match (self.wait, &self.bake) {
            (_, Some(_)) => format!("at {place}, which waits for a bake"),
            (Some(Wait::Samples(wanted)), _) if wanted > 0 => {
                format!(
                    "at {place}, which waits for {wanted} samples per pixel: the picture has {}",
                    status.samples
                )
            }
            (Some(Wait::Done), _) => {
                format!("at {place}, which waits until the picture is done: it has {samples} per pixel")
            }
            _ => format!("at {place}: the picture has {samples} per pixel"),
        }
    }
}

/// The first line with a fault that does not depend on the scene, and its number.
fn first_fault(lines: &VecDeque<(usize, String)>) -> Option<(usize, ScriptError)> {
    // This world has no scene, so that lines that depend on one give errors marked as such.
    let mut world = bare_world();
    lines.iter().find_map(|(number, line)| {
        let error = parse::line(&mut world, line).err()?;
        (!error.depends_on_scene()).then_some((*number, error))
    })
}

/// Carries out the next line when its obstacles are gone.
pub(crate) fn run_script(world: &mut World) {
    let Some(mut script) = world.remove_resource::<Script>() else {
        return;
    };
    script.frames += 1;
    if !script.failed {
        match obstacle(world, &mut script) {
            Ok(obstacle) => {
                script.obstacle = obstacle;
                if obstacle.is_none() {
                    script.next(world);
                }
            }
            Err(error) => script.fail(world, &error),
        }
    }
    script.image_awaited = world.contains_resource::<AwaitedImage>();
    world.insert_resource(script);
}

/// The obstacle of the next line, in words. An error if it will never go away.
fn obstacle(world: &World, script: &mut Script) -> Result<Option<&'static str>, ScriptError> {
    if script.frames < FRAMES_TO_BEGIN {
        return Ok(Some("the next frame of the window"));
    }
    if script.screenshot_awaited {
        return Ok(Some("the screenshot"));
    }
    let scene = world.resource::<SceneStatus>();
    if scene.state == SceneState::Loading || scene.files_loading() > 0 {
        return Ok(Some("the files of the scene"));
    }
    if script.opens && scene.state == SceneState::Failed {
        return Err(ScriptError::Scene);
    }
    if let Some(reason) = &world.resource::<KeptPictures>().failure {
        return Err(reason.clone().into());
    }
    if world.contains_resource::<AwaitedImage>() {
        return Ok(Some("the picture that is to be saved"));
    }
    if world.contains_resource::<Returning>() {
        return Ok(Some("the kept picture"));
    }
    if !world.resource::<PicturePlace>().is_settled() {
        return Ok(Some("the size of the picture"));
    }
    if let Some(EndedImage(Err(reason))) = world.get_resource::<EndedImage>() {
        return Err(reason.clone().into());
    }
    let status = world.resource::<RenderStatus>();
    if !status.is_up_to_date {
        return Ok(Some("the picture of the last change"));
    }
    if commands::awaits_denoised(world) {
        return Ok(Some("the denoised picture"));
    }
    if let Some(search) = commands::light_paint::search_under_way(world) {
        return Ok(Some(search));
    }
    if let Some(wait) = script.bake {
        if !baking::has_come(world, wait)? {
            return Ok(Some("a bake"));
        }
        script.bake = None;
    }
    if !baking::is_lit_level_seen(world) {
        return Ok(Some("the level by its lightmaps"));
    }
    let Some(wait) = script.wait else {
        return Ok(None);
    };
    match (status.state, wait) {
        (_, Wait::Samples(0)) => {}
        (RenderState::Done, Wait::Samples(samples)) if status.samples < samples => return Ok(Some(SAMPLES)),
        (RenderState::Done, _) => {}
        (RenderState::Loading | RenderState::Building | RenderState::Rendering, _) => return Ok(Some(SAMPLES)),
        (RenderState::Idle, _) => return Err(ScriptError::Wait("there is no camera")),
        (RenderState::Paused, _) => return Err(ScriptError::Wait("rendering is paused")),
        (RenderState::Failed, _) => return Err(ScriptError::Wait("rendering has failed")),
    }
    script.wait = None;
    Ok(None)
}

/// The last wait for samples, if the picture does not, or no longer, fulfil it.
fn lost_wait(world: &World, waited_for_end: bool) -> Option<Wait> {
    let status = world.resource::<RenderStatus>();
    let rests = matches!(status.state, RenderState::Done | RenderState::Paused);
    match world.resource::<RenderControl>().exact_samples {
        Some(wanted) => (!rests || status.samples != wanted).then_some(Wait::Samples(wanted)),
        None => (waited_for_end && !rests).then_some(Wait::Done),
    }
}

impl Script {
    fn next(&mut self, world: &mut World) {
        let step = match self.step.take() {
            Some(step) => step,
            None => match self.read_line(world) {
                Some(Ok(step)) => step,
                Some(Err(error)) => return self.fail(world, &error),
                None => return,
            },
        };
        let shows_picture = match &step {
            Step::Do(command) => command.traits().is_about_pixels,
            Step::Screenshot(_) => true,
            Step::Wait(_) | Step::Bake(_) | Step::AwaitBake(_) => false,
        };
        if shows_picture && let Some(wait) = lost_wait(world, self.waited_for_end) {
            self.wait = Some(wait);
            self.step = Some(step);
            return;
        }
        if matches!(step, Step::Screenshot(_)) && !self.window_wait.is_over(world.resource(), world.resource()) {
            self.obstacle = Some("the previews of materials");
            self.step = Some(step);
            return;
        }
        if let Err(error) = self.begin(world, step) {
            self.fail(world, &error);
        }
    }

    /// The next line that is neither empty nor a comment; None after the last one.
    fn read_line(&mut self, world: &mut World) -> Option<Result<Step, ScriptError>> {
        while let Some((number, text)) = self.lines.pop_front() {
            match parse::line(world, &text) {
                Ok(None) => {}
                Ok(Some(step)) => {
                    self.number = number;
                    return Some(Ok(step));
                }
                Err(error) => {
                    self.number = number;
                    return Some(Err(error));
                }
            }
        }
        None
    }

    fn fail(&mut self, world: &mut World, error: &ScriptError) {
        terminal::line(format_args!("error: {}:{}: {error}", self.path.display(), self.number));
        let door = world.get_resource_mut::<ExitDoor>();
        if let Some(picture) = door.and_then(|mut door| door.give_up()) {
            terminal::line(format_args!("error: {}: no picture was written", picture.display()));
        }
        self.lines.clear();
        (self.step, self.wait, self.bake) = (None, None, None);
        self.failed = true;
        world.write_message(AppExit::error());
    }

    fn begin(&mut self, world: &mut World, step: Step) -> Result<(), ScriptError> {
        self.frames = 0;
        match step {
            Step::Do(command) => {
                world.resource_mut::<Requests>().interaction += 1;
                self.opens = matches!(command, Command::File(FileCommand::OpenScene(_)));
                let saves_image = matches!(command, Command::File(FileCommand::SaveImage(_)));
                commands::apply_now(world, command).map_err(|error| {
                    // The program ends with the script, and its samples with it.
                    match saves_image.then(|| commands::keep_image(world)).flatten() {
                        Some(kept) => ScriptError::Kept { error, kept },
                        None => error.into(),
                    }
                })?;
            }
            Step::Bake(folder) => {
                commands::apply_now(world, BakeCommand::Begin(folder))?;
                self.bake = Some(BakeWait::End);
            }
            Step::AwaitBake(wait) => self.bake = Some(wait),
            Step::Wait(wait) => {
                let mut control = world.resource_mut::<RenderControl>();
                control.exact_samples = match wait {
                    Wait::Samples(0) => control.exact_samples,
                    Wait::Samples(samples) => Some(samples),
                    Wait::Done => None,
                };
                if wait != Wait::Samples(0) {
                    self.waited_for_end = wait == Wait::Done;
                }
                self.wait = Some(wait);
            }
            Step::Screenshot(path) => {
                self.screenshot_awaited = true;
                world.spawn(Screenshot::primary_window()).observe(
                    move |captured: On<ScreenshotCaptured>,
                          mut script: ResMut<Script>,
                          scene: Res<SceneWatch>,
                          mut exit: MessageWriter<AppExit>| {
                        script.screenshot_awaited = false;
                        if let Err(error) = save_window(&captured.image, &path, &scene) {
                            let (file, line) = (script.path.display(), script.number);
                            terminal::line(format_args!("error: {file}:{line}: {error}"));
                            exit.write(AppExit::error());
                        }
                    },
                );
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_waited_for_is_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("script.txt");
        std::fs::write(&path, "wait 64").expect("a file");
        let mut script = Script::read(&path).expect("a script");
        script.number = 1;
        let status = RenderStatus {
            samples: 48,
            ..RenderStatus::default()
        };
        let said = |script: &Script, words: &str| {
            let text = script.awaited(&status);
            assert!(text.contains("script.txt:1") && text.contains(words), "{text}");
        };
        script.wait = Some(Wait::Samples(64));
        said(&script, "waits for 64 samples per pixel: the picture has 48");
        script.wait = Some(Wait::Done);
        said(&script, "until the picture is done: it has 48 samples per pixel");
        script.wait = None;
        said(&script, ": the picture has 48 samples per pixel");
        script.bake = Some(BakeWait::End);
        said(&script, "waits for a bake");
        script.obstacle = Some("the denoised picture");
        said(
            &script,
            "waits for the denoised picture: the picture has 48 samples per pixel",
        );
    }

    #[test]
    fn a_line_that_saves_waits_again_for_what_was_waited_for() {
        let mut world = World::new();
        world.init_resource::<RenderControl>();
        let mut lost = |exact_samples, waited_for_end, state, samples| {
            world.resource_mut::<RenderControl>().exact_samples = exact_samples;
            world.insert_resource(RenderStatus {
                state,
                samples,
                ..RenderStatus::default()
            });
            lost_wait(&world, waited_for_end)
        };
        use RenderState::{Done, Paused, Rendering};
        assert_eq!(lost(Some(32), false, Rendering, 16), Some(Wait::Samples(32)));
        assert_eq!(lost(Some(32), false, Done, 64), Some(Wait::Samples(32)));
        assert_eq!(lost(Some(32), false, Done, 32), None);
        assert_eq!(lost(None, true, Rendering, 16), Some(Wait::Done));
        assert_eq!(lost(None, true, Done, 64), None);
        assert_eq!(lost(None, true, Paused, 16), None);
        // Nothing was waited for.
        assert_eq!(lost(None, false, Rendering, 16), None);
    }

    #[test]
    fn lines_that_no_scene_makes_right_are_found_before_the_first_is_done() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("script.txt");
        let refusal = |line: &str| {
            std::fs::write(&path, format!("# Begins well.\nadd cube name=box at=0,0,0\n{line}\n")).expect("a file");
            Script::read(&path).err().map(|error| error.to_string())
        };
        // The third to fifth would be wrong in this scene, and the sixth without a selection.
        for line in [
            "",
            "wait 4",
            "move lamp 1,0,0",
            "set box radius 2",
            "look-through eye",
            "delete",
            "denoise on",
        ] {
            assert_eq!(refusal(line), None, "{line}");
        }
        for (line, words) in [
            ("moove box 1,0,0", "did you mean `move`"),
            ("move box 1,0", "usage: move NAME X,Y,Z"),
            ("push box top 1", "expected a face"),
            ("cut door box 1 depth=2", "expected sill=, width= or height="),
            ("make box difuse", "did you mean `diffuse`"),
            ("lock maybe box", "expected `on` or `off`"),
            ("limit-noise 0", "above 0 and up to 1"),
            ("select \"box", "not closed"),
        ] {
            let message = refusal(line).expect(line);
            assert!(
                message.contains("script.txt:3: ") && message.contains(words),
                "{message}"
            );
        }
    }

    #[test]
    fn the_scripts_of_the_project_are_begun() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for name in [
            "tests/scripts/room.txt",
            "docs/tutorial/room.txt",
            "docs/tutorial/flat.txt",
        ] {
            Script::read(&root.join(name)).expect(name);
        }
    }

    #[test]
    fn the_reason_why_a_scene_is_not_opened_is_left_to_the_log() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("script.txt");
        std::fs::write(&path, "open absent.xml").expect("a file");
        let mut script = Script::read(&path).expect("a script");
        (script.opens, script.frames) = (true, FRAMES_TO_BEGIN);
        let mut world = World::new();
        world.insert_resource(SceneStatus {
            state: SceneState::Failed,
            ..SceneStatus::default()
        });
        let error = obstacle(&world, &mut script).expect_err("it failed");
        assert_eq!(error.to_string(), "the scene cannot be read");
    }
}
