//! Reads OpenEXR pictures: half or single floats, of the channels that make a colour.
//!
//! Names count after a prefix, by which renderers name layers (`ViewLayer.Combined.R`). The reader chooses R, G, B of
//! one part with all three, else of several parts with one each, else Y, else the channel of a part that has no other;
//! names without a prefix come before those with one, and a colour has one prefix.
//!
//! The display window is the picture: it is black outside of the data window, and data outside of it are dropped, as in
//! OpenEXR's own viewer. Where the two do not overlap, the data window is the picture. Colours of other primaries
//! become those of Rec. 709 ([`super::exr_color`]).

use std::collections::HashMap;
use std::io::Cursor;

use exr::meta::MetaData;
use exr::prelude::*;

use super::exr_color::to_rec709;
use super::image::{ENVIRONMENT_BYTES, Image, Samples, Transfer};
use super::image_header::{ImageFileError, PromisedSize, hold};
use crate::memory::Reservation;

const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Whether these are the first bytes of an EXR file.
pub(crate) fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

pub(super) fn load_exr(bytes: &[u8]) -> std::result::Result<Image, ImageFileError> {
    // The colour of one layer is copied while all layers are still in memory.
    let mut memory = reserve_exr(bytes, |_| COLOR_BYTES + ENVIRONMENT_BYTES)?;
    let file = read_exr_parts(bytes)?;
    let channels = channels_of(&file);
    let Some(color) = color_of(&channels) else {
        let names: Vec<String> = channels.iter().map(|channel| format!("`{}`", channel.name)).collect();
        return Err(ImageFileError::Channels(names.join(", ")));
    };
    let data = color[0].window;
    let display = Window::of_file(&file);
    let frame = if display.meets(&data) { display } else { data };
    let (width, height) = (frame.size[0], frame.size[1]);
    let too_large = |shortage| ImageFileError::Memory {
        width: width as u64,
        height: height as u64,
        shortage,
    };
    if frame != data {
        let pixels = frame.pixels();
        if pixels > MOST_AROUND.max(data.pixels().saturating_mul(MOST_FOR_EACH)) {
            let what = format!(
                "its display window has {width} x {height} pixels, and only {} have data",
                data.pixels()
            );
            return Err(ImageFileError::Damaged(what));
        }
        let more = pixels.saturating_mul(COLOR_BYTES + ENVIRONMENT_BYTES);
        memory.resize(memory.bytes().saturating_add(more)).map_err(too_large)?;
    }
    let mut samples = interleave(&color, &data, &frame);
    if let (3, Some(primaries)) = (color.len(), &file.attributes.chromaticities) {
        samples = to_rec709(samples, primaries);
    }
    let image = Image::new(width as u32, height as u32, color.len(), samples, Transfer::Linear);
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

/// Reserves the memory that the headers declare before pixels are read, and further bytes for each pixel of a part, by
/// its number of channels. An error for kinds of files that are not supported.
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

/// The most pixels of a display window beyond the data, in all and per pixel with data; the larger limit counts. A
/// large window takes no bytes of a file.
const MOST_AROUND: u64 = 1 << 24;
const MOST_FOR_EACH: u64 = 4096;

/// Bytes per pixel of a colour of floats.
const COLOR_BYTES: u64 = 12;

fn refused(error: Error) -> ImageFileError {
    match error {
        Error::NotSupported(what) => ImageFileError::UnsupportedExr(what.into_owned()),
        other => ImageFileError::Damaged(other.to_string()),
    }
}

/// A rectangle of pixels: its upper left corner, its width and height.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Window {
    first: [i64; 2],
    size: [usize; 2],
}

impl Window {
    fn of_file(file: &FlatImage) -> Self {
        let IntegerBounds { position, size } = file.attributes.display_window;
        Self::new(position, size)
    }

    fn new(Vec2(x, y): Vec2<i32>, Vec2(width, height): Vec2<usize>) -> Self {
        Self {
            first: [x.into(), y.into()],
            size: [width, height],
        }
    }

    fn pixels(&self) -> u64 {
        (self.size[0] as u64).saturating_mul(self.size[1] as u64)
    }

    fn meets(&self, other: &Self) -> bool {
        (0..2).all(|axis| {
            let end = |window: &Self| window.first[axis] + window.size[axis] as i64;
            self.first[axis].max(other.first[axis]) < end(self).min(end(other))
        })
    }
}

/// A channel of a part.
struct PartChannel<'a> {
    part: usize,
    /// Whether the part has no other channel.
    is_only: bool,
    /// The full name.
    name: String,
    /// The name after the last dot, and the prefix before it.
    last: String,
    prefix: String,
    /// The prefix, or else that of the part's name.
    group: String,
    window: Window,
    samples: &'a FlatSamples,
}

fn channels_of(file: &FlatImage) -> Vec<PartChannel<'_>> {
    let mut channels = Vec::new();
    for (part, layer) in file.layer_data.iter().enumerate() {
        let list = &layer.channel_data.list;
        let of_part = layer.attributes.layer_name.as_ref().map(Text::to_string);
        let of_part = of_part.as_deref().and_then(|name| name.rsplit_once('.'));
        channels.extend(list.iter().map(|channel| {
            let name = channel.name.to_string();
            let (prefix, last) = name.rsplit_once('.').unwrap_or(("", &name));
            let group = if prefix.is_empty() {
                of_part.map_or("", |parts| parts.0)
            } else {
                prefix
            };
            PartChannel {
                part,
                is_only: list.len() == 1,
                last: last.to_owned(),
                prefix: prefix.to_owned(),
                group: group.to_owned(),
                name,
                window: Window::new(layer.attributes.layer_position, layer.size),
                samples: &channel.sample_data,
            }
        }));
    }
    channels
}

/// The channels of the colour, three or one, all with the same window.
fn color_of<'a, 'b>(channels: &'a [PartChannel<'b>]) -> Option<Vec<&'a PartChannel<'b>>> {
    let grey = || {
        let greys = channels.iter().filter(|channel| channel.last.eq_ignore_ascii_case("Y"));
        greys.min_by_key(|channel| !channel.prefix.is_empty())
    };
    let only = || channels.iter().find(|channel| channel.is_only);
    rgb(channels, |channel| (channel.part, &channel.prefix))
        .or_else(|| rgb(channels, |channel| (0, &channel.group)))
        .or_else(|| grey().or_else(only).map(|channel| vec![channel]))
}

/// R, G and B with the same window and group, each of which has a number and a name. Groups without a name come first,
/// then in the order of the file.
fn rgb<'a, 'b>(
    channels: &'a [PartChannel<'b>],
    group: impl Fn(&'a PartChannel<'b>) -> (usize, &'a String),
) -> Option<Vec<&'a PartChannel<'b>>> {
    let mut groups: HashMap<_, [Option<&PartChannel>; 3]> = HashMap::new();
    let mut order = Vec::new();
    for channel in channels {
        let group = group(channel);
        let found = groups.entry(group).or_insert_with(|| {
            order.push(group);
            [None; 3]
        });
        if let Some(place) = ["R", "G", "B"]
            .iter()
            .position(|name| channel.last.eq_ignore_ascii_case(name))
        {
            found[place].get_or_insert(channel);
        }
    }
    // The sort is stable.
    order.sort_by_key(|(_, name)| !name.is_empty());
    order.iter().find_map(|group| {
        let [r, g, b] = groups[group];
        let color = vec![r?, g?, b?];
        let is_aligned = color.iter().all(|channel| channel.window == color[0].window);
        is_aligned.then_some(color)
    })
}

/// Interleaves the channels for each pixel of the frame; zero outside of their window. The samples are halves if all
/// channels are, else floats.
fn interleave(channels: &[&PartChannel], data: &Window, frame: &Window) -> Samples {
    let halves: Option<Vec<&[f16]>> = channels
        .iter()
        .map(|channel| match channel.samples {
            FlatSamples::F16(halves) => Some(halves.as_slice()),
            _ => None,
        })
        .collect();
    match halves {
        Some(halves) => {
            let pixel = |i: Option<usize>| halves.iter().map(move |half| i.map_or(f16::ZERO, |i| half[i]));
            Samples::F16(places(data, frame).flat_map(pixel).collect())
        }
        None => {
            let pixel = |i: Option<usize>| channels.iter().map(move |c| i.map_or(0.0, |i| number(c.samples, i)));
            Samples::F32(places(data, frame).flat_map(pixel).collect())
        }
    }
}

/// The index into the data for each pixel of a frame; None outside of the data.
fn places(data: &Window, frame: &Window) -> impl Iterator<Item = Option<usize>> {
    let [width, height] = data.size;
    let [dx, dy] = [0, 1].map(|axis| frame.first[axis] - data.first[axis]);
    let within = |at: i64, size: usize| usize::try_from(at).ok().filter(|&at| at < size);
    let columns = frame.size[0];
    (0..frame.size[1]).flat_map(move |y| {
        let row = within(y as i64 + dy, height);
        (0..columns).map(move |x| Some(row? * width + within(x as i64 + dx, width)?))
    })
}

fn number(samples: &FlatSamples, i: usize) -> f32 {
    match samples {
        FlatSamples::F16(halves) => halves[i].to_f32(),
        FlatSamples::F32(floats) => floats[i],
        // Whole numbers stand for [0, 1], as in other picture files.
        FlatSamples::U32(numbers) => (f64::from(numbers[i]) / f64::from(u32::MAX)) as f32,
    }
}
