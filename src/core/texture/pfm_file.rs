//! Reads portable float maps: one or three channels of 32-bit floats, rows from the bottom up (Debevec, "PFM: Portable
//! FloatMap").

use super::image::{ENVIRONMENT_BYTES, Image, Samples, Transfer};
use super::image_header::{ImageFileError, PromisedSize, hold};

/// Reads a file that begins with `PF` (colour) or `Pf` (grey). The scale's sign gives the byte order; its magnitude
/// multiplies the samples, as in Mitsuba.
pub(super) fn load_pfm(bytes: &[u8]) -> Result<Image, ImageFileError> {
    let damaged = |what: &str| ImageFileError::Damaged(what.to_owned());
    let channels = if bytes.starts_with(b"PF") { 3 } else { 1 };
    let mut rest = &bytes[2..];
    let mut word = || {
        rest = rest.trim_ascii_start();
        let length = rest.iter().position(u8::is_ascii_whitespace)?;
        let word = std::str::from_utf8(&rest[..length]).ok()?;
        rest = &rest[length..];
        Some(word)
    };
    let mut size = || word()?.parse::<u32>().ok();
    let (Some(width), Some(height)) = (size(), size()) else {
        return Err(damaged("no width and height follow `PF`"));
    };
    let scale = word()
        .and_then(|text| text.parse::<f32>().ok())
        .filter(|scale| scale.is_finite() && *scale != 0.0)
        .ok_or_else(|| damaged("no scale follows width and height"))?;
    // A single blank separates the header from the samples.
    let body = rest.get(1..).unwrap_or_default();
    let row = u64::from(width) * channels as u64 * 4;
    let wanted = row.saturating_mul(height.into());
    let pixels = u64::from(width) * u64::from(height);
    let promise = PromisedSize {
        width: width.into(),
        height: height.into(),
        decoded_bytes: wanted,
        memory_bytes: wanted.saturating_add(pixels.saturating_mul(ENVIRONMENT_BYTES)),
    };
    let memory = promise.reserve(bytes.len())?;
    if (body.len() as u64) < wanted {
        return Err(damaged("the file ends before the last pixel"));
    }
    let number = |bytes: &[u8; 4]| {
        let number = match scale < 0.0 {
            true => f32::from_le_bytes(*bytes),
            false => f32::from_be_bytes(*bytes),
        };
        number * scale.abs()
    };
    let rows = body[..wanted as usize].rchunks_exact(row as usize);
    let samples = rows.flat_map(|row| row.as_chunks::<4>().0).map(number).collect();
    let image = Image::new(width, height, channels, Samples::F32(samples), Transfer::Linear);
    hold(image.ok_or(ImageFileError::Empty)?, memory)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;

    #[test]
    fn rows_come_bottom_up_in_both_byte_orders() {
        let samples = [0.25f32, 1e20, -1.0, 7.0];
        let little: Vec<u8> = samples.iter().flat_map(|sample| sample.to_le_bytes()).collect();
        let big: Vec<u8> = samples.iter().flat_map(|sample| sample.to_be_bytes()).collect();
        for (header, body, scale) in [("Pf\n2 2\n-1.0\n", little, 1.0), ("Pf 2\n2\n 2 ", big, 2.0)] {
            let image = load_pfm(&[header.as_bytes(), &body].concat()).unwrap();
            assert_eq!((image.width(), image.height(), image.channels()), (2, 2, 1));
            assert_eq!(image.pixel(0, 1), Rgb::splat(0.25 * scale));
            assert_eq!(image.pixel(1, 1), Rgb::splat(1e20 * scale));
            assert_eq!(image.pixel(0, 0), Rgb::splat(-scale));
        }
    }

    #[test]
    fn broken_files_are_refused() {
        for text in [
            "PF",
            "PF\n",
            "PF\n1 1\n",
            "PF\n1 1\n0\n0123456789ab",
            "PF\n1 1\nnan\n0123456789ab",
            "PF\n0 1\n1\n0123456789ab",
            "PF\n1 1\n1\n0123456789a",
            "PF\n-1 1\n1\n0123456789ab",
            "PF\n4294967295 4294967295\n1\n0123456789ab",
        ] {
            load_pfm(text.as_bytes()).unwrap_err();
        }
        load_pfm(b"PF\n1 1\n1\n0123456789ab").unwrap();
    }
}
