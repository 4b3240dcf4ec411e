//! Bakes the scene on a thread of its own while the user continues to edit. The bake is of the scene at its begin;
//! another scene may be opened meanwhile.

use std::path::Path;
use std::sync::Arc;

use bevy::prelude::*;

use super::exporting::{described, with_list};
use crate::app::editor::command::baking::{BakeCommand, BakePlan};
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::shell::Sheet;
use crate::app::editor::picture::baking::shown::Wanted;
use crate::app::editor::picture::baking::thread::{BakeOrder, BakeThread, wait_at_exit};
use crate::app::editor::picture::baking::{Baking, Work};
use crate::app::editor::picture::compare::{Comparison, LitPicture, Look};
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::words::figures::counted;
use crate::bake::files::OutputFolder;
use crate::engine::{PackedScene, RenderControl, RenderStatus, WakeUp, fit};
use crate::render::view::{Integrator, Shown, View};
use crate::render::visibility::outer_walls::OuterWalls;
use crate::render::visibility::sight::Sight;
use crate::scene::{ActiveSensor, InMedium};

/// Starts, stops or shows the bake, as the command says.
pub(super) fn apply(world: &mut World, command: BakeCommand) -> Result<(), CommandError> {
    let baking = world.get_resource_or_init::<Baking>();
    match command {
        BakeCommand::Choose(choices) => world.get_resource_or_init::<BakePlan>().choices = choices,
        BakeCommand::ChooseFolder(folder) => world.get_resource_or_init::<BakePlan>().folder = Some(folder),
        BakeCommand::Begin(folder) => begin(world, &folder)?,
        BakeCommand::Stop => match &baking.work {
            Work::UnderWay(thread) => thread.stop(),
            Work::Waiting(_) => close(world),
            Work::None | Work::Ended(_) => return Err(NOTHING.into()),
        },
        BakeCommand::Discard if baking.is_busy() => close(world),
        BakeCommand::Discard => return Err(NOTHING.into()),
        BakeCommand::ShowPage(page) => {
            if let Some(thread) = baking.thread() {
                let wanted = thread.wanted();
                thread.show(Wanted { page, ..wanted });
            }
        }
        BakeCommand::Close => {
            if !baking.is_busy() {
                close(world);
            }
        }
    }
    Ok(())
}

/// The largest picture of the level, in pixels.
const LARGEST_LOOK: UVec2 = UVec2::new(1280, 1280);
const NOTHING: &str = "No bake is under way.";

/// Stops the bake, or closes the view of its result.
fn close(world: &mut World) {
    world.resource_mut::<Baking>().discard();
    if let Some(mut comparison) = world.get_resource_mut::<Comparison>() {
        show_lit(&mut comparison, None);
        if matches!(comparison.view, CompareView::Baked(_)) {
            comparison.view = CompareView::Off;
        }
    }
}

fn begin(world: &mut World, folder: &Path) -> Result<(), CommandError> {
    let mut baking = world.get_resource_or_init::<Baking>();
    if baking.is_busy() {
        return Err("A bake is still under way.".into());
    }
    baking.is_of_open_scene = true;
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let prepared = OutputFolder::prepare(&folder).map_err(|error| {
        baking.failure = Some(error.to_string());
        CommandError::file(error)
    })?;
    // The last one is closed. The level by its lightmaps will be seen of the new one.
    baking.discard();
    baking.failure = None;
    baking.work = Work::Waiting(prepared);
    world.get_resource_or_init::<BakePlan>().folder = Some(folder);
    if let Some(mut comparison) = world.get_resource_mut::<Comparison>() {
        show_lit(&mut comparison, None);
    }
    let mut requests = world.resource_mut::<Requests>();
    // The form would cover the result.
    requests.sheet = requests.sheet.filter(|sheet| *sheet != Sheet::Bake);
    Ok(())
}

/// Refuses to show the lightmaps of another scene beside the picture of this one.
pub(super) fn check_view(world: &World, view: CompareView) -> Result<(), CommandError> {
    let is_of_other = |baking: &Baking| baking.thread().is_some() && !baking.is_of_open_scene;
    if matches!(view, CompareView::Baked(_)) && world.get_resource::<Baking>().is_some_and(is_of_other) {
        return Err("The bake is of the scene that was open when it began.".into());
    }
    Ok(())
}

/// Continues the bake, in every frame after the engine has packed the scene.
pub fn follow(world: &mut World) {
    let Some(mut baking) = world.get_resource_mut::<Baking>() else {
        return;
    };
    baking.ending.retain(|thread| !thread.is_finished());
    match &baking.work {
        // A bake that was given up may be about to remove the folder.
        Work::Waiting(_) if baking.ending.is_empty() => {
            start(world);
            look(world);
        }
        Work::UnderWay(_) | Work::Ended(_) => look(world),
        Work::None | Work::Waiting(_) => {}
    }
    tell_end(world);
}

/// Selects the lightmaps that the bake shows, and hands it the picture of the level.
fn look(world: &mut World) {
    let display = world.resource::<ViewSettings>().display.tone();
    let is_compared = |comparison: &Comparison| matches!(comparison.view, CompareView::Baked(_));
    let is_seen = world.get_resource::<Comparison>().is_some_and(is_compared);
    let view = world.resource::<PackedScene>().view.as_ref().filter(|_| is_seen);
    let look = view.map(|view| Look {
        camera: view.camera,
        film_camera: view.of_film(),
        film_corners: view.film_corners(),
        size: match UVec2::new(view.width, view.height) {
            size if size.cmple(LARGEST_LOOK).all() => size.to_array(),
            size => fit(size, LARGEST_LOOK).to_array(),
        },
        sight: Sight {
            // These are of the scene that is open now. The bake finds the walls of its own.
            only: None,
            outer_walls: OuterWalls::default(),
            ..view.sight.clone()
        },
        hides_emitters: view.integrator.settings().hide_emitters,
    });
    let Some(thread) = world.resource::<Baking>().thread() else {
        return;
    };
    let page = thread.wanted().page;
    thread.show(Wanted { page, display, look });
    let lit = thread.lit();
    if let Some(mut comparison) = world.get_resource_mut::<Comparison>() {
        show_lit(&mut comparison, lit);
    }
}

fn show_lit(comparison: &mut Mut<Comparison>, lit: Option<Arc<LitPicture>>) {
    if comparison.baked.as_ref().map(Arc::as_ptr) != lit.as_ref().map(Arc::as_ptr) {
        comparison.baked = lit;
        comparison.revision += 1;
    }
}

/// Starts the waiting bake once the packed scene is the scene that the user sees.
fn start(world: &mut World) {
    if !world.resource::<RenderStatus>().is_up_to_date {
        return;
    }
    let work = std::mem::take(&mut world.resource_mut::<Baking>().work);
    let Work::Waiting(folder) = work else { return };
    match order(world, folder).and_then(|(order, folder)| {
        let display = world.resource::<ViewSettings>().display.tone();
        let wanted = Wanted {
            display,
            ..Wanted::default()
        };
        BakeThread::begin(order, folder, wanted).map_err(CommandError::file)
    }) {
        Ok(thread) => world.resource_mut::<Baking>().work = Work::UnderWay(thread),
        Err(error) => fail(world, error.to_string()),
    }
}

fn order(world: &mut World, folder: OutputFolder) -> Result<(BakeOrder, OutputFolder), CommandError> {
    // Another bake may have removed it.
    let path = folder.path().to_owned();
    drop(folder);
    let folder = OutputFolder::prepare(&path).map_err(CommandError::file)?;
    let (level, hidden, access) = described(world)?;
    if let Some(shortage) = world.resource::<RenderStatus>().shortages.first() {
        return Err(format!("The scene is not complete, and is not baked: {shortage}").into());
    }
    let choices = world.get_resource_or_init::<BakePlan>().choices;
    let packed = world.resource::<PackedScene>();
    let (Some(scene), Some(view)) = (&packed.scene, &packed.view) else {
        return Err("There is nothing to bake: the scene has no camera.".into());
    };
    let sensor = world.resource::<ActiveSensor>().0;
    let medium = sensor.and_then(|sensor| world.get::<InMedium>(sensor));
    let medium = medium.and_then(|medium| packed.medium_of_entity.get(&medium.0).copied());
    let order = BakeOrder {
        scene: scene.clone(),
        view: View {
            medium,
            // Display modes and filters of the window do not apply to the bake.
            integrator: Integrator::Path(view.integrator.settings()),
            shown: Shown::Radiance,
            sight: Sight::default(),
            ..view.clone()
        },
        level,
        hidden,
        access,
        settings: choices.settings(),
        limits: choices.limits(),
        folder: path,
        threads: world.resource::<RenderControl>().threads,
        wake_up: world.get_resource::<WakeUp>().cloned().unwrap_or_default(),
    };
    Ok((order, folder))
}

/// Discards a bake that waits for a scene, since another one takes its place. A running bake goes on, and its end does
/// not concern the new scene.
pub(super) fn leave_scene(world: &mut World) {
    let waits = |baking: &Baking| matches!(baking.work, Work::Waiting(_));
    if world.get_resource::<Baking>().is_some_and(waits) {
        fail(
            world,
            "Nothing is baked: another scene was opened before the bake began.".to_owned(),
        );
    }
    if let Some(mut baking) = world.get_resource_mut::<Baking>() {
        baking.is_of_open_scene = false;
    }
}

/// Closes the view of the bake, and shows the reason of its failure.
fn fail(world: &mut World, reason: String) {
    close(world);
    let mut toasts = world.resource_mut::<Toasts>();
    toasts.error(Topic::Other, reason.clone(), None);
    world.resource_mut::<Baking>().failure = Some(reason);
}

/// Reports the end of the bake by a toast, once.
fn tell_end(world: &mut World) {
    let mut baking = world.resource_mut::<Baking>();
    let Some(ended) = (match &baking.work {
        Work::UnderWay(thread) => thread.ended(),
        Work::None | Work::Waiting(_) | Work::Ended(_) => None,
    }) else {
        return;
    };
    let Work::UnderWay(thread) = std::mem::take(&mut baking.work) else {
        return;
    };
    let (news, folder) = (thread.news(), thread.folder().to_owned());
    baking.work = Work::Ended(thread);
    let written = match ended {
        Ok(written) => written,
        Err(reason) => return fail(world, format!("The scene is not baked: {reason}")),
    };
    let place = folder.display();
    let done = match written.is_stopped {
        true => format!(
            "The bake was stopped: the lightmaps in {place} have {} per texel, and probes that were not finished are left out",
            counted(written.samples.into(), "sample")
        ),
        false => format!("The level with its lightmaps is in {place}"),
    };
    let mut toasts = world.resource_mut::<Toasts>();
    match news.warnings.is_empty() {
        true => toasts.info(format!("{done}.")),
        false => {
            for message in news.warnings.iter() {
                warn!("{place}: {message}");
            }
            toasts.report(with_list(
                &format!("{done}. Not all is as it was asked for:"),
                &news.warnings,
            ));
        }
    }
}

/// Stops the running bake before the program ends. Its folder is then unchanged or complete.
pub fn end_at_exit(world: &mut World) {
    let Some(mut baking) = world.get_resource_mut::<Baking>() else {
        return;
    };
    baking.discard();
    wait_at_exit(std::mem::take(&mut baking.ending));
}
