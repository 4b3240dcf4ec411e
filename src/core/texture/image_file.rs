//! Decodes the bytes of a file to an [`Image`]: PNG, JPEG, BMP, TGA, PPM and PGM (encoded for displays), EXR, Radiance
//! HDR and PFM (linear), and the intensities of lamps (IES, EULUMDAT). The content decides on the format, never the
//! name.

use std::io::Cursor;

use ::image::codecs::hdr::HdrDecoder;
use ::image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::image::{ENVIRONMENT_BYTES, Image, Samples, Transfer};
use super::image_header::{ImageFileError, PromisedSize, damaged, hold};
use super::{exr_file, jpeg_file, pfm_file, profile_file};
use crate::memory::{self, Reservation};
use crate::photometry;

/// Reads a whole file.
pub fn load_image(bytes: &[u8]) -> Result<Image, ImageFileError> {
    if exr_file::is_exr(bytes) {
        return exr_file::load_exr(bytes);
    }
    // The first line may be a name that begins as pictures do.
    if photometry::is_profile(bytes) {
        return profile_file::load_profile(bytes);
    }
    if bytes.starts_with(b"PF") || bytes.starts_with(b"Pf") {
        return pfm_file::load_pfm(bytes);
    }
    if bytes.starts_with(b"#?") {
        // A strict decoder would insist on `#?RADIANCE`, where many programs write `#?RGBE`.
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

/// Decodes a whole file of this format, one with integers. The memory reserved with it is that of its samples and
/// `more_bytes` for each pixel.
pub(crate) fn decode_picture(
    bytes: &[u8],
    format: ImageFormat,
    more_bytes: u64,
) -> Result<(DynamicImage, Reservation), ImageFileError> {
    decode_reserved(limited_decoder(bytes, format)?, bytes.len(), more_bytes)
}

/// The most bytes of memory of a PNG decoder beside the picture: for colour profiles, texts and rows.
const BESIDE_PNG: u64 = 64 << 20;

/// The most memory that a decoder may take for itself. The picture is reserved, unlike other data packed in a PNG file.
fn most_memory(bytes: &[u8], format: ImageFormat) -> u64 {
    let budget = memory::budget().limit();
    // The size is in the first chunk.
    let sides = bytes.get(16..24).filter(|_| format == ImageFormat::Png);
    let Some(sides) = sides.map(|sides| sides.as_chunks::<4>().0) else {
        return budget;
    };
    let pixels = sides
        .iter()
        .map(|&side| u64::from(u32::from_be_bytes(side)))
        .product::<u64>();
    pixels.saturating_mul(8).saturating_add(BESIDE_PNG).min(budget)
}

/// A decoder that takes no more memory for itself than [`most_memory`].
fn limited_decoder(bytes: &[u8], format: ImageFormat) -> Result<impl ImageDecoder, ImageFileError> {
    if format == ImageFormat::Jpeg && !jpeg_file::is_whole(bytes) {
        return Err(ImageFileError::Damaged(
            "the JPEG file ends before its picture does".to_owned(),
        ));
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(most_memory(bytes, format));
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
    let size = PromisedSize {
        width: width.into(),
        height: height.into(),
        decoded_bytes: decoder.total_bytes(),
        memory_bytes: decoder.total_bytes().saturating_add(more_bytes.saturating_mul(pixels)),
    };
    let memory = size.reserve(file_bytes)?;
    Ok((DynamicImage::from_decoder(decoder).map_err(damaged)?, memory))
}

/// Whether the first 18 bytes are a plausible TGA header; TGA has no magic number.
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

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::ZlibEncoder;

    use super::*;

    /// A PNG file of one pixel, with a colour profile of `length` zero bytes.
    fn with_profile(length: usize) -> Vec<u8> {
        let mut picture = Cursor::new(Vec::new());
        let pixel = DynamicImage::new_luma8(1, 1);
        pixel.write_to(&mut picture, ImageFormat::Png).expect("a picture");
        let mut profile = ZlibEncoder::new(b"iCCPzeros\0\0".to_vec(), Compression::fast());
        let zeros = vec![0; 1 << 20];
        for _ in 0..length >> 20 {
            profile.write_all(&zeros).expect("memory");
        }
        let chunk = profile.finish().expect("memory");
        let mut crc = flate2::Crc::new();
        crc.update(&chunk);
        // The profile goes after the signature and the first chunk.
        let (start, rest) = picture.get_ref().split_at(8 + 25);
        let size = (chunk.len() as u32 - 4).to_be_bytes();
        [start, &size, &chunk, &crc.sum().to_be_bytes(), rest].concat()
    }

    #[test]
    fn the_profile_of_a_picture_unpacks_to_little_memory() {
        for (length, is_kept) in [(1 << 20, true), (80 << 20, false)] {
            let bytes = with_profile(length);
            let mut decoder = limited_decoder(&bytes, ImageFormat::Png).expect("a picture");
            let profile = decoder.icc_profile().expect("it is read already");
            assert_eq!(profile.map(|profile| profile.len()), is_kept.then_some(length));
            assert_eq!(load_image(&bytes).expect("a picture").width(), 1);
        }
    }
}
