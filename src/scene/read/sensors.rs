//! Sensors `perspective` and `thinlens`, with their film, reconstruction filter and sampler.

use super::SceneReader;
use super::parameters::Parameters;
use crate::document::{Category, Object, Reader};
use crate::scene::description::SensorDescription;
use crate::scene::{Film, FovAxis, Lens, ReconstructionFilter, Sensor, write};

const LARGEST_SAMPLE_COUNT: i64 = 1 << 30;

/// Field of view along the diagonal, in degrees, of a lens of `millimetres` before 35 mm film (a frame of 36 x 24 mm).
pub fn fov_of_focal_length(millimetres: f32) -> f32 {
    2.0 * (0.5 * 36f32.hypot(24.0) / millimetres).atan().to_degrees()
}

impl<'a> SceneReader<'a> {
    /// Whether the sensor became part of the description.
    pub(super) fn read_sensor(&mut self, object: &'a Object) -> bool {
        let mut reader = self.reader(object);
        let is_thin_lens = match object.plugin.as_str() {
            "perspective" => false,
            "thinlens" => true,
            other => {
                let message = format!("sensor `{other}` is not supported: it is left out");
                reader.diagnostics().warn(object.span, message);
                return false;
            }
        };
        let (fov, fov_axis) = read_fov(&mut reader);
        let near_clip = reader.float_in("near_clip", f32::MIN_POSITIVE..).unwrap_or(1e-2);
        let mut far_clip = reader.float_in("far_clip", f32::MIN_POSITIVE..).unwrap_or(1e4);
        if far_clip <= near_clip {
            let message = format!("`far_clip` is {far_clip}, but should be above `near_clip`, {near_clip}");
            reader.error_at("far_clip", message);
            far_clip = 2.0 * near_clip;
        }
        let focus_distance = reader.float_in("focus_distance", f32::MIN_POSITIVE..);
        let lens = if is_thin_lens {
            if !reader.has("aperture_radius") {
                reader.error_at("aperture_radius", "`thinlens` needs an `aperture_radius`");
            }
            Lens::Thin {
                aperture_radius: reader.float_in("aperture_radius", 0.0..).unwrap_or(0.0),
                focus_distance: focus_distance.unwrap_or(far_clip),
            }
        } else {
            Lens::Pinhole
        };
        for offset in ["principal_point_offset_x", "principal_point_offset_y"] {
            if reader.float(offset).is_some_and(|offset| offset != 0.0) {
                reader.warn_at(offset, format!("`{offset}` is not supported: the picture is centred"));
            }
        }
        reader.ignore(&["shutter_open", "shutter_close"]);
        let to_world = reader.to_world();
        let film = reader.children(Category::Film);
        let sampler = reader.children(Category::Sampler);
        reader.finish();

        let mut read_film = Film {
            // The format's default; a sampler says more.
            sample_count: 4,
            ..Film::default()
        };
        if let Some((_, film)) = film.first() {
            self.read_film(film, &mut read_film);
        }
        if let Some((_, sampler)) = sampler.first() {
            read_film.sample_count = read_sample_count(self.reader(sampler)).unwrap_or(read_film.sample_count);
        }
        for (_, second) in film.iter().skip(1).chain(sampler.iter().skip(1)) {
            let message = format!("a second {} has no effect", second.category.tag());
            self.diagnostics.warn(second.span, message);
        }
        let Some(to_world) = to_world else {
            return false;
        };
        let sensor = Sensor {
            lens,
            fov,
            fov_axis,
            near_clip,
            far_clip,
        };
        let identity = self.identity(object, write::objects::sensor(&sensor, &read_film, &to_world));
        self.description.sensors.push(SensorDescription {
            identity,
            sensor,
            film: read_film,
            to_world,
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
        reader.ignore(&[
            "pixel_format",
            "component_format",
            "file_format",
            "banner",
            "high_quality_edges",
            "sample_border",
            "compensate",
            "attach_log",
            "gamma",
            "exposure",
        ]);
        let filter = reader.children(Category::ReconstructionFilter);
        if object.plugin == "hdrfilm" {
            reader.finish();
        }
        if let Some((_, filter)) = filter.first() {
            film.filter = read_filter(self.reader(filter));
        }
    }
}

fn read_fov(reader: &mut Reader) -> (f32, FovAxis) {
    let axis = reader.string_or("fov_axis", "x");
    let focal_length = reader.string("focal_length");
    if reader.has("fov") {
        if focal_length.is_some() {
            reader.error_at("focal_length", "`fov` and `focal_length` exclude each other");
        }
        let axis = match axis.to_ascii_lowercase().as_str() {
            "x" => FovAxis::X,
            "y" => FovAxis::Y,
            "diagonal" => FovAxis::Diagonal,
            "smaller" => FovAxis::Smaller,
            "larger" => FovAxis::Larger,
            other => {
                let message = format!("expected `x`, `y`, `diagonal`, `smaller` or `larger`, found `{other}`");
                reader.error_at("fov_axis", message);
                FovAxis::X
            }
        };
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
    let number = text.trim().strip_suffix("mm").unwrap_or(text).trim().parse::<f32>();
    match number {
        Ok(millimetres) if millimetres > 0.0 && millimetres.is_finite() => {
            (fov_of_focal_length(millimetres), FovAxis::Diagonal)
        }
        _ => {
            let message = format!("expected a focal length such as `50mm`, found `{text}`");
            reader.error_at("focal_length", message);
            (fov_of_focal_length(50.0), FovAxis::Diagonal)
        }
    }
}

fn read_filter(mut reader: Reader) -> ReconstructionFilter {
    let filter = match reader.object().plugin.as_str() {
        "box" => ReconstructionFilter::Box,
        "gaussian" => {
            let Some(stddev) = reader.float_in("stddev", f32::MIN_POSITIVE..=16.0) else {
                reader.finish();
                return ReconstructionFilter::default();
            };
            ReconstructionFilter::Gaussian { stddev }
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

/// All samplers converge to the same picture, so that all are welcome; which sequence is used is not the file's business.
fn read_sample_count(mut reader: Reader) -> Option<u32> {
    let count = reader.integer_in("sample_count", 1..=LARGEST_SAMPLE_COUNT);
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
    count.and_then(|count| u32::try_from(count).ok())
}
