//! The light of the pixel under the pointer, for the status line.

use bevy::math::Vec2;

use crate::app::editor::command::display::DisplayMode;
use crate::app::editor::picture::depths::Depths;
use crate::engine::RenderFilm;
use crate::photometry::LUMENS_PER_WATT;
use crate::photometry::units::{Lux, Nit};

/// The luminance, or the illuminance, at a place of the picture with its standard error; None in modes that show
/// neither.
pub(super) fn pointed_light(place: Option<Vec2>, mode: DisplayMode, film: &RenderFilm) -> Option<String> {
    let (radiance, error) = Depths::rendered(film)
        .luminance_at(place?)
        .filter(|_| !film.is_coarse)?;
    let error = error.map_or(f64::NAN, f64::from) * f64::from(LUMENS_PER_WATT);
    match mode {
        DisplayMode::Illuminance => Some(Lux::of_watts(radiance.into()).with_error(error)),
        mode if mode.with_own_film().is_none() => Some(Nit::of_watts(radiance.into()).with_error(error)),
        _ => None,
    }
}
