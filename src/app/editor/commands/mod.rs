//! Applies [`Command`]s: this is the only place of the editor that writes to the scene. May import `model` and the
//! modules below it.
//!
//! Values are compared before they are written, so that saying what is already so changes nothing. Edits of the scene
//! become steps of the [`History`]; one that fails leaves nothing behind.

mod adding;
pub mod apply_edit;
mod arranging;
pub mod baking;
pub mod bare_world;
mod blocking;
mod copying;
mod edits;
pub mod exporting;
mod file_use;
mod files;
mod finding;
mod finished;
pub(crate) mod fitting;
pub(crate) mod flight;
pub(crate) mod full_film;
mod grouping;
pub(crate) mod kept_picture;
mod limits;
mod material_names;
mod materials;
mod media;
mod media_boxes;
mod media_upkeep;
mod mixing;
mod pictures;
mod placing;
pub(crate) mod plugin;
mod preset_media;
mod projection;
pub(crate) mod saving;
pub mod scene_watch;
pub(crate) mod seeing;
mod several;
pub mod shell;
mod spot;
mod taken;
#[cfg(test)]
mod tests;
pub(crate) mod texturing;
pub mod things;
pub(crate) mod timeline;
mod titles;
mod uv_projection;
mod view;
mod volumes;
pub mod world;

use bevy::prelude::*;

use crate::app::editor::camera::picking;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::ruler::MOST_RULERS;
use crate::app::editor::command::selection::{Extend, Selection};
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::traits::Effect;
use crate::app::editor::command::{
    Command, DisplayCommand, EditCommand, FileCommand, HistoryCommand, RenderCommand, SelectionCommand, TimeCommand,
    ToolCommand, ViewCommand,
};
use crate::app::editor::picture::compare::Comparison;
use crate::app::editor::picture::denoiser::Denoiser;
use crate::app::editor::picture::frame_times::FrameTimes;
use crate::app::editor::picture::motion::Motion;
use crate::app::editor::picture::pacing::Pacing;
use crate::app::editor::picture::paths::PathInspector;
use crate::app::editor::session::history::{self, Edit, History};
use crate::app::editor::session::requests::{CommandQueue, Requests};
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::app::editor::session::tutorial::Tutorial;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::{InputStamp, PackedScene};
use crate::scene::{
    ActiveSensor, DocumentOrder, Emitter, Hidden, Locked, MemberOf, ObjectState, SceneStatus, Sensor, Shape,
};
pub(crate) use files::keep_image;
pub(crate) use finished::awaits_denoised;
use titles::Title;
use world::{control, set_resource};

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

/// Keeps commands that need the picture at full resolution until it has it. The others are applied.
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

/// Does what the command says. After an error nothing is changed.
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
    match command {
        Command::Edit(command) => edit(world, command)?,
        command => act(world, command)?,
    }
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
    match apply_edit::apply(&mut edit, command).and_then(|()| edit.check_poses()) {
        Ok(()) => {
            media_upkeep::follow(&mut edit);
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

fn act(world: &mut World, command: Command) -> Result<(), CommandError> {
    match command {
        Command::File(FileCommand::NewScene) => {
            baking::leave_scene(world);
            files::new_scene(world);
        }
        Command::File(FileCommand::OpenScene(path)) => {
            baking::leave_scene(world);
            files::open_scene(world, path);
        }
        Command::File(FileCommand::ReloadScene) => files::reload_scene(world)?,
        Command::File(FileCommand::RevertScene) => {
            files::revert_scene(world)?;
            baking::leave_scene(world);
        }
        Command::File(FileCommand::Save) => files::save(world)?,
        Command::File(FileCommand::SaveScene(path)) => files::save_to(world, &path)?,
        Command::File(FileCommand::SaveChanged(path, on_change)) => files::save_scene(world, &path, on_change)?,
        Command::File(FileCommand::ExportScene(path)) => exporting::export_now(world, &path)?,
        Command::Bake(command) => baking::apply(world, command)?,
        Command::File(FileCommand::SaveImage(path)) => full_film::save_image(world, path)?,
        Command::KeptPicture(command) => kept_picture::apply(world, command)?,
        Command::File(FileCommand::ShowDialog(kind)) => world.resource_mut::<Requests>().dialog = Some(kind),
        Command::File(FileCommand::Quit) => {
            world.write_message(AppExit::Success);
        }
        Command::Selection(SelectionCommand::Copy) => files::copy(world)?,

        Command::History(HistoryCommand::Undo) => history::undo(world)?,
        Command::History(HistoryCommand::Redo) => history::redo(world)?,
        Command::History(HistoryCommand::GoTo(steps)) => {
            while world.resource::<History>().len().0 > steps && history::undo(world).is_ok() {}
            while world.resource::<History>().len().0 < steps && history::redo(world).is_ok() {}
        }
        Command::Time(TimeCommand::SetTime(time)) => timeline::set_time(world, time)?,
        Command::Time(TimeCommand::StepTime(step)) => timeline::step(world, step)?,
        Command::Time(TimeCommand::SetPlaying(plays)) => timeline::play(world, plays),
        Command::Time(TimeCommand::SetTimeline(timeline)) => {
            world.resource_mut::<ViewSettings>().timeline = timeline.within_range()
        }
        Command::Time(TimeCommand::ShowTimeline(shown)) => {
            world.resource_mut::<ViewSettings>().timeline_shown = Some(shown)
        }

        Command::Selection(SelectionCommand::Select(entities, how)) => select(world, &entities, how),
        Command::Selection(SelectionCommand::SelectAll) => {
            let mut things = world.query_filtered::<(Entity, &DocumentOrder), (
                Or<(With<Shape>, With<Emitter>)>,
                Without<Locked>,
                Without<Hidden>,
                Without<MemberOf>,
            )>();
            let mut things: Vec<_> = things.iter(world).map(|(entity, order)| (*order, entity)).collect();
            things.sort();
            let things: Vec<Entity> = things.into_iter().map(|(_, entity)| entity).collect();
            select(world, &things, Extend::Replace);
        }
        Command::Selection(SelectionCommand::Pick(film, how)) => {
            let found = picking::pick(world.resource::<PackedScene>(), film);
            let found = found.filter(|entity| world.get::<Locked>(*entity).is_none());
            match (found, how) {
                (None, Extend::Add | Extend::Toggle) => {}
                (found, how) => select(world, found.as_slice(), how),
            }
        }
        Command::Selection(SelectionCommand::SelectGroup) => grouping::select_group(world)?,
        Command::View(ViewCommand::FrameSelection) => view::frame_selection(world)?,
        Command::View(ViewCommand::FrameAll) => view::frame_all(world)?,
        Command::View(ViewCommand::MoveView(pose)) => view::move_view(world, pose),
        Command::View(ViewCommand::SwitchProjection) => projection::switch(world)?,
        Command::View(ViewCommand::LookThrough(entity)) => view::look_through(world, entity),
        Command::View(ViewCommand::TurnAbout(point)) => {
            world.resource_mut::<ViewSettings>().navigation.pivot = Some(point)
        }
        Command::View(ViewCommand::LookAlong(axis)) => view::look_along(world, axis),
        Command::View(ViewCommand::StoreView(number)) => view::store(world, number),
        Command::View(ViewCommand::RecallView(number)) => view::recall(world, number)?,
        Command::View(ViewCommand::SetSpeed(speed)) => world.resource_mut::<ViewSettings>().navigation.set_speed(speed),

        Command::Render(RenderCommand::SetPaused(paused)) => control(world, |control| control.paused = paused),
        Command::Render(RenderCommand::Restart) => control(world, |control| control.restart_requested = true),
        Command::Render(RenderCommand::SetTargetSamples(samples)) => {
            control(world, |control| control.target_samples = Some(samples.max(1)))
        }
        Command::Render(RenderCommand::SetTimeLimit(limit)) => control(world, |control| control.time_limit = limit),
        Command::Render(RenderCommand::SetNoiseTarget(target)) => {
            // Zero is no limit, also where the file has one.
            control(world, |control| control.noise_target = Some(target.unwrap_or(0.0)));
        }
        Command::Render(RenderCommand::SetAdaptive(is_on)) => control(world, |control| control.adaptive = Some(is_on)),
        Command::Render(RenderCommand::SetRegion(region)) => {
            let region = region.map(|region| Rect::from_corners(region.min, region.max));
            control(world, |control| control.region = region);
        }
        Command::Render(RenderCommand::SetPathIsAuto(is_auto)) => {
            control(world, |control| control.path_is_auto = is_auto)
        }
        Command::Render(RenderCommand::SetStrategySplit(split)) => {
            control(world, |control| control.strategy_split = split)
        }
        Command::Render(RenderCommand::SetLightLayers(kept)) => {
            control(world, |control| control.light_layers = kept);
            let display = world.resource::<ViewSettings>().display;
            if !kept && matches!(display.mode, DisplayMode::LightGroup(_)) {
                let mode = DisplayMode::Shaded;
                view::set_display(world, DisplaySettings { mode, ..display });
            }
        }
        Command::Display(DisplayCommand::SetLightMix(mix)) => {
            let mix = world.get_resource_or_init::<LightMix>().with_channels(mix);
            set_resource(world, mix);
        }
        Command::Display(DisplayCommand::ExposeAutomatically) => finished::expose(world)?,
        Command::Display(DisplayCommand::TakeSnapshot) => finished::take_snapshot(world)?,
        Command::Display(DisplayCommand::SetCompareView(view)) => {
            baking::check_view(world, view)?;
            world.resource_mut::<Comparison>().view = view;
        }
        Command::Display(DisplayCommand::Measure) => finished::measure(world)?,
        Command::Render(RenderCommand::SetResolutionScale(scale)) => {
            control(world, |control| control.resolution_scale = scale.clamp(0.05, 1.0));
        }
        Command::Render(RenderCommand::SetResolution(resolution)) => full_film::set_resolution(world, resolution),
        Command::Display(DisplayCommand::SetEnlarging(enlarging)) => {
            world.resource_mut::<ViewSettings>().enlarging = enlarging
        }
        Command::Render(RenderCommand::RenderFull(request)) => full_film::render(world, request)?,
        Command::Render(RenderCommand::StopFull) => full_film::stop(world),
        Command::Display(DisplayCommand::SetDisplay(display)) => view::set_display(world, display),
        Command::Display(DisplayCommand::SetOverlay(overlay)) => world.resource_mut::<ViewSettings>().overlay = overlay,
        Command::View(ViewCommand::SetSeeing(seen)) => seeing::set(world, seen),
        Command::View(ViewCommand::CutOpen) => seeing::cut_open(world)?,
        Command::View(ViewCommand::Isolate(entities)) => seeing::isolate(world, entities)?,
        Command::Tool(ToolCommand::SetTool(tool)) => {
            if tool == Tool::PlaceTexture {
                texturing::need_textures(world)?;
            }
            if tool.blocks_out() {
                view::keep_step(world);
            }
            let before = std::mem::replace(&mut world.resource_mut::<ViewSettings>().tool, tool);
            if before == Tool::Paths && tool == Tool::Select {
                world.resource_mut::<PathInspector>().wanted = None;
            }
        }
        Command::Display(DisplayCommand::ShowSafeFrame(shown)) => {
            world.resource_mut::<ViewSettings>().safe_frame = shown
        }
        Command::Display(DisplayCommand::ShowDimensions(shown)) => {
            world.resource_mut::<ViewSettings>().dimensions = shown
        }
        Command::Tool(ToolCommand::AddRuler(ruler)) => {
            let rulers = &mut world.resource_mut::<ViewSettings>().rulers;
            rulers.push(ruler);
            let dropped = rulers.len().saturating_sub(MOST_RULERS);
            rulers.drain(..dropped);
        }
        Command::Tool(ToolCommand::ClearRulers) => world.resource_mut::<ViewSettings>().rulers.clear(),
        Command::Display(DisplayCommand::SetGrid(grid)) => {
            world.resource_mut::<ViewSettings>().grid = grid.within_range()
        }
        Command::Tool(ToolCommand::InspectPaths(wanted)) => world.resource_mut::<PathInspector>().wanted = wanted,
        Command::Tool(ToolCommand::SetGizmo(gizmo)) => view::set_gizmo(world, gizmo),
        Command::Display(DisplayCommand::SetDenoising(denoising)) => {
            if denoising && !world.resource::<Denoiser>().is_available() {
                return Err("This program was built without the denoiser (cargo feature `denoise`).".into());
            }
            world.resource_mut::<ViewSettings>().denoising = denoising;
            if let Some(mut preferences) = world.get_resource_mut::<Preferences>() {
                preferences.denoising = denoising;
            }
        }
        Command::Shell(command) => shell::apply(world, command)?,
        // The others are edits.
        _ => {}
    }
    Ok(())
}

fn select(world: &mut World, entities: &[Entity], how: Extend) {
    world.resource_mut::<Selection>().extend(entities.iter().copied(), how);
    if !entities.is_empty() {
        world.resource_mut::<Requests>().wanted_panel = Some(Panel::Inspector);
    }
}

/// The selection and the camera in use are of the scene.
fn keep_what_is_there(world: &mut World) {
    let is_there = ObjectState::is_in_scene;
    let selection = world.resource::<Selection>().clone();
    if selection.entities().iter().any(|entity| !is_there(world, *entity)) {
        let mut kept = selection;
        kept.retain(|entity| is_there(world, *entity));
        world.insert_resource(kept);
    }
    seeing::keep_what_is_there(world, is_there);
    let active = world.resource::<ActiveSensor>().0;
    if active.is_none_or(|sensor| world.get::<Sensor>(sensor).is_none()) {
        let mut sensors = world.query_filtered::<(&DocumentOrder, Entity), With<Sensor>>();
        let first = sensors.iter(world).min().map(|(_, entity)| entity);
        if first != active {
            view::look_through_first(world, first);
        }
    }
}
