//! PNG and JPEG files, which hold displayed pictures.

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::{FileOptions, ImageIoError, ImageRgb};
use crate::color::Rgb;

pub(super) fn encode_png(
    image: &ImageRgb,
    alpha: Option<&[f32]>,
    options: &FileOptions,
) -> Result<Vec<u8>, ImageIoError> {
    let encoder = options.display.encoder();
    let mut bytes = Vec::new();
    let png = PngEncoder::new(&mut bytes);
    let (width, height) = (image.width, image.height);
    // The colours of PNG files are not premultiplied by alpha (PNG specification, section 6.2).
    let straight = |i: usize| match alpha {
        Some(alpha) if alpha[i] > 0.0 && alpha[i] < 1.0 => image.pixels[i] / alpha[i],
        _ => image.pixels[i],
    };
    let pixels = || (0..image.pixels.len()).map(straight).collect::<Vec<Rgb>>();
    let mut place = 0..;
    let opacity = |i: usize| alpha.map_or(1.0, |alpha| alpha[i].clamp(0.0, 1.0));
    if options.png_16_bits {
        let mut samples: Vec<u16> = Vec::new();
        encoder.encode_each_16(&pixels(), |color| {
            samples.extend(color);
            let opacity = place.next().map(opacity).filter(|_| alpha.is_some());
            samples.extend(opacity.map(|opacity| (opacity * 65_535.0 + 0.5) as u16));
        });
        let color_type = match alpha {
            Some(_) => ExtendedColorType::Rgba16,
            None => ExtendedColorType::Rgb16,
        };
        // The encoder converts the byte order of samples to that of the file.
        png.write_image(bytemuck::cast_slice(&samples), width, height, color_type)?;
        return Ok(bytes);
    }
    let Some(_) = alpha else {
        return png_of_bytes([width, height], &options.display.encode_rgb(&image.pixels));
    };
    let mut samples: Vec<u8> = Vec::new();
    encoder.encode_each(&pixels(), |color| {
        samples.extend(color);
        samples.extend(place.next().map(|place| (opacity(place) * 255.0 + 0.5) as u8));
    });
    png.write_image(&samples, width, height, ExtendedColorType::Rgba8)?;
    Ok(bytes)
}

pub(super) fn encode_jpeg(image: &ImageRgb, options: &FileOptions) -> Result<Vec<u8>, ImageIoError> {
    let rgb = options.display.encode_rgb(&image.pixels);
    jpeg_of_bytes([image.width, image.height], &rgb, options.jpeg_quality)
}

/// PNG from three bytes per pixel.
pub(super) fn png_of_bytes([width, height]: [u32; 2], rgb: &[u8]) -> Result<Vec<u8>, ImageIoError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(rgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}

/// JPEG from three bytes per pixel.
pub(super) fn jpeg_of_bytes([width, height]: [u32; 2], rgb: &[u8], quality: u8) -> Result<Vec<u8>, ImageIoError> {
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, quality.clamp(1, 100));
    encoder.write_image(rgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}
