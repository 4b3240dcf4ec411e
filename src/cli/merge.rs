//! `sunroom merge`: merges parts of a picture, bit by bit as if it had been rendered at once, and shares of a bake to
//! its level.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use clap::Args;
use sunroom::app::origin::digest;
use sunroom::app::threads::worker_count;
use sunroom::bake::files;
use sunroom::bake::merging::merge;
use sunroom::bake::part::is_part;
use sunroom::engine::PictureNames;
use sunroom::layer::Layer;
use sunroom::memory;
use sunroom::render::camera::Camera;
use sunroom::render::denoise::denoise_film;
use sunroom::render::film::Film;
use sunroom::render::image_io::{ExrCompression, ImageRgb};
use sunroom::render::layered_image::{Attribute, LayeredImage};
use sunroom::render::part::{PartFile, PartHeader, check_cover};
use sunroom::scene::Film as SensorFilm;
use sunroom::scene::export::ExportError;
use sunroom::scene::{ComponentFormat, FilmStorage, PixelFormat};

use super::args::{MemoryArgs, ThreadArgs};
use super::bake::{BAKES_WITHOUT, is_file_of_level, report_invalid, report_merged, within_folder};
use super::outputs::{self, PART};
use super::picture_args::{DisplayArgs, FileArgs};
use super::report::{self, Failure, RENDERS_WITHOUT, check_denoiser};
use super::share::warn_of_missing;

#[derive(Args)]
pub struct MergeArgs {
    /// Files that `sunroom render --samples` or `--crop` has written, or `sunroom bake --samples`, in any order
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Image file, as of `sunroom render`; may be given several times. Of shares of a bake: its folder
    #[arg(short, long, required = true, value_name = "OUT")]
    output: Vec<PathBuf>,
    /// Remove the noise with Open Image Denoise
    #[arg(long)]
    denoise: bool,
    /// Keep the noise of the lightmaps and probes of a bake, which is removed otherwise
    #[arg(long, conflicts_with = "denoise")]
    no_denoise: bool,
    /// Merge parts even if the scene, the settings or the version differ
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    display: DisplayArgs,
    #[command(flatten)]
    file: FileArgs,
    /// Say nothing about a merge that succeeds
    #[arg(short, long)]
    quiet: bool,
}

pub fn run(args: &MergeArgs) -> Result<ExitCode, Failure> {
    args.memory.apply();
    args.threads.report_limit();
    if args.parts.iter().any(|part| is_part(part)) {
        if let Some(option) = args.display.given().or(args.file.given()) {
            let message = format!("{option} is for pictures, and the shares of a bake make a level");
            return Err(Failure::Usage(message));
        }
        return merge_bake(args);
    }
    outputs::check_inputs_stay(&args.output, &args.parts, PART).map_err(Failure::Usage)?;
    outputs::check_pictures(&args.output)?;
    check_denoiser(args.denoise, RENDERS_WITHOUT)?;
    let mut parts = Vec::new();
    for path in &args.parts {
        let name = path.display().to_string();
        let file = PartFile::open(path).map_err(|error| format!("{name}: {error}"))?;
        parts.push((name, file));
    }
    check(&parts, args.force)?;
    // The samples of each pixel are added in order.
    parts.sort_by_key(|(_, file)| file.header().samples);
    let Some((_, first)) = parts.first() else {
        return Err(Failure::Usage("there are no parts".to_owned()));
    };
    let (header, kept) = (first.header(), first.header().film_layers());
    let (width, height) = (header.width, header.height);
    let _memory = memory::reserve(Film::memory_bytes(width, height, kept))
        .map_err(|shortage| format!("a film of {width} x {height} pixels needs {shortage}"))?;
    let mut film = Film::with_layers(width, height, kept);
    for (name, file) in &parts {
        file.read_into(&mut film).map_err(|error| format!("{name}: {error}"))?;
    }
    let of_whole = parts
        .iter()
        .filter_map(|(_, file)| file.header().samples_of_whole)
        .max();
    let end = parts.iter().map(|(_, file)| file.header().samples[1]).max();
    warn_of_missing("pixel", end.unwrap_or(0), of_whole);
    write(args, &film, header)
}

/// Merges the shares of a bake.
fn merge_bake(args: &MergeArgs) -> Result<ExitCode, Failure> {
    check_denoiser(!args.no_denoise, BAKES_WITHOUT)?;
    let [folder] = &args.output[..] else {
        return Err(Failure::Usage(
            "the shares of a bake make one folder: give one `-o`".to_owned(),
        ));
    };
    let replaced = args.parts.iter().find(|path| is_file_of_level(folder, path));
    let outputs: Vec<PathBuf> = [folder].into_iter().chain(replaced).cloned().collect();
    outputs::check_inputs_stay(&outputs, &args.parts, PART).map_err(Failure::Usage)?;
    within_folder(folder, || {
        let mut merged = merge(&args.parts, args.force)?;
        // A file in the folder that would be replaced, and that has the content of a file of the scene.
        let is_of_scene =
            |path: &PathBuf| digest(path).is_ok_and(|found| merged.files.iter().any(|file| file.digest == found));
        if let Some(path) = files::replaceable(folder).into_iter().find(is_of_scene) {
            return Err(ExportError::InUse { path }.into());
        }
        warn_of_missing("texel", merged.samples, merged.samples_of_whole);
        merged.blueprint.denoise = !args.no_denoise;
        let threads = worker_count(args.threads.threads, false).get();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let baked = merged.blueprint.finished(&merged.lights, &pool)?;
        files::write(folder, &merged.blueprint, &baked)?;
        report_merged(baked.merged);
        report_invalid(merged.lights.iter().map(|light| light.invalid).sum());
        if !args.quiet {
            report::line(format_args!("the level is in {}", folder.display()));
        }
        Ok(ExitCode::SUCCESS)
    })
}

/// Refuses parts that are unfinished, of different pictures, or that do not make up a whole picture.
fn check(parts: &[(String, PartFile)], force: bool) -> Result<(), Failure> {
    let Some((first_name, first)) = parts.first() else {
        return Ok(());
    };
    let first = first.header();
    for (name, file) in parts {
        let header = file.header();
        if !header.is_finished {
            return Err(format!("{name} is not finished: resume it by `sunroom render --resume`").into());
        }
        if !SensorFilm::is_possible(header.width, header.height) {
            let (width, height, most) = (header.width, header.height, SensorFilm::MOST_PIXELS);
            return Err(format!("{name} has {width} x {height} pixels; a picture has at most {most}").into());
        }
        let differences = header.origin.differences(&first.origin);
        let is_alike =
            [header.width, header.height] == [first.width, first.height] && header.film_layers() == first.film_layers();
        let is_forced = force && is_alike;
        if !differences.is_empty() && !is_forced {
            let text = differences.join("; ");
            return Err(format!("{name} is a part of another picture than {first_name}: {text}").into());
        }
        if !is_alike {
            return Err(format!("{name} has another size or other layers than {first_name}").into());
        }
    }
    let headers: Vec<(String, PartHeader)> = parts
        .iter()
        .map(|(name, file)| (name.clone(), file.header().clone()))
        .collect();
    Ok(check_cover(&headers)?)
}

fn write(args: &MergeArgs, film: &Film, header: &PartHeader) -> Result<ExitCode, Failure> {
    let threads = Some(worker_count(args.threads.threads, false).get());
    let layers = film.layers().layers;
    let denoised = (args.denoise || layers.contains(Layer::Denoised))
        .then(|| denoise_film(film, threads, &AtomicBool::new(false)));
    let (denoised, failure) = match denoised {
        Some(Ok(pixels)) => (Some(pixels), None),
        Some(Err(error)) => (None, Some(error)),
        None => (None, None),
    };
    let picture = ImageRgb {
        width: film.width(),
        height: film.height(),
        pixels: denoised
            .clone()
            .filter(|_| args.denoise)
            .unwrap_or_else(|| film.radiance()),
    };
    let about = &header.about;
    let names = PictureNames {
        objects: about.objects.clone(),
        materials: about.materials.clone(),
        light_groups: about.light_groups.clone(),
    };
    let camera = Camera::of_axes(&about.camera_axes.map(f32::from_bits));
    let mut picture = names.layered(&picture, film, &camera, denoised.as_deref());
    describe(&mut picture, header, film.sample_count());
    let options = args.file.options(args.display.display(), storage(header));
    let written = outputs::write_pictures(&args.output, &picture, &options);
    if !args.quiet {
        outputs::report_written(&written);
    }
    if let Some(error) = &failure {
        match args.denoise {
            true => drop(report::error(format_args!("{error}; the picture is not denoised"))),
            false => report::line(format_args!("warning: {error}; the layer `denoised` is missing")),
        }
    }
    let is_done = written.len() == args.output.len() && (failure.is_none() || !args.denoise);
    Ok(if is_done { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Sets the attributes as if the picture had been rendered at once.
fn describe(picture: &mut LayeredImage, header: &PartHeader, samples: u32) {
    let texts = header.about.texts.iter();
    picture.set_attributes(texts.map(|(name, value)| (name.clone(), Attribute::Text(value.clone()))));
    for (name, bits) in ["worldToCamera", "worldToNDC"].into_iter().zip(header.about.matrices) {
        picture.set_attribute(name, Attribute::Matrix(bits.map(f32::from_bits)));
    }
    let mut int = |name: &str, value: u32| {
        picture.set_attribute(name, Attribute::Int(i32::try_from(value).unwrap_or(i32::MAX)));
    };
    int("sunroom:spp", samples);
    int("sunroom:seed", header.about.seed);
}

fn storage(header: &PartHeader) -> FilmStorage {
    let [pixels, components, compression] = &header.about.storage;
    FilmStorage {
        pixels: pixels.as_deref().and_then(PixelFormat::of_name),
        components: components.as_deref().and_then(ComponentFormat::of_name),
        file: None,
        compression: compression.as_deref().and_then(ExrCompression::of_name),
    }
}
