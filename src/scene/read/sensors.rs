//! Reads sensors `perspective`, `thinlens` and `orthographic`, with their film, reconstruction filter and sampler.

use glam::Vec2;

use super::field_of_view::read_fov;
use super::from_file::FromFile;
use super::parameters::Parameters;
use super::picture_search::PictureSearch;
use super::scene_reader::SceneReader;
use crate::document::{Category, Object, Reader};
use crate::files::ExrCompression;
use crate::scene::components::description::{DeclarationPlace, SensorDescription};
use crate::scene::encode::objects;
use crate::scene::{
    ComponentFormat, Crop, Film, FilmStorage, FovAxis, Lens, PictureFormat, PixelFormat, ReconstructionFilter, Sensor,
};

/// Parameters of the sampler. Some are part of the [`Film`] here, so that users may look for them there.
const SAMPLER_PARAMETERS: [&str; 4] = ["sample_count", "noise_target", "adaptive", "seed"];

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
        let mut identity = self.identity(object, |_| objects::sensor(&sensor, &read_film, &to_world));
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
            let reader = Reader::new(&self.index, filter, &mut self.diagnostics);
            film.filter = read_filter(reader, &mut self.pictures);
        }
    }
}

/// The value with this name. An unknown one is left out, with a warning.
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

fn read_filter(mut reader: Reader, pictures: &mut PictureSearch) -> ReconstructionFilter {
    let plugin = reader.object().plugin.as_str();
    let Some(mut filter) = ReconstructionFilter::of_plugin(plugin) else {
        let message = format!("rfilter `{plugin}` is not supported: `gaussian` takes its place");
        let span = reader.object().span;
        reader.diagnostics().warn(span, message);
        return ReconstructionFilter::default();
    };
    let values = FromFile {
        reader: &mut reader,
        pictures,
    };
    values.read_all(&mut filter);
    reader.finish();
    filter
}

/// Reads the number of samples, and the noise limit. All samplers converge to the same picture, so that all are
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
