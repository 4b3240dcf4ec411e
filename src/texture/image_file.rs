//! Bytes of a file -> [`Image`]: PNG, JPEG, BMP, TGA, PPM and PGM (encoded for displays), EXR, Radiance HDR and PFM (linear). The
//! content decides which it is, never the name.
//!
//! What a header promises is weighed against the length of the file before memory is taken for it.

use std::io::Cursor;

use ::image::codecs::hdr::HdrDecoder;
use ::image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use thiserror::Error;

use super::image::{ENVIRONMENT_BYTES, Image, Samples, Transfer};
use super::{exr_file, jpeg_file, pfm_file};
use crate::memory::{self, Reservation, Shortage};

/// Why bytes are no picture. The file's name is the caller's to add.
#[derive(Debug, Error)]
pub enum ImageFileError {
    #[error("not a picture in a known format: PNG, JPEG, BMP, TGA, PPM, EXR, HDR or PFM")]
    UnknownFormat,
    #[error("pictures in the format {0} are not read; save it as PNG, JPEG, HDR or EXR")]
    UnsupportedFormat(String),
    #[error("a picture of {width} x {height} pixels is promised, which is more than a file of {bytes} bytes can hold")]
    TooLarge { width: u64, height: u64, bytes: usize },
    #[error("{width} x {height} pixels need {shortage}")]
    Memory {
        width: u64,
        height: u64,
        shortage: Shortage,
    },
    #[error("the picture has no pixels")]
    Empty,
    #[error("the picture is damaged: {0}")]
    Damaged(String),
    #[error("the EXR picture has no channels R, G, B, nor Y, and more than one: {0}")]
    Channels(String),
    #[error("{0}; save the EXR picture with ZIP compression and full resolution, without depth samples")]
    UnsupportedExr(String),
}

/// No format packs more bytes of a picture into one: DWAB needs two bytes for a constant block of 64 halves, and deflate packs 1032
/// of those into one.
const MOST_PER_BYTE: u64 = 64 * 1032;

/// Reads a whole file.
pub fn load_image(bytes: &[u8]) -> Result<Image, ImageFileError> {
    if bytes.starts_with(&exr_file::MAGIC) {
        return exr_file::load_exr(bytes);
    }
    if bytes.starts_with(b"PF") || bytes.starts_with(b"Pf") {
        return pfm_file::load_pfm(bytes);
    }
    if bytes.starts_with(b"#?") {
        // Strict would be to insist on `#?RADIANCE`, where many write `#?RGBE`.
        return decode(
            HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(damaged)?,
            bytes.len(),
        );
    }
    let format = match ::image::guess_format(bytes) {
        Ok(format) => format,
        Err(_) if may_be_tga(bytes) => ImageFormat::Tga,
        Err(_) => return Err(ImageFileError::UnknownFormat),
    };
    if !format.reading_enabled() {
        let name = format.extensions_str().first().copied().unwrap_or("?");
        return Err(ImageFileError::UnsupportedFormat(name.to_uppercase()));
    }
    decode(limited_decoder(bytes, format)?, bytes.len())
}

/// Decodes a whole file of this format, one of those with integers. What is reserved with it are its samples and `more_bytes` for each pixel.
pub fn decode_picture(
    bytes: &[u8],
    format: ImageFormat,
    more_bytes: u64,
) -> Result<(DynamicImage, Reservation), ImageFileError> {
    decode_reserved(limited_decoder(bytes, format)?, bytes.len(), more_bytes)
}

/// A decoder that takes no more memory for itself than the whole budget.
fn limited_decoder(bytes: &[u8], format: ImageFormat) -> Result<impl ImageDecoder, ImageFileError> {
    if format == ImageFormat::Jpeg && !jpeg_file::is_whole(bytes) {
        return Err(ImageFileError::Damaged(
            "the JPEG file ends before its picture does".to_owned(),
        ));
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(memory::budget().limit());
    reader.limits(limits);
    reader.into_decoder().map_err(damaged)
}

fn decode(decoder: impl ImageDecoder, file_bytes: usize) -> Result<Image, ImageFileError> {
    let has_floats = matches!(decoder.color_type(), ColorType::Rgb32F | ColorType::Rgba32F);
    let environment = if has_floats { ENVIRONMENT_BYTES } else { 0 };
    let (picture, memory) = decode_reserved(decoder, file_bytes, environment)?;
    hold(without_alpha(picture)?, memory)
}

fn decode_reserved(
    decoder: impl ImageDecoder,
    file_bytes: usize,
    more_bytes: u64,
) -> Result<(DynamicImage, Reservation), ImageFileError> {
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    let size = Promise {
        width: width.into(),
        height: height.into(),
        decoded_bytes: decoder.total_bytes(),
        memory_bytes: decoder.total_bytes().saturating_add(more_bytes.saturating_mul(pixels)),
    };
    let memory = size.reserve(file_bytes)?;
    Ok((DynamicImage::from_decoder(decoder).map_err(damaged)?, memory))
}

fn damaged(error: ::image::ImageError) -> ImageFileError {
    ImageFileError::Damaged(error.to_string())
}

/// What the header of a picture promises.
pub(super) struct Promise {
    /// In pixels.
    pub width: u64,
    pub height: u64,
    /// Bytes that the file must hold, before compression.
    pub decoded_bytes: u64,
    /// Bytes of memory that decoding takes at most, and the picture afterwards.
    pub memory_bytes: u64,
}

impl Promise {
    /// Refuses what cannot come from so short a file, and what does not fit into the budget.
    pub fn reserve(&self, file_bytes: usize) -> Result<Reservation, ImageFileError> {
        let (width, height) = (self.width, self.height);
        if width == 0 || height == 0 {
            return Err(ImageFileError::Empty);
        }
        if self.decoded_bytes > MOST_PER_BYTE.saturating_mul(file_bytes as u64) {
            return Err(ImageFileError::TooLarge {
                width,
                height,
                bytes: file_bytes,
            });
        }
        memory::reserve(self.memory_bytes).map_err(|shortage| ImageFileError::Memory {
            width,
            height,
            shortage,
        })
    }
}

/// The picture with what is reserved for it, from now on only for the samples that are left.
pub(super) fn hold(image: Image, mut memory: Reservation) -> Result<Image, ImageFileError> {
    let bytes = image.memory_bytes().min(memory.bytes());
    memory.resize(bytes).map_err(|shortage| ImageFileError::Memory {
        width: image.width().into(),
        height: image.height().into(),
        shortage,
    })?;
    Ok(image.holding(memory))
}

/// TGA begins with no magic number: whether the first 18 bytes make sense as its header.
fn may_be_tga(bytes: &[u8]) -> bool {
    let Some(header) = bytes.first_chunk::<18>() else {
        return false;
    };
    let has_map = header[1];
    match header[2] {
        1 | 9 => has_map == 1 && matches!(header[7], 15 | 16 | 24 | 32) && header[16] == 8,
        2 | 10 => has_map <= 1 && matches!(header[16], 15 | 16 | 24 | 32),
        3 | 11 => has_map == 0 && matches!(header[16], 8 | 16),
        _ => false,
    }
}

fn without_alpha(picture: DynamicImage) -> Result<Image, ImageFileError> {
    let (width, height) = (picture.width(), picture.height());
    let (channels, samples, transfer) = match picture {
        DynamicImage::ImageLuma8(grey) => (1, Samples::U8(grey.into_raw()), Transfer::Srgb),
        DynamicImage::ImageLumaA8(grey) => (1, Samples::U8(every(2, 1, grey.into_raw())), Transfer::Srgb),
        DynamicImage::ImageRgb8(rgb) => (3, Samples::U8(rgb.into_raw()), Transfer::Srgb),
        DynamicImage::ImageRgba8(rgb) => (3, Samples::U8(every(4, 3, rgb.into_raw())), Transfer::Srgb),
        DynamicImage::ImageLuma16(grey) => (1, Samples::U16(grey.into_raw()), Transfer::Srgb),
        DynamicImage::ImageLumaA16(grey) => (1, Samples::U16(every(2, 1, grey.into_raw())), Transfer::Srgb),
        DynamicImage::ImageRgb16(rgb) => (3, Samples::U16(rgb.into_raw()), Transfer::Srgb),
        DynamicImage::ImageRgba16(rgb) => (3, Samples::U16(every(4, 3, rgb.into_raw())), Transfer::Srgb),
        floats => (3, Samples::F32(floats.into_rgb32f().into_raw()), Transfer::Linear),
    };
    Image::new(width, height, channels, samples, transfer).ok_or(ImageFileError::Empty)
}

/// The first `keep` of every `stride` samples.
fn every<T: Copy>(stride: usize, keep: usize, mut samples: Vec<T>) -> Vec<T> {
    let pixels = samples.len() / stride;
    for pixel in 0..pixels {
        samples.copy_within(stride * pixel..stride * pixel + keep, keep * pixel);
    }
    samples.truncate(keep * pixels);
    samples.shrink_to_fit();
    samples
}
