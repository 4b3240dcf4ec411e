//! `sunroom diff`: the difference of a picture from another, in figures, as pictures, and as a page.
//!
//! Exit codes are those of `diff` and `cmp`: 0 similar enough, 1 too different, 2 wrong usage or a file that cannot be
//! read or written.

mod chosen;
mod figures;
mod metric;
mod page;
mod pair;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use sunroom::files::write_atomically;
use sunroom::render::image_io::{FileFormat, FileOptions};
use sunroom::render::layered_image::{LayeredImage, Samples};

use self::figures::Figures;
use self::metric::Threshold;
use self::pair::Pair;
use super::args::MemoryArgs;
use super::picture_args::DisplayArgs;
use super::report::{self, Failure};
use super::{outputs, parse};

#[derive(Args)]
pub struct DiffArgs {
    /// Picture to judge (EXR, HDR, PFM, PNG, JPEG, BMP, TGA or PPM)
    pub picture: PathBuf,
    /// Picture that it is measured against
    pub reference: PathBuf,
    /// Layer or channel of EXR files to compare, such as Albedo, depth or Normal.Y [default: the picture itself]
    #[arg(long, value_name = "NAME", value_parser = parse::layer)]
    layer: Option<String>,
    /// End with code 1 if a figure is greater: mean (of the ratio's distance from 1), mse, relmse, flip or z; flip if
    /// none is named
    #[arg(long, value_name = "[METRIC=]VALUE", value_parser = Threshold::above)]
    fail_above: Vec<Threshold>,
    /// End with code 1 if a figure is smaller: psnr or ssim
    #[arg(long, value_name = "METRIC=VALUE", value_parser = Threshold::below)]
    fail_below: Vec<Threshold>,
    /// Write the difference: with its sign and with the layer FLIP as EXR, else its absolute value
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// Write the errors of FLIP in colours as PNG
    #[arg(long, value_name = "OUT.png")]
    flip_map: Option<PathBuf>,
    /// Write a page with figures and pictures, one file that needs no others
    #[arg(long, value_name = "OUT.html")]
    html: Option<PathBuf>,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    display: DisplayArgs,
    #[command(flatten)]
    memory: MemoryArgs,
}

pub fn run(args: &DiffArgs) -> Result<ExitCode, Failure> {
    args.memory.apply();
    match diff(args) {
        Ok(true) => Ok(ExitCode::SUCCESS),
        Ok(false) => Ok(ExitCode::FAILURE),
        Err(error) => Err(Failure::Usage(error.to_string())),
    }
}

type Error = Box<dyn std::error::Error>;

/// Whether the pictures are similar enough.
fn diff(args: &DiffArgs) -> Result<bool, Error> {
    let results = [&args.output, &args.flip_map, &args.html];
    let results: Vec<PathBuf> = results.into_iter().flatten().cloned().collect();
    let compared = [args.picture.clone(), args.reference.clone()];
    outputs::check_distinct(&results)?;
    outputs::check_inputs_stay(&results, &compared, "one of the pictures that are compared")?;
    for path in args
        .output
        .iter()
        .chain(&args.flip_map)
        .filter(|path| !outputs::is_stdout(path))
    {
        FileFormat::from_path(path)?;
    }
    if let Some(path) = &args.html
        && !path
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("html") || end.eq_ignore_ascii_case("htm"))
    {
        return Err(format!("{}: the name of a page ends in .html or .htm", path.display()).into());
    }
    let layer = args.layer.as_deref().unwrap_or("");
    let pair = Pair::read([&args.picture, &args.reference], layer)?;
    for note in &pair.notes {
        report::line(format_args!("note: {note}"));
    }
    if pair.seen.is_none() && args.flip_map.is_some() {
        return Err(
            format!("`{layer}` is a layer of data, which has no errors of FLIP: leave out `--flip-map`").into(),
        );
    }
    let figures = Figures::of(&pair);
    let text = match args.json {
        true => format!("{}\n", serde_json::to_string_pretty(&figures)?),
        false => figures.text(&pair),
    };
    let pictures = [&args.output, &args.flip_map];
    match pictures.into_iter().flatten().any(|path| outputs::is_stdout(path)) {
        true => report::line(text.trim_end()),
        false => outputs::print(text.as_bytes())?,
    }
    let options = FileOptions::from(&args.display.display());
    if let Some(path) = &args.output {
        outputs::write_picture(path, &difference(&pair, path), &options)?;
    }
    if let (Some(path), Some(errors)) = (&args.flip_map, pair.flip_picture()) {
        // The colours are already display-referred.
        outputs::write_picture(path, &LayeredImage::from(&errors), &FileOptions::default())?;
    }
    if let Some(path) = &args.html {
        let page = page::page(&pair, &figures, &options)?;
        write_atomically(path, page).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    }
    let mut alike = true;
    for threshold in args.fail_above.iter().chain(&args.fail_below) {
        if let Some(reason) = threshold.broken_by(&figures) {
            report::line(reason);
            alike = false;
        }
    }
    Ok(alike)
}

/// The difference as the file is to store it.
fn difference(pair: &Pair, path: &Path) -> LayeredImage {
    let is_exr = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
    let pixels = pair.picture.pixels.iter().zip(&pair.reference.pixels);
    let signed = pixels.map(|(&a, &b)| a - b);
    let mut image = LayeredImage::new(pair.picture.width, pair.picture.height);
    match is_exr {
        true => {
            image.add_rgb("", &signed.collect::<Vec<_>>());
            if let Some(seen) = &pair.seen {
                image.add_channel("FLIP.Y", Samples::Float(seen.flip.clone()));
            }
        }
        false => image.add_rgb("", &signed.map(|difference| difference.abs()).collect::<Vec<_>>()),
    }
    image
}
