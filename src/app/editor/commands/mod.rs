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
use crate::app::editor::command::{Command, Effect};
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
    note_input(world, commands.iter().any(Command::restarts_picture));
    if commands.iter().any(Command::moves_picture)
        && let Some(mut motion) = world.get_resource_mut::<Motion>()
    {
        motion.note_change();
    }
    for command in commands {
        let saves = command.saves();
        let result = match (saving::begin(world, &command), command) {
            (Ok(false), Command::ExportScene(path)) => exporting::begin(world, path),
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
    let (later, now): (Vec<Command>, Vec<Command>) = commands.into_iter().partition(Command::keeps_picture);
    if !later.is_empty() {
        motion.stop();
        world.resource_mut::<CommandQueue>().0.extend(later);
    }
    now
}

/// Applies a command in this frame and returns its error. A question to the user is returned as an error as well.
pub(crate) fn apply_now(world: &mut World, command: Command) -> Result<(), CommandError> {
    note_input(world, command.restarts_picture());
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
pub fn apply(world: &mut World, command: Command) -> Result<(), CommandError> {
    flight::make_way(world, &command);
    saving::make_way(world, &command)?;
    let lesson = world
        .get_resource::<Tutorial>()
        .filter(|tutorial| tutorial.step.is_some())
        .map(|_| command.clone());
    let effect = command.effect();
    match effect {
        Effect::Edit | Effect::Drag => edit(world, command, effect == Effect::Drag)?,
        Effect::View | Effect::None => act(world, command)?,
    }
    keep_what_is_there(world);
    if let Some(command) = lesson {
        let is_saved = world.resource::<History>().is_saved();
        world.resource_mut::<Tutorial>().note(&command, is_saved);
    }
    Ok(())
}

fn edit(world: &mut World, command: Command, merges: bool) -> Result<(), CommandError> {
    let (label, targets) = (command.label(), command.targets());
    let title = Title::before(world, &command);
    let interaction = world.resource::<Requests>().interaction;
    let mut edit = Edit::begin(world);
    match apply_edit::apply(&mut edit, command).and_then(|()| edit.check_poses()) {
        Ok(()) => {
            media_upkeep::follow(&mut edit);
            edit.follow_keys();
            let title = title.after(edit.world);
            keep_what_is_there(edit.world);
            edit.finish(title, merges.then_some((interaction, (label, targets))));
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
        Command::NewScene => {
            baking::leave_scene(world);
            files::new_scene(world);
        }
        Command::OpenScene(path) => {
            baking::leave_scene(world);
            files::open_scene(world, path);
        }
        Command::ReloadScene => files::reload_scene(world)?,
        Command::RevertScene => {
            files::revert_scene(world)?;
            baking::leave_scene(world);
        }
        Command::Save => files::save(world)?,
        Command::SaveScene(path) => files::save_to(world, &path)?,
        Command::SaveChanged(path, on_change) => files::save_scene(world, &path, on_change)?,
        Command::ExportScene(path) => exporting::export_now(world, &path)?,
        Command::Bake(command) => baking::apply(world, command)?,
        Command::SaveImage(path) => full_film::save_image(world, path)?,
        Command::KeptPicture(command) => kept_picture::apply(world, command)?,
        Command::ShowDialog(kind) => world.resource_mut::<Requests>().dialog = Some(kind),
        Command::Quit => {
            world.write_message(AppExit::Success);
        }
        Command::Copy => files::copy(world)?,

        Command::Undo => history::undo(world)?,
        Command::Redo => history::redo(world)?,
        Command::GoTo(steps) => {
            while world.resource::<History>().len().0 > steps && history::undo(world).is_ok() {}
            while world.resource::<History>().len().0 < steps && history::redo(world).is_ok() {}
        }
        Command::SetTime(time) => timeline::set_time(world, time)?,
        Command::StepTime(step) => timeline::step(world, step)?,
        Command::SetPlaying(plays) => timeline::play(world, plays),
        Command::SetTimeline(timeline) => world.resource_mut::<ViewSettings>().timeline = timeline.within_range(),
        Command::ShowTimeline(shown) => world.resource_mut::<ViewSettings>().timeline_shown = Some(shown),

        Command::Select(entities, how) => select(world, &entities, how),
        Command::SelectAll => {
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
        Command::Pick(film, how) => {
            let found = picking::pick(world.resource::<PackedScene>(), film);
            let found = found.filter(|entity| world.get::<Locked>(*entity).is_none());
            match (found, how) {
                (None, Extend::Add | Extend::Toggle) => {}
                (found, how) => select(world, found.as_slice(), how),
            }
        }
        Command::SelectGroup => grouping::select_group(world)?,
        Command::FrameSelection => view::frame_selection(world)?,
        Command::FrameAll => view::frame_all(world)?,
        Command::MoveView(pose) => view::move_view(world, pose),
        Command::SwitchProjection => projection::switch(world)?,
        Command::LookThrough(entity) => view::look_through(world, entity),
        Command::TurnAbout(point) => world.resource_mut::<ViewSettings>().navigation.pivot = Some(point),
        Command::LookAlong(axis) => view::look_along(world, axis),
        Command::StoreView(number) => view::store(world, number),
        Command::RecallView(number) => view::recall(world, number)?,
        Command::SetSpeed(speed) => world.resource_mut::<ViewSettings>().navigation.set_speed(speed),

        Command::SetPaused(paused) => control(world, |control| control.paused = paused),
        Command::Restart => control(world, |control| control.restart_requested = true),
        Command::SetTargetSamples(samples) => control(world, |control| control.target_samples = Some(samples.max(1))),
        Command::SetTimeLimit(limit) => control(world, |control| control.time_limit = limit),
        Command::SetNoiseTarget(target) => {
            // Zero is no limit, also where the file has one.
            control(world, |control| control.noise_target = Some(target.unwrap_or(0.0)));
        }
        Command::SetAdaptive(is_on) => control(world, |control| control.adaptive = Some(is_on)),
        Command::SetRegion(region) => {
            let region = region.map(|region| Rect::from_corners(region.min, region.max));
            control(world, |control| control.region = region);
        }
        Command::SetPathIsAuto(is_auto) => control(world, |control| control.path_is_auto = is_auto),
        Command::SetStrategySplit(split) => control(world, |control| control.strategy_split = split),
        Command::SetLightLayers(kept) => {
            control(world, |control| control.light_layers = kept);
            let display = world.resource::<ViewSettings>().display;
            if !kept && matches!(display.mode, DisplayMode::LightGroup(_)) {
                let mode = DisplayMode::Shaded;
                view::set_display(world, DisplaySettings { mode, ..display });
            }
        }
        Command::SetLightMix(mix) => {
            let mix = world.get_resource_or_init::<LightMix>().with_channels(mix);
            set_resource(world, mix);
        }
        Command::ExposeAutomatically => finished::expose(world)?,
        Command::TakeSnapshot => finished::take_snapshot(world)?,
        Command::SetCompareView(view) => {
            baking::check_view(world, view)?;
            world.resource_mut::<Comparison>().view = view;
        }
        Command::Measure => finished::measure(world)?,
        Command::SetResolutionScale(scale) => {
            control(world, |control| control.resolution_scale = scale.clamp(0.05, 1.0));
        }
        Command::SetResolution(resolution) => full_film::set_resolution(world, resolution),
        Command::SetEnlarging(enlarging) => world.resource_mut::<ViewSettings>().enlarging = enlarging,
        Command::RenderFull(request) => full_film::render(world, request)?,
        Command::StopFull => full_film::stop(world),
        Command::SetDisplay(display) => view::set_display(world, display),
        Command::SetOverlay(overlay) => world.resource_mut::<ViewSettings>().overlay = overlay,
        Command::SetSeeing(seen) => seeing::set(world, seen),
        Command::CutOpen => seeing::cut_open(world)?,
        Command::Isolate(entities) => seeing::isolate(world, entities)?,
        Command::SetTool(tool) => {
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
        Command::ShowSafeFrame(shown) => world.resource_mut::<ViewSettings>().safe_frame = shown,
        Command::ShowDimensions(shown) => world.resource_mut::<ViewSettings>().dimensions = shown,
        Command::AddRuler(ruler) => {
            let rulers = &mut world.resource_mut::<ViewSettings>().rulers;
            rulers.push(ruler);
            let dropped = rulers.len().saturating_sub(MOST_RULERS);
            rulers.drain(..dropped);
        }
        Command::ClearRulers => world.resource_mut::<ViewSettings>().rulers.clear(),
        Command::SetGrid(grid) => world.resource_mut::<ViewSettings>().grid = grid.within_range(),
        Command::InspectPaths(wanted) => world.resource_mut::<PathInspector>().wanted = wanted,
        Command::SetGizmo(gizmo) => view::set_gizmo(world, gizmo),
        Command::SetDenoising(denoising) => {
            if denoising && !world.resource::<Denoiser>().is_available() {
                return Err("This program was built without the denoiser (cargo feature `denoise`).".into());
            }
            world.resource_mut::<ViewSettings>().denoising = denoising;
            if let Some(mut preferences) = world.get_resource_mut::<Preferences>() {
                preferences.denoising = denoising;
            }
        }
        Command::ShowPanels(shown) => world.resource_mut::<ViewSettings>().panels_shown = shown,
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
