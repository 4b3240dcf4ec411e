//! Pictures.

use sunroom_core::photometry;
use sunroom_core::render::image_io::{FileFormat, FileOptions, encode_layered, load_picture};
use sunroom_core::texture::load_image;

use super::{beginning_with, crc};

/// The beginning of a PNG file.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// The beginning of an EXR file.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// A PNG picture, with the checksums that its chunks should have: hardly any mutation would get past them.
pub fn png(bytes: &[u8]) {
    let mut file = beginning_with(PNG, bytes);
    let mut at = PNG.len();
    while let Some(length) = file.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
        let end = (at + 8).saturating_add(u32::from_be_bytes(*length) as usize);
        let Some(covered) = file.get(at + 4..end) else { break };
        let sum = crc(covered);
        let Some(place) = file.get_mut(end..end + 4) else { break };
        place.copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
    picture(&file);
}

pub fn jpeg(bytes: &[u8]) {
    picture(&beginning_with(b"\xff\xd8\xff", bytes));
}

pub fn bmp(bytes: &[u8]) {
    picture(&beginning_with(b"BM", bytes));
}

/// A TGA picture: the format has no beginning of its own.
pub fn tga(bytes: &[u8]) {
    picture(bytes);
}

pub fn pnm(bytes: &[u8]) {
    picture(&beginning_with(b"P", bytes));
}

pub fn hdr(bytes: &[u8]) {
    picture(&beginning_with(b"#?", bytes));
}

pub fn exr(bytes: &[u8]) {
    picture(&beginning_with(&EXR, bytes));
}

/// An EXR file with all channels that it has, of all parts. Those of each layer have a sample for each pixel, and are
/// there again after they were written. Returns whether they were.
pub fn layered(bytes: &[u8]) -> bool {
    let picture = match load_picture(&beginning_with(&EXR, bytes)) {
        Ok(picture) => picture,
        Err(error) => {
            let _ = error.to_string();
            return false;
        }
    };
    let image = picture.image;
    let pixels = u64::from(image.width) * u64::from(image.height);
    assert!(pixels > 0);
    let layers = image.layers();
    for layer in &layers {
        let channels = image.channels_of(layer).unwrap_or_default();
        assert!(channels.iter().all(|channel| channel.samples.len() as u64 == pixels));
    }
    let is_small = pixels <= 1 << 12;
    if is_small {
        let written = encode_layered(&image, FileFormat::Exr, &FileOptions::default());
        let again = written.map(|written| load_picture(&written).expect("it was just written").image);
        assert!(again.is_ok_and(|again| again.layers().len() == layers.len()));
    }
    is_small && !layers.is_empty()
}

pub fn pfm(bytes: &[u8]) {
    let kind = if bytes.get(1) == Some(&b'f') { b"Pf" } else { b"PF" };
    picture(&beginning_with(kind, bytes));
}

/// The intensities of a lamp: no picture has a negative one, and the flux is that of the picture.
pub fn photometry(bytes: &[u8]) {
    if !photometry::is_profile(bytes) {
        return;
    }
    let picture = match photometry::read_profile(bytes) {
        Ok(distribution) => distribution.picture(),
        Err(error) => {
            let lines = bytes.split(|byte| *byte == b'\n').count();
            assert!((1..=lines).contains(&error.line), "{error}");
            return;
        }
    };
    assert_eq!(picture.candela.len(), picture.width as usize * picture.height as usize);
    assert!(picture.candela.iter().all(|candela| *candela >= 0.0));
    assert!(picture.lumens() >= 0.0);
    self::picture(bytes);
}

fn picture(bytes: &[u8]) {
    let image = match load_image(bytes) {
        Ok(image) => image,
        Err(error) => {
            let _ = error.to_string();
            return;
        }
    };
    let (width, height) = (image.width(), image.height());
    assert!(width > 0 && height > 0);
    assert!(matches!(image.channels(), 1 | 3));
    for (x, y) in [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)] {
        assert!(image.pixel(x, y).is_finite());
    }
    if u64::from(width) * u64::from(height) <= 1 << 14 {
        assert!(image.mean(false).is_finite() && image.mean(true).is_finite());
    }
}
