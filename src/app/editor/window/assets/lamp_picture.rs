//! The picture of a file with the intensities of a lamp: its polar curve, as if the lamp hung from the ceiling.

use std::path::Path;

use bevy::math::Vec2;
use bevy_egui::egui::{Color32, ColorImage};

use super::file_picture::{Content, EDGE};
use crate::files::Access;
use crate::memory::read_data;
use crate::photometry::{PolarCurve, read_profile};

/// The colours of the inside of the curve and of the rest.
const LIGHT: Color32 = Color32::from_rgb(255, 214, 120);
const DARK: Color32 = Color32::from_rgb(40, 40, 46);

/// The share of the picture's half that the curve reaches.
const REACH: f32 = 0.9;

/// Reads an IES or EULUMDAT file.
pub(super) fn lamp(path: &Path, access: &Access) -> Result<Content, String> {
    let bytes = read_data(path, access).map_err(|error| error.to_string())?;
    let distribution = read_profile(&bytes).map_err(|error| error.to_string())?;
    let curve = PolarCurve::new(&distribution, 0.0);
    let color = |index: u32| {
        let pixel = Vec2::new((index % EDGE) as f32, (index / EDGE) as f32) + 0.5;
        let place = (2.0 / EDGE as f32 * pixel - 1.0) / REACH;
        if curve.contains(place) { LIGHT } else { DARK }
    };
    let pixels = (0..EDGE * EDGE).map(color).collect();
    Ok(Content {
        image: Some(ColorImage::new([EDGE as usize; 2], pixels)),
        note: format!("{:.0} lm, at most {:.0} cd", curve.lumens, curve.peak),
        ..Content::default()
    })
}
