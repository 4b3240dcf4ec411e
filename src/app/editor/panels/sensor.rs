//! Shows the parameters of cameras and of their films.

use bevy::math::UVec2;
use bevy_egui::egui::emath::format_with_decimals_in_range;
use bevy_egui::egui::{self, Ui};

use super::caption::Caption;
use super::key_marks::owner;
use super::{fields, lengths, typed};
use crate::app::editor::input::number_field::{self, Meaning};
use crate::app::editor::picture::resolution::{full_film_bytes, is_large};
use crate::files::ExrCompression;
use crate::memory::Bytes;
use crate::render::layers::FilmLayers;
use crate::scene::parameters::{FOV, FOV_AXIS};
use crate::scene::{ComponentFormat, Film, FovAxis, LengthUnit, Lens, ReconstructionFilter, Sensor, aperture};

/// The largest edge: a larger film alone would fill the memory of a small machine.
const LARGEST_EDGE: u32 = 8192;

/// The precision of the colours in EXR files.
const PRECISIONS: [(Option<ComponentFormat>, &str); 3] = [
    (None, "automatic (32 bits)"),
    (Some(ComponentFormat::Float32), "floats of 32 bits"),
    (Some(ComponentFormat::Float16), "halves of 16 bits"),
];

/// Shows the rows of a camera; returns true if edited. `aspect` is the film's width over its height.
pub fn sensor(ui: &mut Ui, sensor: &mut Sensor, aspect: f32, scene_size: f32) -> bool {
    let focal_length = aperture::focal_length(sensor, aspect);
    let mut changed = lens(ui, &mut sensor.lens, focal_length, scene_size);
    if sensor.lens != Lens::Orthographic {
        changed |= field_of_view(ui, &mut sensor.fov, &mut sensor.fov_axis);
        changed |= focal_length_row(ui, sensor, aspect);
    }
    changed |= lengths::length(
        ui,
        ("Near clip", "near_clip"),
        &mut sensor.near_clip,
        0.001,
        1e-6..=sensor.far_clip,
    );
    let nearest = sensor.near_clip;
    changed |= lengths::length(
        ui,
        ("Far clip", "far_clip"),
        &mut sensor.far_clip,
        1.0,
        nearest..=f32::MAX,
    );
    let offset = &mut sensor.principal_point_offset;
    changed |= fields::number(
        ui,
        ("Shift right", "principal_point_offset.x"),
        &mut offset.x,
        0.001,
        -10.0..=10.0,
    );
    fields::number(
        ui,
        ("Shift down", "principal_point_offset.y"),
        &mut offset.y,
        0.001,
        -10.0..=10.0,
    ) || changed
}

/// Shows the rows of a field of view; returns true if edited.
pub(crate) fn field_of_view(ui: &mut Ui, fov: &mut f32, axis: &mut FovAxis) -> bool {
    let changed = fields::angle_slider(ui, &FOV, fov, FOV.slider_range());
    fields::choice(ui, &FOV_AXIS, axis, &FovAxis::LABELED) || changed
}

/// Shows the focal length, which stands for the field of view; returns true if edited.
fn focal_length_row(ui: &mut Ui, sensor: &mut Sensor, aspect: f32) -> bool {
    let mut millimetres = 1e3 * aperture::focal_length(sensor, aspect);
    let response = fields::row(ui, ("Focal length", "fov"), |ui| {
        let drag = egui::DragValue::new(&mut millimetres)
            .suffix(" mm")
            .clamp_existing_to_range(false)
            .speed(0.1)
            .max_decimals(1);
        let meaning = Meaning::Length(LengthUnit::Millimetre);
        let field = number_field::number(
            ui,
            drag,
            (owner(ui), "focal length"),
            1.0..=2500.0,
            meaning,
            format_with_decimals_in_range,
        );
        fields::wide_number(ui, field)
            .on_hover_text("Of a lens that sees as much on 35 mm film, by its diagonal; 50 mm is a normal lens")
    });
    let changed = response.changed() && millimetres > 0.0;
    if changed {
        sensor.fov = aperture::field_of_view(1e-3 * millimetres, sensor.fov_axis, aspect);
    }
    changed
}

fn lens(ui: &mut Ui, lens: &mut Lens, focal_length: f32, scene_size: f32) -> bool {
    let thin = Lens::Thin {
        aperture_radius: 0.005 * scene_size,
        focus_distance: 0.5 * scene_size,
        blades: 0,
        blade_rotation: 0.0,
    };
    let same_kind = |one: &Lens, other: &Lens| std::mem::discriminant(one) == std::mem::discriminant(other);
    let kinds = [
        (Lens::Pinhole, "pinhole"),
        (thin, "thin lens"),
        (Lens::Orthographic, "orthographic"),
    ];
    let kinds = kinds.map(|(kind, name)| (if same_kind(&kind, lens) { *lens } else { kind }, name));
    let mut changed = fields::choice(ui, ("Lens", "lens"), lens, &kinds);
    if let Lens::Thin {
        aperture_radius,
        focus_distance,
        blades,
        blade_rotation,
    } = lens
    {
        let size = scene_size.max(1e-3);
        changed |= lengths::length_slider(
            ui,
            ("Aperture", "aperture_radius"),
            aperture_radius,
            1e-5 * size..=0.2 * size,
        );
        changed |= f_stop(ui, aperture_radius, focal_length);
        changed |= lengths::length_slider(
            ui,
            ("Focus at", "focus_distance"),
            focus_distance,
            1e-3 * size..=10.0 * size,
        );
        changed |= fields::integer(ui, ("Blades", "blades"), blades, 0..=32);
        if *blades >= 3 {
            let caption = Caption::from(("Blade angle", "blade_rotation"))
                .explained("How far the polygon of the aperture is turned");
            changed |= fields::angle_slider(ui, caption, blade_rotation, 0.0..=360.0);
        }
    }
    changed
}

/// Shows the aperture radius as an f-number; returns true if edited.
fn f_stop(ui: &mut Ui, radius: &mut f32, focal_length: f32) -> bool {
    let mut number = aperture::f_number(radius.max(f32::MIN_POSITIVE), focal_length);
    let about = format!(
        "The aperture's f-number: focal length over diameter. Taken for a lens of {:.1} mm, which sees as much on 35 mm film (by its diagonal), \
         with a unit of the world for a metre. Larger numbers are sharper",
        1e3 * focal_length
    );
    let speed = 0.01 * number.clamp(1e-6, 1e9);
    let response = fields::row(ui, ("f-stop", "aperture_radius"), |ui| {
        let drag = egui::DragValue::new(&mut number)
            .prefix("f/")
            .clamp_existing_to_range(false)
            .speed(speed);
        let field = typed::number(ui, drag, "f-stop", 1e-6..=1e9, |number, _| match number {
            ..10.0 => format!("{}", (100.0 * number).round() / 100.0),
            number => format!("{}", number.round()),
        });
        fields::wide_number(ui, field).on_hover_text(about)
    });
    let changed = response.changed() && number > 0.0;
    if changed {
        *radius = aperture::aperture_radius(number, focal_length);
    }
    changed
}

/// Shows the rows of a film; returns true if edited.
pub fn film(ui: &mut Ui, film: &mut Film) -> bool {
    let mut changed = fields::integer(ui, ("Width", "width"), &mut film.width, 16..=LARGEST_EDGE);
    changed |= fields::integer(ui, ("Height", "height"), &mut film.height, 16..=LARGEST_EDGE);
    changed |= crop(ui, film);
    memory(ui, film);
    changed |= filter(ui, &mut film.filter);
    changed |= fields::integer(ui, ("Samples", "sample_count"), &mut film.sample_count, 1..=1 << 20);
    changed |= fields::checkbox(ui, ("Adaptive", "adaptive"), &mut film.adaptive);
    changed |= fields::choice(
        ui,
        ("EXR colours", "component_format"),
        &mut film.storage.components,
        &PRECISIONS,
    );
    let mut compressions = vec![(None, "automatic (zip)")];
    compressions.extend(ExrCompression::LABELED.map(|(method, label)| (Some(method), label)));
    let caption = Caption::from(("Compression", "compression"));
    changed |= fields::choice(
        ui,
        caption.explained(
            "How EXR files are made smaller. The methods with loss change values a little. pxr24, dwaa and dwab cannot save cryptomattes; dwaa and dwab cannot save layers with a channel Y, such as normals",
        ),
        &mut film.storage.compression,
        &compressions,
    );
    let mut is_limited = film.noise_target.is_some();
    if fields::checkbox(ui, "Limit noise", &mut is_limited) {
        film.noise_target = is_limited.then_some(0.02);
        changed = true;
    }
    if let Some(noise) = &mut film.noise_target {
        changed |= fields::log_slider(ui, ("Noise", "noise_target"), noise, 0.001..=0.5);
    }
    changed
}

/// Warns of a film that takes much memory.
fn memory(ui: &mut Ui, film: &Film) {
    let window = film.window();
    let bytes = full_film_bytes(UVec2::new(window.width, window.height), FilmLayers::default());
    if is_large(bytes) {
        let text = format!("{} of memory when rendered in full", Bytes(bytes));
        ui.colored_label(ui.visuals().warn_fg_color, text).on_hover_text(
            "The window traces no more pixels than it shows, until you choose Render full film or save the image",
        );
    }
}

/// Keeps the crop within the film.
fn crop(ui: &mut Ui, film: &mut Film) -> bool {
    let mut is_cropped = film.crop.is_some();
    let mut changed = fields::checkbox(ui, ("Crop", "crop"), &mut is_cropped);
    if changed {
        film.crop = is_cropped.then(|| film.window());
    }
    if let Some(crop) = &mut film.crop {
        let mut moved = fields::integer(ui, ("Left", "crop.x"), &mut crop.x, 0..=film.width.saturating_sub(1));
        moved |= fields::integer(ui, ("Top", "crop.y"), &mut crop.y, 0..=film.height.saturating_sub(1));
        moved |= fields::integer(ui, ("Crop width", "crop.width"), &mut crop.width, 1..=film.width.max(1));
        moved |= fields::integer(
            ui,
            ("Crop height", "crop.height"),
            &mut crop.height,
            1..=film.height.max(1),
        );
        if moved {
            film.crop = Some(film.window());
        }
        changed |= moved;
    }
    changed
}

fn filter(ui: &mut Ui, filter: &mut ReconstructionFilter) -> bool {
    use ReconstructionFilter::{Box, CatmullRom, Gaussian, Lanczos, Mitchell, Tent};
    let kinds = ReconstructionFilter::DECLARED.iter();
    let kinds: Vec<_> = kinds.map(|kind| (kind.name, kind.label)).collect();
    let mut plugin = filter.plugin();
    let changed = fields::choice(ui, ("Filter", "filter"), &mut plugin, &kinds);
    if changed {
        *filter = ReconstructionFilter::of_plugin(plugin).unwrap_or(*filter);
    }
    changed
        | match filter {
            Box | CatmullRom => false,
            Tent { radius } => fields::slider(ui, ("Radius", "radius"), radius, 0.1..=4.0),
            Gaussian { stddev } => {
                let caption = Caption::from(("Std. deviation", "stddev"));
                let caption = caption.explained("The standard deviation of the Gaussian, in pixels");
                fields::slider(ui, caption, stddev, 0.1..=2.0)
            }
            Mitchell { b, c } => {
                fields::slider(ui, ("B", "b"), b, 0.0..=1.0) | fields::slider(ui, ("C", "c"), c, 0.0..=1.0)
            }
            Lanczos { lobes } => fields::integer(ui, ("Lobes", "lobes"), lobes, 1..=16),
        }
}
