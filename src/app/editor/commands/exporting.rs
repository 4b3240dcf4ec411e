//! Exports the scene to glTF. The scene is copied at once, and the files are made and written on another thread while
//! the user continues to edit.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on};

use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::toasts::Toasts;
use crate::files::Access;
use crate::scene::description::SceneDescription;
use crate::scene::export::{ExportError, Hidden, export};
use crate::scene::write::gather::describe_entities;
use crate::scene::{self, SceneAccess, SceneState, SceneStatus};

/// The most losses that the window names; the log has all.
const MOST_NAMED: usize = 8;

/// The messages about data that glTF cannot hold, or the reason why nothing was written.
type Exported = Result<Vec<String>, ExportError>;

/// The running export.
#[derive(Resource)]
pub(crate) struct ExportUnderWay {
    path: PathBuf,
    task: Task<Exported>,
}

/// Begins to export the scene as it is now.
pub(crate) fn begin(world: &mut World, path: PathBuf) -> Result<(), CommandError> {
    if world.contains_resource::<ExportUnderWay>() {
        return Err("An export is still under way.".into());
    }
    let task = start(world, &path)?;
    let message = format!("Exporting to {}", path.display());
    world.resource_mut::<Toasts>().info(message);
    world.insert_resource(ExportUnderWay { path, task });
    Ok(())
}

fn start(world: &mut World, path: &Path) -> Result<Task<Exported>, CommandError> {
    let (scene, hidden, access) = described(world)?;
    let target = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
    Ok(pool.spawn(async move {
        let made = export(&scene, &hidden, &target, &access)?;
        made.write()?;
        Ok(made.messages.into_iter().chain(made.note).collect())
    }))
}

/// The scene as it is now, its hidden entities, and the files that it may read.
pub(super) fn described(world: &mut World) -> Result<(SceneDescription, Hidden, Access), CommandError> {
    if world.resource::<SceneStatus>().state == SceneState::Loading {
        return Err(CommandError::file("A scene is still being read."));
    }
    let (scene, entities) = describe_entities(world);
    let hidden = |entities: &[Entity]| {
        let numbered = entities.iter().enumerate();
        let hidden = numbered.filter(|(_, entity)| world.get::<scene::Hidden>(**entity).is_some());
        hidden.map(|(index, _)| index).collect()
    };
    let hidden = Hidden {
        shapes: hidden(&entities.shapes),
        emitters: hidden(&entities.emitters),
    };
    Ok((scene, hidden, SceneAccess::of(world)))
}

/// Exports the scene, and waits for the end of it.
pub(crate) fn export_now(world: &mut World, path: &Path) -> Result<(), CommandError> {
    finish(world)?;
    let exported = block_on(start(world, path)?);
    tell(world, path, exported)
}

/// Continues the running export, in every frame.
pub(crate) fn go_on(world: &mut World) {
    let Some(ExportUnderWay { path, mut task }) = world.remove_resource() else {
        return;
    };
    let Some(exported) = check_ready(&mut task) else {
        world.insert_resource(ExportUnderWay { path, task });
        return;
    };
    if let Err(error) = tell(world, &path, exported) {
        use crate::app::editor::session::toasts::Topic;
        world
            .resource_mut::<Toasts>()
            .error(Topic::Other, error.to_string(), None);
    }
}

/// Waits for the end of the running export.
fn finish(world: &mut World) -> Result<(), CommandError> {
    match world.remove_resource() {
        Some(ExportUnderWay { path, task }) => tell(world, &path, block_on(task)),
        None => Ok(()),
    }
}

/// Lets a running export end before the program does.
pub(crate) fn finish_at_exit(world: &mut World) {
    if let Err(error) = finish(world) {
        error!("The scene could not be exported: {error}");
    }
}

fn tell(world: &mut World, path: &Path, exported: Exported) -> Result<(), CommandError> {
    let lost = exported.map_err(CommandError::file)?;
    let mut toasts = world.resource_mut::<Toasts>();
    let done = format!("Exported to {}", path.display());
    if lost.is_empty() {
        toasts.info(done);
        return Ok(());
    }
    for message in &lost {
        warn!("{}: {message}", path.display());
    }
    let text = with_list(&format!("{done}. Not all of the scene is in the file:"), &lost);
    toasts.report(text);
    Ok(())
}

/// The text followed by the list of messages, as far as they fit into a toast.
pub(super) fn with_list(text: &str, messages: &[String]) -> String {
    let mut text = text.to_owned();
    for message in messages.iter().take(MOST_NAMED) {
        text += &format!("\n• {message}");
    }
    if let Some(others) = messages.len().checked_sub(MOST_NAMED).filter(|others| *others > 0) {
        text += &format!("\n• {others} more, which are in the log");
    }
    text
}
