//! Reads OpenEXR pictures: half or single floats, of the channels that make a colour.
//!
//! Names count after a prefix: renderers name layers so (`ViewLayer.Combined.R`). Chosen are R, G, B, else Y, else a channel that is the only
//! one; names without a prefix come before those with one, and a colour has one prefix. The data window is the picture, as in Mitsuba.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::prelude::*;

use super::image::{ENVIRONMENT_BYTES, Image, Samples, Transfer};
use super::image_header::{ImageFileError, PromisedSize, hold};
use crate::memory::Reservation;

const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Whether these are the first bytes of an EXR file.
pub(crate) fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

pub(super) fn load_exr(bytes: &[u8]) -> std::result::Result<Image, ImageFileError> {
    // The colour of one layer is taken out while all layers are still there.
    let memory = reserve_exr(bytes, |_| COLOR_BYTES + ENVIRONMENT_BYTES)?;
    let file = read_exr_parts(bytes)?;
    let found = file
        .layer_data
        .iter()
        .find_map(|layer| color_channels(&layer.channel_data.list).map(|color| (layer.size, color)));
    let Some((size, color)) = found else {
        let channels = file.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
        let names: Vec<String> = channels.map(|channel| format!("`{}`", channel.name)).collect();
        return Err(ImageFileError::Channels(names.join(", ")));
    };
    let samples = match color {
        Color::Rgb(channels) => interleave(&channels),
        Color::Grey(channel) => interleave(&[channel]),
    };
    let channels = if matches!(color, Color::Grey(_)) { 1 } else { 3 };
    let (width, height) = (size.width() as u32, size.height() as u32);
    let image = Image::new(width, height, channels, samples, Transfer::Linear);
    hold(image.ok_or(ImageFileError::Empty)?, memory)
}

/// All parts of a file with their channels, each at its full resolution.
pub(crate) fn read_exr_parts(bytes: &[u8]) -> std::result::Result<FlatImage, ImageFileError> {
    read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(refused)
}

/// Reserves, before pixels are read, what the headers promise, and so many more bytes for each pixel of a part, whose number of channels is given. An
/// error for files of kinds that are not read.
pub(crate) fn reserve_exr(
    bytes: &[u8],
    more_bytes: impl Fn(usize) -> u64,
) -> std::result::Result<Reservation, ImageFileError> {
    let mut all = PromisedSize {
        width: 0,
        height: 0,
        decoded_bytes: 0,
        memory_bytes: 0,
    };
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(refused)?;
    for header in &meta.headers {
        if header.deep {
            return Err(ImageFileError::UnsupportedExr("deep pictures are not read".into()));
        }
        if let Some(channel) = header.channels.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
            let what = format!("the channel `{}` has fewer samples than pixels", channel.name);
            return Err(ImageFileError::UnsupportedExr(what));
        }
        let Vec2(width, height) = header.layer_size;
        let (width, height) = (width as u64, height as u64);
        if width == 0 || height == 0 {
            return Err(ImageFileError::Empty);
        }
        let pixels = width.saturating_mul(height);
        let promised = pixels.saturating_mul(header.channels.bytes_per_pixel as u64);
        (all.width, all.height) = (all.width.max(width), all.height.max(height));
        all.decoded_bytes = all.decoded_bytes.saturating_add(promised);
        let more = pixels.saturating_mul(more_bytes(header.channels.list.len()));
        all.memory_bytes = all.memory_bytes.saturating_add(promised).saturating_add(more);
    }
    all.reserve(bytes.len())
}

/// Bytes per pixel of a colour of floats.
const COLOR_BYTES: u64 = 12;

fn refused(error: Error) -> ImageFileError {
    match error {
        Error::NotSupported(what) => ImageFileError::UnsupportedExr(what.into_owned()),
        other => ImageFileError::Damaged(other.to_string()),
    }
}

enum Color<'a> {
    Rgb([&'a FlatSamples; 3]),
    Grey(&'a FlatSamples),
}

fn color_channels(list: &[AnyChannel<FlatSamples>]) -> Option<Color<'_>> {
    let names: Vec<String> = list.iter().map(|channel| channel.name.to_string()).collect();
    let prefixes = names
        .iter()
        .map(|name| name.rsplit_once('.').map_or("", |parts| parts.0));
    let mut prefixes: Vec<&str> = prefixes.collect();
    // The sort is stable, so that those with a prefix stay in the order of the file.
    prefixes.sort_by_key(|prefix| !prefix.is_empty());
    prefixes.dedup();
    let channel = |prefix: &str, last: &str| {
        let is_wanted = |name: &&String| match name.rsplit_once('.') {
            Some((before, after)) => before == prefix && after.eq_ignore_ascii_case(last),
            None => prefix.is_empty() && name.eq_ignore_ascii_case(last),
        };
        let at = names.iter().position(|name| is_wanted(&name))?;
        Some(&list[at].sample_data)
    };
    let rgb = |prefix: &&str| {
        let [r, g, b] = ["R", "G", "B"].map(|name| channel(prefix, name));
        Some(Color::Rgb([r?, g?, b?]))
    };
    let grey = |prefix: &&str| channel(prefix, "Y").map(Color::Grey);
    let only = match list {
        [channel] => Some(Color::Grey(&channel.sample_data)),
        _ => None,
    };
    let mut each = prefixes.iter();
    each.clone().find_map(rgb).or_else(|| each.find_map(grey)).or(only)
}

/// Halves if all channels are, else floats.
fn interleave(channels: &[&FlatSamples]) -> Samples {
    let halves: Option<Vec<&[f16]>> = channels
        .iter()
        .map(|samples| match samples {
            FlatSamples::F16(halves) => Some(halves.as_slice()),
            _ => None,
        })
        .collect();
    match halves {
        Some(halves) => {
            let pixels = 0..halves[0].len();
            Samples::F16(
                pixels
                    .flat_map(|i| halves.iter().map(move |channel| channel[i]))
                    .collect(),
            )
        }
        None => {
            let pixels = 0..channels[0].len();
            Samples::F32(
                pixels
                    .flat_map(|i| channels.iter().map(move |c| number(c, i)))
                    .collect(),
            )
        }
    }
}

fn number(samples: &FlatSamples, i: usize) -> f32 {
    match samples {
        FlatSamples::F16(halves) => halves[i].to_f32(),
        FlatSamples::F32(floats) => floats[i],
        // Whole numbers stand for [0, 1], as in other picture files.
        FlatSamples::U32(numbers) => (f64::from(numbers[i]) / f64::from(u32::MAX)) as f32,
    }
}
