//! Applies [`Command`]s: this is the only place of the editor that writes to the scene. May import `model` and the
//! modules below it.
//!
//! Values are compared before they are written, so that setting an equal value changes nothing. Edits of the scene
//! become steps of the [`History`]; one that fails leaves nothing behind.

mod adding;
mod arranging;
pub mod baking;
pub mod bare_world;
mod blocking;
mod copying;
mod display;
pub mod exporting;
mod file_use;
mod files;
mod finding;
mod finished;
pub(crate) mod fitting;
pub(crate) mod flight;
pub(crate) mod full_film;
mod grouping;
mod history;
mod importing;
pub(crate) mod kept_picture;
pub(crate) mod light_paint;
mod material_names;
mod materials;
mod media;
mod media_boxes;
mod media_upkeep;
mod outline;
mod placing;
pub(crate) mod plugin;
mod preset_media;
mod projection;
mod properties;
mod rendering;
mod replacing;
mod roofing;
pub(crate) mod saving;
mod scene;
pub mod scene_watch;
pub(crate) mod seeing;
mod selection;
mod settings;
pub mod shell;
mod spot;
mod taken;
#[cfg(test)]
mod tests;
pub(crate) mod texturing;
pub mod things;
pub(crate) mod timeline;
mod titles;
mod tools;
mod uv_projection;
mod values;
mod view;
mod volumes;
pub mod world;

use bevy::prelude::*;

use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::traits::Effect;
use crate::app::editor::command::{Command, EditCommand, FileCommand};
use crate::app::editor::picture::denoiser::Denoiser;
use crate::app::editor::picture::frame_times::FrameTimes;
use crate::app::editor::picture::motion::Motion;
use crate::app::editor::picture::pacing::Pacing;
use crate::app::editor::session::history::{Edit, History};
use crate::app::editor::session::requests::{CommandQueue, Requests};
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::app::editor::session::tutorial::Tutorial;
use crate::engine::InputStamp;
use crate::scene::SceneStatus;
pub(crate) use files::keep_image;
pub(crate) use finished::awaits_denoised;
use selection::keep_what_is_there;
use titles::Title;

/// Applies this frame's commands in order.
pub(crate) fn apply_commands(world: &mut World) {
    if world
        .get_resource::<SceneStatus>()
        .is_some_and(|status| status.is_opening)
    {
        // Only a part of the scene is there.
        return;
    }
    let commands = std::mem::take(&mut world.resource_mut::<CommandQueue>().0);
    let commands = keep_for_later(world, commands);
    if commands.is_empty() {
        return;
    }
    note_input(world, commands.iter().any(|command| command.traits().restarts_picture));
    if commands.iter().any(|command| command.traits().moves_picture)
        && let Some(mut motion) = world.get_resource_mut::<Motion>()
    {
        motion.note_change();
    }
    for command in commands {
        let saves = command.traits().saves;
        let result = match (saving::begin(world, &command), command) {
            (Ok(false), Command::File(FileCommand::ExportScene(path))) => exporting::begin(world, path),
            (Ok(false), command) => apply(world, command),
            (begun, _) => begun.map(|_| ()),
        };
        world.resource_mut::<Requests>().saves_handled += u64::from(saves);
        let Err(error) = result else { continue };
        let mut toasts = world.resource_mut::<Toasts>();
        match error {
            CommandError::Refused(reason) => toasts.reject(reason),
            CommandError::File(error) => toasts.error(Topic::Saving, error.to_string(), None),
        }
    }
}

/// Defers commands that need the picture at full resolution until it has it. Returns the others, to be applied now.
fn keep_for_later(world: &mut World, commands: Vec<Command>) -> Vec<Command> {
    let Some(mut motion) = world.get_resource_mut::<Motion>().filter(|motion| !motion.is_settled()) else {
        return commands;
    };
    let (later, now): (Vec<Command>, Vec<Command>) = commands
        .into_iter()
        .partition(|command| command.traits().is_about_pixels);
    if !later.is_empty() {
        motion.stop();
        world.resource_mut::<CommandQueue>().0.extend(later);
    }
    now
}

/// Applies a command in this frame and returns its error. A question to the user is returned as an error as well.
pub(crate) fn apply_now(world: &mut World, command: impl Into<Command>) -> Result<(), CommandError> {
    let command = command.into();
    note_input(world, command.traits().restarts_picture);
    apply(world, command.clone())?;
    full_film::confirm(world)?;
    files::unanswered(world, &command)
}

fn note_input(world: &mut World, restarts: bool) {
    // Input is read at the start of the frame.
    let arrived = world.resource::<FrameTimes>().frame_started();
    world.insert_resource(InputStamp(arrived));
    // The cores are needed for the new picture.
    if restarts && let Some(mut denoiser) = world.get_resource_mut::<Denoiser>() {
        denoiser.interrupt();
    }
    world.resource_mut::<Pacing>().note_commands(restarts);
}

/// Applies the command. After an error nothing is changed.
pub fn apply(world: &mut World, command: impl Into<Command>) -> Result<(), CommandError> {
    apply_any(world, command.into())
}

fn apply_any(world: &mut World, command: Command) -> Result<(), CommandError> {
    flight::make_way(world, &command);
    saving::make_way(world, &command)?;
    let lesson = world
        .get_resource::<Tutorial>()
        .filter(|tutorial| tutorial.step.is_some())
        .map(|_| command.clone());
    apply_topic(world, command)?;
    keep_what_is_there(world);
    if let Some(command) = lesson {
        let is_saved = world.resource::<History>().is_saved();
        world.resource_mut::<Tutorial>().note(&command, is_saved);
    }
    Ok(())
}

fn edit(world: &mut World, command: EditCommand) -> Result<(), CommandError> {
    let traits = command.traits();
    let title = Title::before(world, &command);
    let interaction = world.resource::<Requests>().interaction;
    let mut edit = Edit::begin(world);
    match edit_topic(&mut edit, command).and_then(|()| edit.check_poses()) {
        Ok(()) => {
            media_upkeep::follow(&mut edit);
            properties::follow_names(&mut edit);
            edit.follow_keys();
            let title = title.after(edit.world);
            keep_what_is_there(edit.world);
            let merges = traits.effect == Effect::Drag;
            edit.finish(title, merges.then(|| (interaction, (traits.label, traits.targets()))));
            Ok(())
        }
        Err(error) => {
            edit.abandon();
            Err(error)
        }
    }
}

fn apply_topic(world: &mut World, command: Command) -> Result<(), CommandError> {
    match command {
        Command::Edit(command) => edit(world, command),
        Command::File(command) => files::apply(world, command),
        Command::History(command) => history::apply(world, command),
        Command::Selection(command) => selection::apply(world, command),
        Command::View(command) => view::apply(world, command),
        Command::Time(command) => timeline::apply(world, command),
        Command::Render(command) => rendering::apply(world, command),
        Command::Display(command) => display::apply(world, command),
        Command::Tool(command) => tools::apply(world, command),
        Command::Bake(command) => baking::apply(world, command),
        Command::KeptPicture(command) => kept_picture::apply(world, command),
        Command::Shell(command) => shell::apply(world, command),
    }
}

fn edit_topic(edit: &mut Edit, command: EditCommand) -> Result<(), CommandError> {
    match command {
        EditCommand::Scene(command) => scene::edit(edit, command),
        EditCommand::Arrange(command) => placing::edit(edit, command),
        EditCommand::Outline(command) => outline::edit(edit, command),
        EditCommand::Material(command) => materials::edit(edit, command),
        EditCommand::Texture(command) => texturing::edit(edit, command),
        EditCommand::Medium(command) => media::edit(edit, command),
        EditCommand::Value(command) => values::edit(edit, command),
        EditCommand::OnSelection(command) => values::edit_selection(edit, *command),
        EditCommand::Property(command) => properties::edit(edit, command),
        EditCommand::Settings(command) => settings::edit(edit, command),
        EditCommand::Camera(command) => view::edit(edit, command),
        EditCommand::Time(command) => timeline::edit(edit, command),
    }
}
