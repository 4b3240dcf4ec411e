//! The limits of the window, written into the scene.

use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::Edit;
use crate::engine::RenderControl;
use crate::scene::{ActiveSensor, Film};

/// Writes samples, limit of noise and adaptive sampling into the film of the camera. The limits of the window stay as
/// they are: they are the same then, and still count if this is undone.
pub fn keep(edit: &mut Edit) -> Result<(), CommandError> {
    let sensor = edit.world.resource::<ActiveSensor>().0;
    let film = sensor.and_then(|sensor| Some((sensor, *edit.world.get::<Film>(sensor)?)));
    let (sensor, film) = film.ok_or("There is no camera.")?;
    let control = edit.world.resource::<RenderControl>();
    let kept = Film {
        sample_count: control.target_samples.unwrap_or(film.sample_count),
        // Zero is no limit, also where the film has one.
        noise_target: control
            .noise_target
            .map_or(film.noise_target, |noise| Some(noise).filter(|noise| *noise > 0.0)),
        adaptive: control.adaptive.unwrap_or(film.adaptive),
        ..film
    };
    if kept == film {
        return Err("The camera has these limits already.".into());
    }
    edit.set(sensor, kept);
    Ok(())
}
