//! Cameras and what they record on.

use bevy_egui::egui::Ui;

use super::fields;
use crate::scene::{Film, FovAxis, Lens, ReconstructionFilter, Sensor};

/// Any larger and a single film would fill the memory of a small machine.
const LARGEST_EDGE: u32 = 8192;

/// True if edited.
pub fn sensor(ui: &mut Ui, sensor: &mut Sensor, scene_size: f32) -> bool {
    let mut changed = fields::slider_with(ui, "Field of view", &mut sensor.fov, 1.0..=170.0, |slider| {
        slider.suffix("°")
    });
    let axes = [
        (FovAxis::X, "horizontal"),
        (FovAxis::Y, "vertical"),
        (FovAxis::Diagonal, "diagonal"),
        (FovAxis::Smaller, "smaller edge"),
        (FovAxis::Larger, "larger edge"),
    ];
    changed |= fields::choice(ui, "Measured", &mut sensor.fov_axis, &axes);
    let mut is_thin = matches!(sensor.lens, Lens::Thin { .. });
    if fields::checkbox(ui, "Thin lens", &mut is_thin) {
        sensor.lens = if is_thin {
            Lens::Thin {
                aperture_radius: 0.005 * scene_size,
                focus_distance: 0.5 * scene_size,
            }
        } else {
            Lens::Pinhole
        };
        changed = true;
    }
    if let Lens::Thin {
        aperture_radius,
        focus_distance,
    } = &mut sensor.lens
    {
        let size = scene_size.max(1e-3);
        changed |= fields::log_slider(ui, "Aperture", aperture_radius, 1e-5 * size..=0.2 * size);
        changed |= fields::log_slider(ui, "Focus at", focus_distance, 1e-3 * size..=10.0 * size);
    }
    changed |= fields::number(ui, "Near clip", &mut sensor.near_clip, 0.001, 1e-6..=sensor.far_clip);
    let nearest = sensor.near_clip;
    fields::number(ui, "Far clip", &mut sensor.far_clip, 1.0, nearest..=f32::MAX) || changed
}

/// True if edited.
pub fn film(ui: &mut Ui, film: &mut Film) -> bool {
    let mut changed = fields::integer(ui, "Width", &mut film.width, 16..=LARGEST_EDGE);
    changed |= fields::integer(ui, "Height", &mut film.height, 16..=LARGEST_EDGE);
    let mut is_box = film.filter == ReconstructionFilter::Box;
    if fields::choice(ui, "Filter", &mut is_box, &[(true, "box"), (false, "gaussian")]) {
        film.filter = if is_box {
            ReconstructionFilter::Box
        } else {
            ReconstructionFilter::default()
        };
        changed = true;
    }
    if let ReconstructionFilter::Gaussian { stddev } = &mut film.filter {
        changed |= fields::slider(ui, "Width of it", stddev, 0.1..=2.0);
    }
    fields::integer(ui, "Samples", &mut film.sample_count, 1..=1 << 20) || changed
}
