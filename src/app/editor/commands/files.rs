//! Commands that read and write scenes and pictures, and the clipboard.

use std::path::{Path, PathBuf};

use bevy::prelude::*;

use super::{baking, exporting, finished, full_film, grouping};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::{Command, FileCommand, FileDialogKind};
use crate::app::editor::session::history::{self, History};
use crate::app::editor::session::options::{BegunWith, SceneDefines};
use crate::app::editor::session::recovery::Recovery;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::save_question::SaveQuestion;
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::words::figures::counted;
use crate::app::editor::words::files::noisy_beside;
use crate::document;
use crate::engine::{RenderFilm, RenderState, RenderStatus, file_options, single_picture};
use crate::layer::Layer;
use crate::render::image_io::{
    FileFormat, ImageIoError, write_displayed, write_image, write_layered, write_to_temporary_folder,
};
use crate::scene::export::ExportError;
use crate::scene::write::{self, OnChange, SaveError, Saved};
use crate::scene::{
    self, ActiveSensor, AuthoredScene, Film, FilmStorage, IntegratorSettings, Keys, OpenScene, Placements, SceneFile,
    SceneState, SceneStatus, SceneWatch, insert,
};

/// Applies the command.
pub fn apply(world: &mut World, command: FileCommand) -> Result<(), CommandError> {
    match command {
        FileCommand::NewScene => {
            baking::leave_scene(world);
            new_scene(world);
        }
        FileCommand::OpenScene(path) => {
            baking::leave_scene(world);
            open_scene(world, path);
        }
        FileCommand::ReloadScene => reload_scene(world)?,
        FileCommand::RevertScene => {
            revert_scene(world)?;
            baking::leave_scene(world);
        }
        FileCommand::Save => save(world)?,
        FileCommand::SaveScene(path) => save_to(world, &path)?,
        FileCommand::SaveChanged(path, on_change) => save_scene(world, &path, on_change)?,
        FileCommand::ExportScene(path) => exporting::export_now(world, &path)?,
        FileCommand::SaveImage(path) => full_film::save_image(world, path)?,
        FileCommand::ShowDialog(kind) => world.resource_mut::<Requests>().dialog = Some(kind),
        FileCommand::Quit => {
            world.write_message(AppExit::Success);
        }
    }
    Ok(())
}

/// The path that stands for the clipboard when its text is parsed: files in it are named by absolute paths.
pub const CLIPBOARD: &str = "/clipboard.xml";

pub fn new_scene(world: &mut World) {
    scene::new_scene(world);
    world.resource_mut::<History>().clear();
    world.resource_mut::<Requests>().leave_start_page();
}

pub fn open_scene(world: &mut World, path: PathBuf) {
    world.resource_mut::<Requests>().leave_start_page();
    world.insert_resource(BegunWith(None));
    let defines = world.resource::<SceneDefines>().0.clone();
    let keeps_edits = false;
    let request = OpenScene {
        path,
        defines,
        keeps_edits,
    };
    scene::ask_for(world, request);
}

/// Reads the scene again, as if the file had changed on disk.
pub fn reload_scene(world: &mut World) -> Result<(), CommandError> {
    let path = own_path(world)?;
    if !world.resource::<SceneFile>().is_followed() {
        return Err("These edits were recovered: save the scene, or revert to the file.".into());
    }
    let defines = world.resource::<SceneDefines>().0.clone();
    let keeps_edits = true;
    let request = OpenScene {
        path,
        defines,
        keeps_edits,
    };
    scene::ask_for(world, request);
    Ok(())
}

pub fn revert_scene(world: &mut World) -> Result<(), CommandError> {
    let path = own_path(world)?;
    open_scene(world, path);
    Ok(())
}

fn own_path(world: &World) -> Result<PathBuf, CommandError> {
    let path = world.resource::<SceneStatus>().path.clone();
    path.ok_or_else(|| "The scene has no file yet.".into())
}

pub fn save(world: &mut World) -> Result<(), CommandError> {
    let status = world.resource::<SceneStatus>();
    if status.state == SceneState::Loading {
        return Err(CommandError::file("A scene is still being read."));
    }
    match status.path.clone() {
        Some(path) => save_to(world, &path),
        None => {
            world.resource_mut::<Requests>().dialog = Some(FileDialogKind::SaveScene);
            Ok(())
        }
    }
}

/// Saves at a path, and asks first if there are newer edits of the scene there.
pub fn save_to(world: &mut World, path: &Path) -> Result<(), CommandError> {
    match ask_about_copy(world, path) {
        true => Ok(()),
        false => save_scene(world, path, OnChange::Refuse),
    }
}

/// Asks before a scene is saved over a file of which newer edits can be recovered. Returns whether it asked.
pub fn ask_about_copy(world: &mut World, path: &Path) -> bool {
    let recovery = world.get_resource_mut::<Recovery>();
    let Some(copy) = recovery.and_then(|mut recovery| recovery.newer_copy_of(path)) else {
        return false;
    };
    world.resource_mut::<Requests>().save_question = Some(SaveQuestion::about_copy(copy, path));
    true
}

/// Saves the scene. Asks the user if others have changed the file so that saving would lose their edits.
pub fn save_scene(world: &mut World, path: &Path, on_change: OnChange) -> Result<(), CommandError> {
    if world.resource::<SceneStatus>().state == SceneState::Loading {
        return Err(CommandError::file("A scene is still being read."));
    }
    world.resource_mut::<History>().begin_save();
    let result = write::save_over(world, path, on_change, |world| history::nearest_file(world, path));
    let result = result.map(|saved| note_saved(world, saved));
    end_save(world, path, result)
}

/// Stores the saved file's state before and after in the history. Returns the reason why the file cannot be reopened as
/// it is.
pub fn note_saved(world: &mut World, mut saved: Saved) -> Option<String> {
    let trouble = saved.trouble.take();
    world.insert_resource(BegunWith(None));
    let scene = world.get_resource::<AuthoredScene>();
    let now = scene.and_then(|scene| scene.origin.clone());
    world.resource_mut::<History>().note_file(saved, now);
    trouble
}

/// Reports the result of a save by a toast, or asks the user.
pub fn end_save(world: &mut World, path: &Path, result: Result<Option<String>, SaveError>) -> Result<(), CommandError> {
    history::end_save(world, result.is_ok());
    let trouble = match result {
        Ok(trouble) => trouble,
        Err(error) => {
            let question = SaveQuestion::about(&error, path).ok_or_else(|| CommandError::file(error))?;
            world.resource_mut::<Requests>().save_question = Some(question);
            return Ok(());
        }
    };
    say_saved(
        world,
        match trouble {
            None => format!("Saved {}", path.display()),
            Some(trouble) => format!("Saved, but it cannot be opened again as it is: {trouble}"),
        },
    );
    Ok(())
}

/// Shows a toast that something is saved, and removes earlier toasts about failed saves.
fn say_saved(world: &mut World, message: String) {
    let mut toasts = world.resource_mut::<Toasts>();
    toasts.forget(Topic::Saving);
    toasts.info(message);
}

/// Cancels the question that the last command asks, and returns it as an error for callers that cannot answer.
pub fn unanswered(world: &mut World, command: &Command) -> Result<(), CommandError> {
    let mut requests = world.resource_mut::<Requests>();
    if let Some(question) = requests.save_question.take() {
        return Err(question.refusal().into());
    }
    if *command == Command::from(FileCommand::Save) && requests.dialog == Some(FileDialogKind::SaveScene) {
        requests.dialog = None;
        return Err("The scene has no file yet: name one with `save-to FILE`.".into());
    }
    Ok(())
}

/// Saves the picture in its present resolution, as an EXR file with its layers.
pub fn save_image(world: &mut World, path: &Path) -> Result<(), CommandError> {
    if world.resource::<RenderStatus>().state == RenderState::Idle {
        return Err(CommandError::file("There is no picture to save."));
    }
    check_scene_stays(world, path)?;
    let display = world.resource::<ViewSettings>().display;
    let is_exr = FileFormat::from_path(path).is_ok_and(|format| format == FileFormat::Exr);
    let is_displayed = FileFormat::from_path(path).is_ok_and(FileFormat::is_displayed);
    let written = if is_displayed && !display.mode.is_light() {
        let (size, rgb) = finished::painted(world);
        write_displayed(path, size, &rgb)
    } else {
        let picture = finished::picture(world);
        // Files with radiance hold that of the scene, without a comparison.
        let picture = if is_displayed {
            finished::compared(world, picture)
        } else {
            picture
        };
        match is_exr {
            true => {
                let options = file_options(film_storage(world), display.tone());
                write_layered(path, &finished::layered(world, &picture), &options)
            }
            false => write_image(path, &picture, &display.tone()),
        }
    };
    written.map_err(CommandError::file)?;
    // Files with radiance go to other programs, which may have another denoiser.
    if !is_displayed && let Some(noisy) = finished::noisy_picture(world) {
        // Both are one picture: saving it again replaces both, and the dialog asks about both.
        let path = noisy_beside(path);
        check_scene_stays(world, &path)?;
        let mut noisy = single_picture(world, &noisy);
        finished::describe(world, &mut noisy);
        let options = file_options(film_storage(world), display.tone());
        write_layered(&path, &noisy, &options).map_err(CommandError::file)?;
        say_saved(world, format!("Saved the picture as sampled as {}", path.display()));
    }
    let samples = counted(world.resource::<RenderStatus>().samples.into(), "sample");
    let mut shown = format!(" with {samples} per pixel");
    if is_displayed && display.mode.is_light() {
        shown.push_str(&format!(" and the tone map {}", display.tone_map.name()));
    }
    if !is_exr && !world.resource::<IntegratorSettings>().layers.is_empty() {
        shown.push_str(", without layers: only EXR files have them");
    }
    let has_motion = world
        .resource::<RenderFilm>()
        .film
        .layers()
        .layers
        .contains(Layer::Motion);
    if is_exr && has_motion && world.query::<&Keys>().iter(world).next().is_some() {
        shown.push_str(", with 0 as motion: only `sunroom render --frames` knows the frame before");
    }
    say_saved(world, format!("Saved {}{shown}", path.display()));
    Ok(())
}

/// Refuses to write a picture over a file of the scene.
pub fn check_scene_stays(world: &World, path: &Path) -> Result<(), CommandError> {
    let is_of_scene = world
        .get_resource::<SceneWatch>()
        .is_some_and(|watch| watch.has_file(path));
    match is_of_scene {
        true => Err(CommandError::file(ExportError::InUse { path: path.to_owned() })),
        false => Ok(()),
    }
}

/// The storage format of the camera's film, as the scene gives it.
fn film_storage(world: &World) -> FilmStorage {
    let sensor = world.get_resource::<ActiveSensor>().and_then(|active| active.0);
    let film = sensor.and_then(|sensor| world.get::<Film>(sensor));
    film.map(|film| film.storage).unwrap_or_default()
}

/// Keeps the picture in a temporary file, if it could not be written to its own place and the program is about to end.
/// Returns a sentence about where it is; None if there is no picture.
pub(crate) fn keep_image(world: &World) -> Option<String> {
    match write_to_temporary_folder(&(&finished::picture(world)).into()) {
        Ok(place) => Some(format!("the picture is kept in {}", place.display())),
        Err(ImageIoError::WrongSize { .. }) => None,
        Err(error) => Some(format!("the picture could not be kept elsewhere: {error}")),
    }
}

/// The selection as XML text, handed to the clipboard by the window.
pub fn copy(world: &mut World) -> Result<(), CommandError> {
    let selected = world.resource::<Selection>().entities().to_vec();
    if selected.is_empty() {
        return Err("Nothing is selected.".into());
    }
    let selected = grouping::whole_groups(world, selected);
    if selected.iter().any(|entity| world.get::<Placements>(*entity).is_some()) {
        return Err("So many instances cannot be copied.".into());
    }
    let part = insert::describe_part(world, &selected);
    let document = write::to_fragment(&part);
    let text = document::to_xml(&document).map_err(|error| error.to_string())?;
    world.resource_mut::<Requests>().clipboard = Some(text);
    Ok(())
}
