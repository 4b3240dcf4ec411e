//! Traces the full film on demand and before the picture is saved, where usually only the pixels of the window are
//! traced.
//!
//! A saved picture always has the pixels of the film, and as many samples as the picture on the screen had at the
//! command. A change of the scene or the view in between restarts the picture: then nothing is saved, and the user gets
//! a message.

use std::path::PathBuf;

use bevy::prelude::*;

use super::finished;
use super::world::control;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::resolution::{FullFilm, Resolution};
use crate::app::editor::picture::awaited_image::{AwaitedImage, Before, EndedImage, ImageNotSaved};
use crate::app::editor::picture::resolution::{full_film_bytes, is_large};
use crate::app::editor::session::full_film_question::FullFilmQuestion;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::{Toasts, Topic};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::{RenderControl, RenderFilm, RenderState, RenderStatus};
use crate::memory;

pub fn set_resolution(world: &mut World, resolution: Resolution) {
    world.resource_mut::<ViewSettings>().resolution = resolution;
    // The demand of an image that is waited for stays as it is, because it notices changes of the scene.
    if resolution != Resolution::Full || !world.contains_resource::<AwaitedImage>() {
        control(world, RenderControl::forget_size_until_change);
    }
}

/// Whether the picture is not the full film: it has other pixels, or shows the surroundings of the film as well.
pub fn is_smaller(world: &World) -> bool {
    let status = world.resource::<RenderStatus>();
    let film = &world.resource::<RenderFilm>().film;
    let full = status.full_size;
    full != UVec2::ZERO
        && (status.is_beyond_film || status.size != full || UVec2::new(film.width(), film.height()) != full)
}

/// Saves the picture, after tracing the full film if it has fewer pixels, and after denoising it if that is on.
pub fn save_image(world: &mut World, path: PathBuf) -> Result<(), CommandError> {
    super::files::check_scene_stays(world, &path)?;
    let is_idle = world.resource::<RenderStatus>().state == RenderState::Idle;
    if is_idle || !is_smaller(world) && !finished::owes_denoised(world) {
        return super::files::save_image(world, &path);
    }
    render(
        world,
        FullFilm {
            save_to: Some(path),
            is_confirmed: false,
        },
    )
}

/// Begins to trace the full film, or asks first if that takes much memory.
pub fn render(world: &mut World, request: FullFilm) -> Result<(), CommandError> {
    let status = world.resource::<RenderStatus>();
    let (full, samples) = (status.full_size, status.samples.max(1));
    if status.state == RenderState::Idle {
        return Err("There is no picture to render.".into());
    }
    if request.save_to.is_some()
        && let Some(image) = world.get_resource::<AwaitedImage>()
    {
        let file = image.file_name();
        return Err(format!("The full film is still rendered for {file}: save the next image after it.").into());
    }
    if world.resource::<RenderControl>().paused && is_smaller(world) {
        return Err("Rendering is paused: the full film needs it to go on.".into());
    }
    if is_smaller(world) {
        let bytes = full_film_bytes(full, world.resource::<RenderFilm>().film.layers());
        // The reservation is tried, and given back at once.
        memory::reserve(bytes)
            .map_err(|shortage| format!("A film of {} × {} pixels needs {shortage}.", full.x, full.y))?;
        if is_large(bytes) && !request.is_confirmed {
            world.resource_mut::<Requests>().full_film_question = Some(FullFilmQuestion {
                request,
                size: full,
                bytes,
                budget: memory::budget().limit(),
            });
            return Ok(());
        }
    }
    if let Some(path) = request.save_to {
        let is_smaller = is_smaller(world);
        let demands = world.resource::<RenderControl>();
        let before = match is_smaller {
            true => Before::Smaller {
                exact_samples: demands.exact_samples,
            },
            false => Before::Whole { paused: demands.paused },
        };
        let image = AwaitedImage {
            path,
            samples,
            is_denoised: finished::is_denoising(world),
            before,
        };
        // A number of samples that some pixels have exceeded already could only be reached by a new picture.
        control(world, |control| match is_smaller {
            true => control.exact_samples = Some(samples),
            false => control.paused = true,
        });
        world.insert_resource(image);
    }
    control(world, RenderControl::demand_full_until_change);
    Ok(())
}

/// Answers the question about memory with yes, for callers that cannot be asked.
pub fn confirm(world: &mut World) -> Result<(), CommandError> {
    match world.resource_mut::<Requests>().full_film_question.take() {
        Some(question) => render(world, question.confirmed()),
        None => Ok(()),
    }
}

/// Cancels the awaited image. The full film that was begun for it stays with its samples, unless it has none or is so
/// large that the user was asked about it. Without such an image it goes back to the pixels of the window.
pub fn stop(world: &mut World) {
    let Some(file) = world.get_resource::<AwaitedImage>().map(AwaitedImage::file_name) else {
        return control(world, RenderControl::forget_size_until_change);
    };
    let status = world.resource::<RenderStatus>();
    let layers = world.resource::<RenderFilm>().film.layers();
    let has_samples = status.samples > 0 && !is_smaller(world);
    if !has_samples || is_large(full_film_bytes(status.full_size, layers)) {
        control(world, RenderControl::forget_size_until_change);
    }
    let error = ImageNotSaved::Cancelled { file };
    world.resource_mut::<Toasts>().info(error.to_string());
    end(world, Err(error));
}

/// Ends the wait for an image with this result.
fn end(world: &mut World, outcome: Result<(), ImageNotSaved>) {
    if let Some(image) = world.remove_resource::<AwaitedImage>() {
        control(world, |control| match image.before {
            Before::Smaller { exact_samples } => control.exact_samples = exact_samples,
            Before::Whole { paused } => control.paused = paused,
        });
        world.insert_resource(EndedImage(outcome));
    }
}

/// Saves the awaited image once the full film has its samples.
pub fn follow_awaited_image(world: &mut World) {
    let Some(image) = world.get_resource::<AwaitedImage>().cloned() else {
        return;
    };
    let status = world.resource::<RenderStatus>();
    let file = image.file_name();
    if status.state == RenderState::Failed {
        let reason = status.errors.first().cloned().unwrap_or_default();
        control(world, |control| control.full_until_change = false);
        let error = ImageNotSaved::Failed { file, reason };
        world
            .resource_mut::<Toasts>()
            .error(Topic::Saving, error.to_string(), None);
        return end(world, Err(error));
    }
    // The engine takes the demand back when the scene or the view changes, whether the setting asks for the full film
    // as well or not.
    if !world.resource::<RenderControl>().full_until_change {
        let error = ImageNotSaved::Changed { file };
        world.resource_mut::<Toasts>().reject(error.to_string());
        return end(world, Err(error));
    }
    let is_complete = status.rests() && status.samples >= image.samples && !is_smaller(world);
    if !is_complete || (image.is_denoised && finished::owes_denoised(world)) {
        return;
    }
    let outcome = super::files::save_image(world, &image.path);
    let outcome = outcome.map_err(|error| ImageNotSaved::NotWritten(error.to_string()));
    if let Err(error) = &outcome {
        let message = error.to_string();
        world.resource_mut::<Toasts>().error(Topic::Saving, message, None);
    }
    end(world, outcome);
}
