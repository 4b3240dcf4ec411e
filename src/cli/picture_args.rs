//! Options for the display and the storage of pictures.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use sunroom::engine::file_options;
use sunroom::render::image_io::{ExrCompression, FileOptions};
use sunroom::render::tonemap::{Display, ToneMap};
use sunroom::render::white_balance::WhiteBalance;

use sunroom::scene::FilmStorage;

use super::parse;

#[derive(Args)]
pub struct SizeArgs {
    /// Both sides of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = parse::picture_size, conflicts_with_all = ["width", "height"])]
    pub size: Option<(u32, u32)>,
    /// Width of the picture in pixels; the other side follows if it is not given
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub width: Option<u32>,
    /// Height in pixels
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub height: Option<u32>,
}

#[derive(Args)]
pub struct DisplayArgs {
    /// Exposure of PNG and JPEG files: stops, -100 to 100; an exposure value as `ev100:12`; or aperture, shutter time
    /// and ISO of a camera as `f/8,1/60,400` [default: 0]
    #[arg(long, value_name = "EV", value_parser = parse::exposure)]
    exposure: Option<f32>,
    /// Tone map of PNG and JPEG files [default: clip]
    #[arg(long, value_parser = named(&ToneMap::ALL, ToneMap::name))]
    tonemap: Option<ToneMap>,
    /// White balance of PNG and JPEG files: the temperature of the light that shall look white, and its tint [default:
    /// 6504,0]
    #[arg(long, value_name = "KELVIN[,TINT]", value_parser = parse::white)]
    white: Option<WhiteBalance>,
}

impl DisplayArgs {
    pub fn display(&self) -> Display {
        Display {
            exposure_ev: self.exposure.unwrap_or(0.0),
            white_balance: self.white.unwrap_or_default(),
            tone_map: self.tonemap.unwrap_or(ToneMap::Clip),
        }
    }

    /// The first of these options that is given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            self.exposure.map(|_| "--exposure"),
            self.tonemap.map(|_| "--tonemap"),
            self.white.map(|_| "--white"),
        ];
        given.into_iter().flatten().next()
    }
}

#[derive(Args)]
pub struct FileArgs {
    /// Precision of the colours in EXR files [default: the scene's, or float]
    #[arg(long, value_name = "TYPE", value_parser = one_of(&[("half", true), ("float", false)]))]
    exr_type: Option<bool>,
    /// Compression of EXR files [default: the scene's, or zip]
    #[arg(long, value_name = "NAME", value_parser = named(&ExrCompression::ALL, ExrCompression::name))]
    compression: Option<ExrCompression>,
    /// Bits of each channel of PNG files [default: 8]
    #[arg(long, value_name = "BITS", value_parser = PossibleValuesParser::new(["8", "16"]))]
    png_bits: Option<String>,
    /// Quality of JPEG files, 1 to 100 [default: 95]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=100))]
    jpeg_quality: Option<u8>,
}

impl FileArgs {
    /// The file options for a film with its own settings. Arguments have precedence over the film.
    pub fn options(&self, display: Display, storage: FilmStorage) -> FileOptions {
        let of_film = file_options(storage, display);
        FileOptions {
            exr_half: self.exr_type.unwrap_or(of_film.exr_half),
            exr_compression: self.compression.unwrap_or(of_film.exr_compression),
            png_16_bits: self.png_bits.as_deref() == Some("16"),
            jpeg_quality: self.jpeg_quality.unwrap_or(of_film.jpeg_quality),
            ..of_film
        }
    }

    /// The first of these options that is given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            self.exr_type.map(|_| "--exr-type"),
            self.compression.map(|_| "--compression"),
            self.png_bits.as_ref().map(|_| "--png-bits"),
            self.jpeg_quality.map(|_| "--jpeg-quality"),
        ];
        given.into_iter().flatten().next()
    }
}

/// A parser that accepts the names of these values.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    values: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    let names = PossibleValuesParser::new(values.iter().map(|(name, _)| *name));
    names.map(|chosen| {
        values
            .iter()
            .find(|(name, _)| *name == chosen)
            .expect("it is one of them")
            .1
    })
}

/// A parser that accepts the names of these values.
pub fn named<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.iter().map(move |&value| name(value))).map(move |chosen| {
        *all.iter()
            .find(|&&value| name(value) == chosen)
            .expect("it is one of them")
    })
}
