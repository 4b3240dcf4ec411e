//! Saves large scenes on another thread while the user continues to edit. The scene is copied over some frames first;
//! its state at the end of the copy is saved, and later edits are edits of the new file. Commands that read or write
//! files of the scene, and the end of the program, wait for it.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on};

use super::files;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::{Command, FileCommand, ShellCommand};
use crate::app::editor::session::history::{self, History};
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::app::editor::session::tutorial::Tutorial;
use crate::scene::write::{Following, MOST_ATTEMPTS, OnChange, Save, SaveError, Written};
use crate::scene::{DocumentOrder, SceneState, SceneStatus};

/// From this number of things on a save is done on another thread; smaller scenes are saved within a frame.
const MANY: usize = 4096;
/// The time per frame in which the scene is copied, or the entities follow the new file.
const LONGEST: Duration = Duration::from_millis(10);
/// The number of things that are copied or follow between two looks at the clock.
const STEP: usize = 256;

/// The running save.
#[derive(Resource)]
pub(crate) struct SaveUnderWay {
    request: Request,
    stage: Stage,
}

struct Request {
    command: Command,
    path: PathBuf,
    on_change: OnChange,
    /// How often others have changed the files during this save.
    disturbed: usize,
}

enum Stage {
    Copying(Box<Save>),
    Writing(Task<Result<Option<Written>, SaveError>>),
    Following(Box<Following>),
}

fn pool() -> &'static AsyncComputeTaskPool {
    AsyncComputeTaskPool::get_or_init(TaskPool::default)
}

/// The path and the mode of the save that a command asks for; None for other commands.
fn target(world: &World, command: &Command) -> Option<(PathBuf, OnChange)> {
    let Command::File(command) = command else {
        return None;
    };
    match command {
        FileCommand::Save => Some((world.resource::<SceneStatus>().path.clone()?, OnChange::Refuse)),
        FileCommand::SaveScene(path) => Some((path.clone(), OnChange::Refuse)),
        FileCommand::SaveChanged(path, on_change) => Some((path.clone(), *on_change)),
        FileCommand::NewScene
        | FileCommand::OpenScene(_)
        | FileCommand::ReloadScene
        | FileCommand::RevertScene
        | FileCommand::ExportScene(_)
        | FileCommand::SaveImage(_)
        | FileCommand::ShowDialog(_)
        | FileCommand::Quit => None,
    }
}

/// Begins to save a large scene on another thread. Returns false, with nothing done, for other commands and scenes.
pub fn begin(world: &mut World, command: &Command) -> Result<bool, CommandError> {
    let Some((path, on_change)) = target(world, command) else {
        return Ok(false);
    };
    let count = world.query::<&DocumentOrder>().iter(world).len();
    if count < MANY || world.resource::<SceneStatus>().state == SceneState::Loading {
        return Ok(false);
    }
    make_way(world, command)?;
    if !matches!(command, Command::File(FileCommand::SaveChanged(..))) && files::ask_about_copy(world, &path) {
        return Ok(true);
    }
    let message = format!("Saving {}", path.display());
    let request = Request {
        command: command.clone(),
        path,
        on_change,
        disturbed: 0,
    };
    start(world, request)?;
    if world.contains_resource::<SaveUnderWay>() {
        world.resource_mut::<Toasts>().info(message);
    }
    Ok(true)
}

/// Begins to save. No save is running afterwards if the user has to be asked first.
fn start(world: &mut World, request: Request) -> Result<(), CommandError> {
    if world.resource::<SceneStatus>().state == SceneState::Loading {
        history::end_save(world, false);
        return Err(CommandError::file("A scene is still being read."));
    }
    let save = match Save::begin(world, &request.path, request.on_change) {
        Ok(mut save) => {
            save.past = history::nearest_file(world, &request.path);
            save
        }
        Err(error) => return files::end_save(world, &request.path, Err(error)),
    };
    world.resource_mut::<History>().begin_save();
    go_on_copying(world, request, Box::new(save));
    Ok(())
}

fn go_on_copying(world: &mut World, request: Request, mut save: Box<Save>) {
    match for_a_while(|| save.copy(world, STEP)) {
        true => copied(world, request, *save),
        false => {
            let stage = Stage::Copying(save);
            world.insert_resource(SaveUnderWay { request, stage });
        }
    }
}

/// Hands the copied scene to the thread that writes it.
fn copied(world: &mut World, request: Request, save: Save) {
    world.resource_mut::<History>().begin_save();
    let stage = Stage::Writing(pool().spawn(async move { save.write() }));
    world.insert_resource(SaveUnderWay { request, stage });
}

/// Continues the running save, in every frame.
pub(crate) fn go_on(world: &mut World) {
    let Some(SaveUnderWay { request, stage }) = world.remove_resource() else {
        return;
    };
    match stage {
        Stage::Copying(save) => go_on_copying(world, request, save),
        Stage::Writing(mut writing) => match check_ready(&mut writing) {
            Some(result) => tell(world, |world| written(world, request, result)),
            None => {
                let stage = Stage::Writing(writing);
                world.insert_resource(SaveUnderWay { request, stage });
            }
        },
        Stage::Following(mut following) => match for_a_while(|| following.step(world, STEP)) {
            true => tell(world, |world| followed(world, request, *following)),
            false => {
                let stage = Stage::Following(following);
                world.insert_resource(SaveUnderWay { request, stage });
            }
        },
    }
}

/// Repeats a step until it returns true or the time of a frame is over. Returns true after the last step.
fn for_a_while(mut step: impl FnMut() -> bool) -> bool {
    let begun = Instant::now();
    while begun.elapsed() < LONGEST {
        if step() {
            return true;
        }
    }
    false
}

/// Waits for the end of the running save, if there is one. An error if it failed.
pub(crate) fn finish(world: &mut World) -> Result<(), CommandError> {
    while let Some(SaveUnderWay { request, stage }) = world.remove_resource() {
        match stage {
            Stage::Copying(mut save) => {
                while !save.copy(world, usize::MAX) {}
                copied(world, request, *save);
            }
            Stage::Writing(writing) => written(world, request, block_on(writing))?,
            Stage::Following(mut following) => {
                while !following.step(world, STEP) {}
                followed(world, request, *following)?;
            }
        }
    }
    Ok(())
}

/// Lets a running save end before the program does.
pub(crate) fn finish_at_exit(world: &mut World) {
    let ended = finish(world).and_then(|()| files::unanswered(world, &Command::from(FileCommand::Quit)));
    if let Err(error) = ended {
        error!("The scene could not be saved: {error}");
    }
}

/// Finishes the running save before a command that must not overlap with it. After a failure only a command that saves
/// is done. A command that loses edits is not done either while there is a question how to save them.
pub(crate) fn make_way(world: &mut World, command: &Command) -> Result<(), CommandError> {
    let reads = matches!(
        command,
        Command::File(FileCommand::ReloadScene) | Command::Shell(ShellCommand::AllowFiles(_))
    );
    if command.traits().saves {
        tell(world, finish);
    } else if reads || command.traits().loses_edits {
        finish(world)?;
    }
    if command.traits().loses_edits && world.resource::<Requests>().save_question.is_some() {
        return Err("The scene is not saved yet: there is a question about its file.".into());
    }
    Ok(())
}

fn tell(world: &mut World, act: impl FnOnce(&mut World) -> Result<(), CommandError>) {
    if let Err(error) = act(world) {
        let mut toasts = world.resource_mut::<Toasts>();
        toasts.error(Topic::Saving, error.to_string(), None);
    }
}

/// Continues after the files were written, or reports that they were not.
fn written(
    world: &mut World,
    mut request: Request,
    result: Result<Option<Written>, SaveError>,
) -> Result<(), CommandError> {
    match result {
        Ok(Some(written)) => {
            let stage = Stage::Following(Box::new(written.follow(world)));
            world.insert_resource(SaveUnderWay { request, stage });
            Ok(())
        }
        // Others have changed the files in this very moment.
        Ok(None) => {
            request.disturbed += 1;
            if request.disturbed < MOST_ATTEMPTS {
                return start(world, request);
            }
            let path = request.path.clone();
            files::end_save(world, &request.path, Err(SaveError::Restless { path }))
        }
        Err(error) => files::end_save(world, &request.path, Err(error)),
    }
}

/// Ends the save: the scene is now that of the file.
fn followed(world: &mut World, request: Request, following: Following) -> Result<(), CommandError> {
    let (saved, old) = following.finish();
    pool().spawn(async move { drop(old) }).detach();
    let trouble = files::note_saved(world, saved);
    files::end_save(world, &request.path, Ok(trouble))?;
    let is_saved = world.resource::<History>().is_saved();
    if let Some(mut tutorial) = world.get_resource_mut::<Tutorial>()
        && tutorial.step.is_some()
    {
        tutorial.note(&request.command, is_saved);
    }
    Ok(())
}

/// Runs `change`, which edits the files, at the moment in which the running save checks for changes by others.
#[cfg(test)]
pub(super) fn disturb(world: &mut World, change: impl FnOnce()) {
    copy(world, usize::MAX);
    let Some(SaveUnderWay { request, stage }) = world.remove_resource() else {
        panic!("nothing is being saved");
    };
    if let Stage::Writing(writing) = stage {
        drop(block_on(writing));
    }
    change();
    let stage = Stage::Writing(pool().spawn(async { Ok(None) }));
    world.insert_resource(SaveUnderWay { request, stage });
}

/// Copies more of the scene that is being saved; returns true once it is copied.
#[cfg(test)]
pub(super) fn copy(world: &mut World, things: usize) -> bool {
    let Some(SaveUnderWay { request, stage }) = world.remove_resource() else {
        panic!("nothing is being saved");
    };
    match stage {
        Stage::Copying(mut save) => match save.copy(world, things) {
            true => copied(world, request, *save),
            false => {
                let stage = Stage::Copying(save);
                world.insert_resource(SaveUnderWay { request, stage });
                return false;
            }
        },
        stage => world.insert_resource(SaveUnderWay { request, stage }),
    }
    true
}
