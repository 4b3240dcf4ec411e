//! Sensors `perspective`, `thinlens` and `orthographic`, with their film, reconstruction filter and sampler.

use glam::Vec2;

use super::parameters::Parameters;
use super::scene_reader::SceneReader;
use crate::document::{Category, Object, Reader};
use crate::files::ExrCompression;
use crate::scene::description::{DeclarationPlace, SensorDescription};
use crate::scene::encode::objects;
use crate::scene::{
    ComponentFormat, Crop, Film, FilmStorage, FovAxis, Lens, PictureFormat, PixelFormat, ReconstructionFilter, Sensor,
};

/// What the sampler says of the samples. It is part of the [`Film`] here, so that it is looked for there.
const SAMPLER_PARAMETERS: [&str; 4] = ["sample_count", "noise_target", "adaptive", "seed"];

/// The field of view along the diagonal, in degrees, of a lens of `millimetres` before 35 mm film (a frame of 36 x 24
/// mm).
pub fn fov_of_focal_length(millimetres: f32) -> f32 {
    2.0 * (0.5 * 36f32.hypot(24.0) / millimetres).atan().to_degrees()
}

/// The millimetres of a `focal_length` such as `50mm`; None for other texts.
pub fn millimetres(focal_length: &str) -> Option<f32> {
    let text = focal_length.trim();
    let number = text.strip_suffix("mm").unwrap_or(text).trim().parse::<f32>().ok();
    number.filter(|millimetres| *millimetres > 0.0 && millimetres.is_finite())
}

impl<'a> SceneReader<'a> {
    /// Whether the sensor became part of the description.
    pub(super) fn read_sensor(&mut self, object: &'a Object) -> bool {
        let mut reader = self.reader(object);
        match object.plugin.as_str() {
            "perspective" | "thinlens" | "orthographic" => {}
            other => {
                let message = format!("sensor `{other}` is not supported: it is left out");
                reader.diagnostics().warn(object.span, message);
                return false;
            }
        }
        let near_clip = reader.float_in("near_clip", f32::MIN_POSITIVE..).unwrap_or(1e-2);
        let mut far_clip = reader.float_in("far_clip", f32::MIN_POSITIVE..).unwrap_or(1e4);
        if far_clip <= near_clip {
            let message = format!("`far_clip` is {far_clip}, but should be above `near_clip`, {near_clip}");
            reader.error_at("far_clip", message);
            far_clip = 2.0 * near_clip;
        }
        let lens = read_lens(&mut reader, far_clip);
        let (fov, fov_axis) = match lens {
            Lens::Orthographic => (Sensor::default().fov, FovAxis::default()),
            Lens::Pinhole | Lens::Thin { .. } => read_fov(&mut reader),
        };
        let offset = |reader: &mut Reader, name| reader.float_in(name, -1e3..=1e3).unwrap_or(0.0);
        let principal_point_offset = Vec2::new(
            offset(&mut reader, "principal_point_offset_x"),
            offset(&mut reader, "principal_point_offset_y"),
        );
        let shutter_open = reader.float_in("shutter_open", -1e9..=1e9).unwrap_or(0.0);
        let mut shutter_close = reader.float_in("shutter_close", -1e9..=1e9).unwrap_or(shutter_open);
        if shutter_close < shutter_open {
            let message =
                format!("`shutter_close` is {shutter_close}, but should not be below `shutter_open`, {shutter_open}");
            reader.error_at("shutter_close", message);
            shutter_close = shutter_open;
        }
        let to_world = reader.to_world();
        let film = reader.children(Category::Film);
        let sampler = reader.children(Category::Sampler);
        let media = reader.children(Category::Medium);
        reader.finish();

        let mut read_film = Film::of_format();
        if let Some((_, film)) = film.first() {
            self.read_film(film, &mut read_film);
        }
        if let Some((_, sampler)) = sampler.first() {
            read_sampler(self.reader(sampler), &mut read_film);
        }
        for (_, second) in film.iter().skip(1).chain(sampler.iter().skip(1)) {
            let message = format!("a second {} has no effect", second.category.name());
            self.diagnostics.warn(second.span, message);
        }
        let place = DeclarationPlace::Sensor(self.description.sensors.len());
        let before = self.declared();
        let medium = self.read_medium_around(&media, place);
        let Some(to_world) = to_world else {
            self.forget_place(place, before);
            return false;
        };
        let sensor = Sensor {
            lens,
            fov,
            fov_axis,
            near_clip,
            far_clip,
            principal_point_offset,
            shutter_open,
            shutter_close,
        };
        let mut identity = self.identity(object, || objects::sensor(&sensor, &read_film, &to_world));
        if let Some(authored) = &mut identity.authored {
            authored.leave_out_media(|_, number| number == 0 && medium.is_some());
        }
        self.description.sensors.push(SensorDescription {
            identity,
            sensor,
            film: read_film,
            to_world,
            medium,
        });
        true
    }

    fn read_film(&mut self, object: &'a Object, film: &mut Film) {
        let mut reader = self.reader(object);
        if object.plugin != "hdrfilm" {
            let message = format!("film `{}` is not supported: `hdrfilm` takes its place", object.plugin);
            reader.diagnostics().warn(object.span, message);
        }
        let side = |number: i64| u32::try_from(number).unwrap_or(1);
        let sides = 1..=i64::from(Film::LARGEST_SIDE);
        film.width = side(reader.integer_in("width", sides.clone()).unwrap_or(768));
        film.height = side(reader.integer_in("height", sides).unwrap_or(576));
        if !Film::is_possible(film.width, film.height) {
            let (width, height, most) = (film.width, film.height, Film::MOST_PIXELS);
            let message = format!("a film of {width} x {height} pixels is too large: at most {most} are possible");
            reader.error_at("width", message);
        }
        film.crop = read_crop(&mut reader, film.width, film.height);
        film.storage = FilmStorage {
            pixels: chosen(&mut reader, "pixel_format", &PixelFormat::ALL, PixelFormat::name),
            components: chosen(
                &mut reader,
                "component_format",
                &ComponentFormat::ALL,
                ComponentFormat::name,
            ),
            file: chosen(&mut reader, "file_format", &PictureFormat::NAMES, |(name, _)| name).map(|(_, format)| format),
            compression: chosen(&mut reader, "compression", &ExrCompression::ALL, ExrCompression::name),
        };
        reader.ignore(&[
            "banner",
            "high_quality_edges",
            "sample_border",
            "compensate",
            "attach_log",
            "gamma",
            "exposure",
        ]);
        reader.belongs_to("the sampler", &SAMPLER_PARAMETERS);
        let filter = reader.children(Category::ReconstructionFilter);
        if object.plugin == "hdrfilm" {
            reader.finish();
        }
        if let Some((_, filter)) = filter.first() {
            film.filter = read_filter(self.reader(filter));
        }
    }
}

/// The value of this name. What is not known is left out, with a warning.
fn chosen<T: Copy>(reader: &mut Reader, parameter: &str, all: &[T], name: fn(T) -> &'static str) -> Option<T> {
    let text = reader.string(parameter)?;
    let found = all
        .iter()
        .copied()
        .find(|&value| name(value).eq_ignore_ascii_case(text));
    if found.is_none() {
        let names: Vec<String> = all.iter().map(|&value| format!("`{}`", name(value))).collect();
        let message = format!(
            "`{parameter}` `{text}` is not supported and has no effect: expected {}",
            names.join(", ")
        );
        reader.warn_at(parameter, message);
    }
    found
}

/// The crop; None if there is none, or if it is not within the film.
fn read_crop(reader: &mut Reader, width: u32, height: u32) -> Option<Crop> {
    const NAMES: [&str; 4] = ["crop_offset_x", "crop_offset_y", "crop_width", "crop_height"];
    let [x, y, crop_width, crop_height] = NAMES.map(|name| {
        let least = i64::from(name == "crop_width" || name == "crop_height");
        let number = reader.integer_in(name, least..=i64::from(Film::LARGEST_SIDE));
        number.and_then(|number| u32::try_from(number).ok())
    });
    let crop = Crop {
        x: x.unwrap_or(0),
        y: y.unwrap_or(0),
        width: crop_width.unwrap_or(width),
        height: crop_height.unwrap_or(height),
    };
    if crop.x + crop.width > width || crop.y + crop.height > height {
        let Crop {
            x,
            y,
            width: w,
            height: h,
        } = crop;
        let given = NAMES.into_iter().find(|name| reader.has(name)).unwrap_or("width");
        let message = format!("a crop of {w} x {h} pixels at {x}, {y} reaches out of the film of {width} x {height}");
        reader.error_at(given, message);
        return None;
    }
    let whole = Crop {
        x: 0,
        y: 0,
        width,
        height,
    };
    (crop != whole).then_some(crop)
}

/// The plugin is one of the three.
fn read_lens(reader: &mut Reader, far_clip: f32) -> Lens {
    let focus_distance = reader.float_in("focus_distance", f32::MIN_POSITIVE..);
    match reader.object().plugin.as_str() {
        "orthographic" => Lens::Orthographic,
        "thinlens" => {
            if !reader.has("aperture_radius") {
                reader.error_at("aperture_radius", "`thinlens` needs an `aperture_radius`");
            }
            let blades = reader.integer_in("blades", 0..=1000).unwrap_or(0);
            Lens::Thin {
                aperture_radius: reader.float_in("aperture_radius", 0.0..).unwrap_or(0.0),
                focus_distance: focus_distance.unwrap_or(far_clip),
                blades: u32::try_from(blades).unwrap_or(0),
                blade_rotation: reader.float_in("blade_rotation", f32::MIN..=f32::MAX).unwrap_or(0.0),
            }
        }
        _ => Lens::Pinhole,
    }
}

/// The field of view, from `fov` and `fov_axis` or from `focal_length`.
pub(super) fn read_fov(reader: &mut Reader) -> (f32, FovAxis) {
    let axis = reader.string_or("fov_axis", "x");
    let focal_length = reader.string("focal_length");
    if reader.has("fov") {
        if focal_length.is_some() {
            reader.error_at("focal_length", "`fov` and `focal_length` exclude each other");
        }
        let axis = axis.to_ascii_lowercase();
        let axis = FovAxis::of_name(&axis).unwrap_or_else(|| {
            let message = format!("expected `x`, `y`, `diagonal`, `smaller` or `larger`, found `{axis}`");
            reader.error_at("fov_axis", message);
            FovAxis::X
        });
        let fov = reader.float("fov").unwrap_or(45.0);
        if fov > 0.0 && fov < 180.0 {
            return (fov, axis);
        }
        reader.error_at(
            "fov",
            format!("`fov` is {fov}, but should be above 0 and below 180 degrees"),
        );
        return (45.0, axis);
    }
    let text = focal_length.unwrap_or("50mm");
    match millimetres(text) {
        Some(millimetres) => (fov_of_focal_length(millimetres), FovAxis::Diagonal),
        None => {
            let message = format!("expected a focal length such as `50mm`, found `{text}`");
            reader.error_at("focal_length", message);
            (fov_of_focal_length(50.0), FovAxis::Diagonal)
        }
    }
}

fn read_filter(mut reader: Reader) -> ReconstructionFilter {
    let pixels = f32::MIN_POSITIVE..=16.0;
    let filter = match reader.object().plugin.as_str() {
        "box" => ReconstructionFilter::Box,
        "tent" => ReconstructionFilter::Tent {
            radius: reader.float_in("radius", pixels).unwrap_or(1.0),
        },
        "gaussian" => ReconstructionFilter::Gaussian {
            stddev: reader.float_in("stddev", pixels).unwrap_or(0.5),
        },
        "mitchell" => {
            let mut parameter = |name| reader.float_in(name, -4.0..=4.0).unwrap_or(1.0 / 3.0);
            ReconstructionFilter::Mitchell {
                b: parameter("B"),
                c: parameter("C"),
            }
        }
        "catmullrom" => ReconstructionFilter::CatmullRom,
        "lanczos" => {
            let lobes = reader.integer_in("lobes", 1..=16).unwrap_or(3);
            ReconstructionFilter::Lanczos {
                lobes: u32::try_from(lobes).unwrap_or(3),
            }
        }
        other => {
            let message = format!("rfilter `{other}` is not supported: `gaussian` takes its place");
            let span = reader.object().span;
            reader.diagnostics().warn(span, message);
            return ReconstructionFilter::default();
        }
    };
    reader.finish();
    filter
}

/// The number of samples, and the noise that ends them. All samplers converge to the same picture, so that all are
/// accepted, and the user chooses the sequence.
fn read_sampler(mut reader: Reader, film: &mut Film) {
    let count = reader.integer_in("sample_count", 1..=i64::from(Film::LARGEST_SAMPLE_COUNT));
    film.sample_count = count
        .and_then(|count| u32::try_from(count).ok())
        .unwrap_or(film.sample_count);
    film.adaptive = reader.boolean("adaptive").unwrap_or(false);
    film.noise_target = reader.float_in("noise_target", f32::MIN_POSITIVE..=f32::MAX);
    reader.ignore(&["seed", "jitter"]);
    const KNOWN: [&str; 5] = ["independent", "stratified", "multijitter", "orthogonal", "ldsampler"];
    let plugin = reader.object().plugin.as_str();
    if KNOWN.contains(&plugin) {
        reader.finish();
    } else {
        let message = format!("sampler `{plugin}` is not supported: `independent` takes its place");
        let span = reader.object().span;
        reader.diagnostics().warn(span, message);
    }
}
