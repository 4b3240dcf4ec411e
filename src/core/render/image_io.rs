//! Writes pictures to files: EXR (linear, with layers), Radiance HDR (linear, shared exponent), PFM (linear float32),
//! PNG and JPEG (as displayed).
//!
//! A file is complete or absent: it is written under another name in the same folder and then renamed.
//! [`super::tonemap`] maps radiance to displays; for standard output the caller uses [`encode`]. Pictures are read by
//! [`crate::texture::load_image`], and with their layers by [`exr::decode_exr`].

use std::io::Write as _;
use std::path::{Path, PathBuf};

use image::ImageError;
use image::codecs::hdr::HdrEncoder;
use thiserror::Error;

use self::exr::decode_exr;
use super::layered_image::{LayeredImage, StoredColors};
use super::tonemap::Display;
use crate::color::Rgb;
use crate::files::write_atomically;
use crate::memory;
use crate::texture::{ImageFileError, Transfer, is_exr, load_image};

mod displayed;
pub mod exr;

pub use crate::files::ExrCompression;

/// A picture of linear Rec. 709 radiance, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageRgb {
    /// The number of pixels in a row, above zero.
    pub width: u32,
    /// The number of rows, above zero.
    pub height: u32,
    /// The pixels, `width * height` of them.
    pub pixels: Vec<Rgb>,
}

impl ImageRgb {
    fn is_whole(&self) -> bool {
        self.pixels.len() == self.width as usize * self.height as usize && !self.pixels.is_empty()
    }
}

/// The formats in which pictures are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// OpenEXR with linear radiance, and all layers.
    Exr,
    /// Radiance's RGBE: linear, with eight bits for each mantissa and a common exponent.
    Hdr,
    /// A portable float map: linear radiance in 32-bit floats.
    Pfm,
    /// The displayed picture, with 8 or 16 bits per channel encoded as sRGB.
    Png,
    /// The displayed picture, with 8 bits per channel and lossy compression.
    Jpeg,
}

/// The options of files beyond the format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileOptions {
    /// The map from radiance to PNG and JPEG.
    pub display: Display,
    /// Whether the colours of EXR files are stored with 16 bits, see [`LayeredImage::store_colors_as_half`].
    pub exr_half: bool,
    /// The colours that EXR and PFM files hold.
    pub stored: StoredColors,
    /// The compression of EXR files.
    pub exr_compression: ExrCompression,
    /// Whether PNG files have 16 bits for each channel, in place of 8.
    pub png_16_bits: bool,
    /// The quality of JPEG files, 1 to 100.
    pub jpeg_quality: u8,
}

impl Default for FileOptions {
    fn default() -> Self {
        Self {
            display: Display::default(),
            exr_half: false,
            stored: StoredColors::default(),
            exr_compression: ExrCompression::default(),
            png_16_bits: false,
            jpeg_quality: 95,
        }
    }
}

impl From<&Display> for FileOptions {
    fn from(display: &Display) -> Self {
        Self {
            display: *display,
            ..Self::default()
        }
    }
}

impl FileFormat {
    /// Whether files of this format hold the displayed picture in place of radiance.
    pub fn is_displayed(self) -> bool {
        matches!(self, Self::Png | Self::Jpeg)
    }

    /// The format by the extension, whatever its case.
    pub fn from_path(path: &Path) -> Result<Self, ImageIoError> {
        let extension = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_ascii_lowercase();
        match extension.as_str() {
            "exr" => Ok(Self::Exr),
            "hdr" => Ok(Self::Hdr),
            "pfm" => Ok(Self::Pfm),
            "png" => Ok(Self::Png),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            _ => Err(ImageIoError::UnknownFormat(path.to_path_buf())),
        }
    }
}

/// The reason why a picture is not written.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ImageIoError {
    #[error("{}: the name of a picture ends in .exr, .hdr, .pfm, .png, .jpg or .jpeg", .0.display())]
    UnknownFormat(PathBuf),
    #[error("cannot write {}: {source}", .path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("cannot encode the picture: {0}")]
    Encode(#[from] ImageError),
    #[error("cannot encode the picture: {0}")]
    Exr(String),
    #[error("the channel `{name}` {what}")]
    Channel { name: String, what: String },
    #[error("{}: this format holds radiance, not what a display shows", .0.display())]
    NotDisplayed(PathBuf),
    #[error("the picture has no channels R, G and B, which this format needs; EXR holds the others as well")]
    NoColors,
    #[error("{pixels} pixels are no picture of {width} x {height}")]
    WrongSize { width: u32, height: u32, pixels: usize },
}

/// Writes in the format of the extension. `display` is for PNG and JPEG only: other formats hold the radiance itself.
pub fn write_image(path: &Path, image: &ImageRgb, display: &Display) -> Result<(), ImageIoError> {
    let bytes = encode(image, FileFormat::from_path(path)?, display)?;
    write(path, &bytes)
}

/// Writes in the format of the extension, see [`encode_layered`].
pub fn write_layered(path: &Path, image: &LayeredImage, options: &FileOptions) -> Result<(), ImageIoError> {
    let bytes = encode_layered(image, FileFormat::from_path(path)?, options)?;
    write(path, &bytes)
}

/// Writes the picture as EXR to a new file in the system's folder for temporary files and returns the file's name: for
/// a picture that cannot be written to its own path.
pub fn write_to_temporary_folder(image: &LayeredImage) -> Result<PathBuf, ImageIoError> {
    let bytes = exr::encode_exr(image, ExrCompression::default())?;
    let folder = std::env::temp_dir();
    let failed = |source: std::io::Error| ImageIoError::Write {
        path: folder.clone(),
        source,
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix("sunroom-").suffix(".exr");
    // Only the kind of the error is kept: its full message names a temporary file.
    let mut file = builder
        .tempfile_in(&folder)
        .map_err(|error| failed(error.kind().into()))?;
    file.as_file_mut().write_all(&bytes).map_err(failed)?;
    file.as_file().sync_all().map_err(failed)?;
    let (_, path) = file.keep().map_err(|error| failed(error.error))?;
    Ok(path)
}

/// Writes displayed colours, three bytes per pixel, as PNG or JPEG. An error for the extension of another format.
pub fn write_displayed(path: &Path, size: [u32; 2], rgb: &[u8]) -> Result<(), ImageIoError> {
    let bytes = match FileFormat::from_path(path)? {
        FileFormat::Png => displayed::png_of_bytes(size, rgb)?,
        FileFormat::Jpeg => displayed::jpeg_of_bytes(size, rgb, FileOptions::default().jpeg_quality)?,
        _ => return Err(ImageIoError::NotDisplayed(path.to_path_buf())),
    };
    write(path, &bytes)
}

/// The content of a file.
pub fn encode(image: &ImageRgb, format: FileFormat, display: &Display) -> Result<Vec<u8>, ImageIoError> {
    let (width, height) = (image.width, image.height);
    if !image.is_whole() {
        let pixels = image.pixels.len();
        return Err(ImageIoError::WrongSize { width, height, pixels });
    }
    match format {
        FileFormat::Exr => exr::encode_exr(&image.into(), ExrCompression::default()),
        _ => encode_colors(image, None, format, &display.into()),
    }
}

/// The content of a file of a layered picture. EXR holds all layers; PNG holds its colours and its opacity, other
/// formats its colours.
pub fn encode_layered(
    image: &LayeredImage,
    format: FileFormat,
    options: &FileOptions,
) -> Result<Vec<u8>, ImageIoError> {
    if format == FileFormat::Exr {
        if !options.exr_half && options.stored == StoredColors::Rgb {
            return exr::encode_exr(image, options.exr_compression);
        }
        let mut image = image.clone();
        image.convert_colors(options.stored);
        if options.exr_half {
            image.store_colors_as_half();
        }
        return exr::encode_exr(&image, options.exr_compression);
    }
    let colors = image.layer("").ok_or(ImageIoError::NoColors)?;
    if format == FileFormat::Pfm && options.stored != StoredColors::Rgb {
        return Ok(encode_pfm(&colors, options.stored));
    }
    encode_colors(&colors, image.alpha().as_deref(), format, options)
}

/// The content of a file of a format other than EXR. The picture must be complete.
fn encode_colors(
    image: &ImageRgb,
    alpha: Option<&[f32]>,
    format: FileFormat,
    options: &FileOptions,
) -> Result<Vec<u8>, ImageIoError> {
    let (width, height) = (image.width, image.height);
    match format {
        FileFormat::Exr => unreachable!("EXR is written by `encode_exr`"),
        FileFormat::Hdr => {
            let storable = image
                .pixels
                .iter()
                .map(|&pixel| image::Rgb(nearest_in_rgbe(pixel).to_array()));
            let mut bytes = Vec::new();
            HdrEncoder::new(&mut bytes).encode(&storable.collect::<Vec<_>>(), width as usize, height as usize)?;
            Ok(bytes)
        }
        FileFormat::Pfm => Ok(encode_pfm(image, StoredColors::Rgb)),
        FileFormat::Png => displayed::encode_png(image, alpha, options),
        FileFormat::Jpeg => displayed::encode_jpeg(image, options),
    }
}

/// Rows go from the bottom up; a negative scale means little-endian (Debevec, "PFM: Portable FloatMap").
fn encode_pfm(image: &ImageRgb, stored: StoredColors) -> Vec<u8> {
    let (magic, channels) = match stored {
        StoredColors::Luminance => ("Pf", 1),
        StoredColors::Rgb | StoredColors::Xyz => ("PF", 3),
    };
    let mut bytes = format!("{magic}\n{} {}\n-1.0\n", image.width, image.height).into_bytes();
    for row in image.pixels.rchunks_exact(image.width as usize) {
        let numbers = row
            .iter()
            .flat_map(|&pixel| stored.of(pixel).to_array().into_iter().take(channels));
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
    }
    bytes
}

/// The nearest colour that RGBE stores: the encoder truncates mantissas, which would darken the picture by half a unit
/// of eight bits. Negative and NaN components become 0, and values beyond the exponents of the format become the
/// largest colour, or black.
fn nearest_in_rgbe(color: Rgb) -> Rgb {
    const LARGEST: f32 = 1e38;
    /// Below it the format stores black (Ward, "Real pixels", in Graphics Gems II).
    const SMALLEST: f32 = 1e-32;
    let color = Rgb::from_array(color.to_array().map(|x| if x > 0.0 { x.min(LARGEST) } else { 0.0 }));
    let largest = color.max_element();
    if largest < SMALLEST {
        return Rgb::ZERO;
    }
    // The largest component has a mantissa of 128 to 255 units, where a unit is 2^-7 of the largest power of two in it.
    let unit_of = |x: f32| f32::from_bits(x.to_bits() & !0x007f_ffff) / 128.0;
    // 255.5 units become 256, which carries into the exponent: the units of the others are then twice as large.
    let carried = (largest / unit_of(largest)).round() * unit_of(largest);
    let unit = unit_of(carried);
    (color / unit).round() * unit
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ImageIoError> {
    write_atomically(path, bytes).map_err(|source| ImageIoError::Write {
        path: path.to_path_buf(),
        source,
    })
}

/// A picture from a file.
#[derive(Clone, Debug)]
pub struct LoadedPicture {
    /// The linear colours, with the layers of an EXR file. The channel of a grey picture is `Y`.
    pub image: LayeredImage,
    /// Whether the file holds what a display shows, in place of radiance.
    pub is_displayed: bool,
}

/// Reads a picture in any of the formats that textures may have, and of EXR files all channels.
pub fn load_picture(bytes: &[u8]) -> Result<LoadedPicture, ImageFileError> {
    if is_exr(bytes) {
        return Ok(LoadedPicture {
            image: decode_exr(bytes)?,
            is_displayed: false,
        });
    }
    let picture = load_image(bytes)?;
    let (width, height) = (picture.width(), picture.height());
    let bytes = u64::from(width) * u64::from(height) * size_of::<Rgb>() as u64;
    let memory = memory::reserve(bytes).map_err(|shortage| ImageFileError::Memory {
        width: width.into(),
        height: height.into(),
        shortage,
    })?;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels: Vec<_> = places.map(|(x, y)| picture.pixel(x, y)).collect();
    let mut image = LayeredImage::new(width, height);
    match picture.channels() {
        1 => image.add_float("Y", pixels.iter().map(|pixel| pixel.x).collect()),
        _ => image.add_rgb("", &pixels),
    }
    image.memory = memory.into();
    Ok(LoadedPicture {
        image,
        is_displayed: picture.transfer() == Transfer::Srgb,
    })
}

#[cfg(test)]
mod tests;
