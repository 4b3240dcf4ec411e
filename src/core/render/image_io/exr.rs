//! Layered pictures to OpenEXR files and back: one part, all channels in it, each with its own precision.
//!
//! The crate `exr` encodes and decodes. Files of other programs with several parts are read as well; the names of the
//! parts then precede those of the channels.

use std::collections::HashSet;
use std::io::Cursor;
use std::path::Path;

use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::RoundingMode;
use exr::meta::attribute::{LevelMode, SampleType};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, IntegerBounds, Layer,
    LayerAttributes, LineOrder, Text, Vec2, WritableImage, f16,
};

use super::{ExrCompression, ImageIoError, write};
use crate::render::layered_image::{Attribute, Channel, LayeredImage, Samples, full_name, is_cryptomatte, split_name};
use crate::texture::{ImageFileError, read_exr_parts, reserve_exr};

/// The crate's compression method.
fn method_of(compression: ExrCompression) -> Compression {
    match compression {
        ExrCompression::None => Compression::Uncompressed,
        ExrCompression::Rle => Compression::RLE,
        ExrCompression::Zips => Compression::ZIP1,
        ExrCompression::Zip => Compression::ZIP16,
        ExrCompression::Piz => Compression::PIZ,
        ExrCompression::Pxr24 => Compression::PXR24,
        ExrCompression::B44 => Compression::B44,
        ExrCompression::B44a => Compression::B44A,
        // OpenEXR's own default level.
        ExrCompression::Dwaa => Compression::DWAA(Some(45.0)),
        ExrCompression::Dwab => Compression::DWAB(Some(45.0)),
    }
}

/// Writes a layered picture to an EXR file, see [`encode_exr`].
pub fn write_exr(path: &Path, image: &LayeredImage, compression: ExrCompression) -> Result<(), ImageIoError> {
    write(path, &encode_exr(image, compression)?)
}

/// The content of an EXR file. The same picture gives the same bytes. An error if the picture has no channels or
/// pixels, a channel's number of samples differs from the number of pixels, a name is invalid or occurs twice, or the
/// compression would damage a cryptomatte or a layer of data.
pub fn encode_exr(image: &LayeredImage, compression: ExrCompression) -> Result<Vec<u8>, ImageIoError> {
    check(image, compression)?;
    let width = image.width as usize;
    let rows = |channel| Rows { channel, width };
    let channels = image
        .channels
        .iter()
        .map(|channel| AnyChannel::new(text(&channel.name), rows(channel)));
    let encoding = Encoding {
        compression: method_of(compression),
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = Vec2(width, image.height as usize);
    let mut own = attributes(image);
    if let Some([x, y, ..]) = image.place {
        own.layer_position = Vec2(x as i32, y as i32);
    }
    let layer = Layer::new(size, own, encoding, AnyChannels::sort(channels.collect()));
    let mut bytes = Cursor::new(Vec::new());
    let mut file = exr::prelude::Image::from_layer(layer);
    if let Some([.., width, height]) = image.place {
        let whole = Vec2(width as usize, height as usize);
        file.attributes.display_window = IntegerBounds::from_dimensions(whole);
    }
    file.write()
        .to_buffered(&mut bytes)
        .map_err(|error| ImageIoError::Exr(error.to_string()))?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

fn check(image: &LayeredImage, compression: ExrCompression) -> Result<(), ImageIoError> {
    let (width, height) = (image.width, image.height);
    if image.channels.is_empty() || image.pixel_count() == 0 {
        return Err(ImageIoError::WrongSize {
            width,
            height,
            pixels: 0,
        });
    }
    let mut names: Vec<&str> = Vec::new();
    for Channel { name, samples } in &image.channels {
        let fault = |what: &str| {
            let (name, what) = (name.clone(), what.to_owned());
            Err(ImageIoError::Channel { name, what })
        };
        if samples.len() != image.pixel_count() {
            return fault(&format!("has {} samples for {width} x {height} pixels", samples.len()));
        }
        if name.is_empty() || name.len() > 255 || name.contains('\0') {
            return fault("has a name that is empty, longer than 255 bytes, or has a zero in it");
        }
        let (layer, last) = split_name(name);
        let is_taken_for_luminance = compression.takes_y_for_luminance()
            && !layer.is_empty()
            && last == "Y"
            && !matches!(samples, Samples::Uint(_));
        if is_taken_for_luminance || is_cryptomatte(layer) && !compression.keeps_floats() {
            let compression = compression.name();
            return fault(&format!(
                "would be damaged by the compression `{compression}`: choose one without loss, such as `zip`"
            ));
        }
        names.push(name);
    }
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(ImageIoError::Channel {
            name: pair[0].to_owned(),
            what: "is there twice".to_owned(),
        }),
        None => Ok(()),
    }
}

/// The crate's texts are bytes, which other programs read as UTF-8.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// The attributes of the file. The crate has its own fields for the names that OpenEXR defines.
fn attributes(image: &LayeredImage) -> LayerAttributes {
    let mut attributes = LayerAttributes::default();
    for (name, attribute) in &image.attributes {
        match (name.as_str(), attribute) {
            ("software", Attribute::Text(value)) => attributes.software_name = Some(text(value)),
            ("comments", Attribute::Text(value)) => attributes.comments = Some(text(value)),
            ("owner", Attribute::Text(value)) => attributes.owner = Some(text(value)),
            ("capDate", Attribute::Text(value)) => attributes.capture_date = Some(text(value)),
            ("worldToCamera", Attribute::Matrix(matrix)) => attributes.world_to_camera = Some(*matrix),
            ("worldToNDC", Attribute::Matrix(matrix)) => attributes.world_to_normalized_device = Some(*matrix),
            (name, value) => {
                let value = match value {
                    Attribute::Text(value) => AttributeValue::Text(text(value)),
                    Attribute::Int(value) => AttributeValue::I32(*value),
                    Attribute::Float(value) => AttributeValue::F32(*value),
                    Attribute::Matrix(matrix) => AttributeValue::Matrix4x4(*matrix),
                };
                attributes.other.insert(text(name), value);
            }
        }
    }
    attributes
}

/// A channel from which the crate reads row by row, so that the samples are not copied.
#[derive(Clone, Copy)]
struct Rows<'a> {
    channel: &'a Channel,
    width: usize,
}

impl<'s> WritableSamples<'s> for Rows<'_> {
    type Writer = Self;

    fn sample_type(&self) -> SampleType {
        match self.channel.samples {
            Samples::Half(_) => SampleType::F16,
            Samples::Float(_) => SampleType::F32,
            Samples::Uint(_) => SampleType::U32,
        }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'s self, _: &Header) -> Self {
        *self
    }
}

impl SamplesWriter for Rows<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let at = line.location;
        let begin = at.position.y() * self.width + at.position.x();
        let row = begin..begin + at.sample_count;
        let written = match &self.channel.samples {
            Samples::Half(samples) => {
                let halves: Vec<f16> = samples[row].iter().copied().map(half).collect();
                line.write_samples_from_slice(&halves)
            }
            Samples::Float(samples) => line.write_samples_from_slice(&samples[row]),
            Samples::Uint(samples) => line.write_samples_from_slice(&samples[row]),
        };
        written.expect("the crate gives a line of this type and length");
    }
}

/// Rounds to the nearest half; finite values stay finite.
fn half(sample: f32) -> f16 {
    match sample.is_finite() {
        true => f16::from_f32(sample.clamp(f16::MIN.to_f32(), f16::MAX.to_f32())),
        false => f16::from_f32(sample),
    }
}

/// Sorts the attributes of the file's only header by name: the crate keeps some of them in an unordered table, and the
/// same picture shall give the same bytes. The header has names and types that end in a zero, lengths of four bytes,
/// and a zero at its end.
fn sort_attributes(bytes: &mut [u8]) {
    /// The magic number and the version.
    const BEGIN: usize = 8;
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut at = BEGIN;
    while bytes[at] != 0 {
        let word_end = |from: usize| from + bytes[from..].iter().position(|&byte| byte == 0).unwrap_or(0) + 1;
        let length_at = word_end(word_end(at));
        let length = bytes[length_at..length_at + 4].try_into().map_or(0, u32::from_le_bytes);
        let end = length_at + 4 + length as usize;
        attributes.push(&bytes[at..end]);
        at = end;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    bytes[BEGIN..at].copy_from_slice(&sorted);
}

/// Reads all channels, and the attributes that [`Attribute`] can hold, of an EXR file. Parts of another size than the
/// first are skipped, and so are channels with a repeated name. The needed memory is reserved in the memory budget.
pub fn decode_exr(bytes: &[u8]) -> Result<LayeredImage, ImageFileError> {
    const BYTES_PER_SAMPLE: u64 = 4;
    let mut memory = reserve_exr(bytes, |channels| BYTES_PER_SAMPLE * channels as u64)?;
    let file = read_exr_parts(bytes)?;
    let has_parts = file.layer_data.len() > 1;
    let Some(size) = file.layer_data.first().map(|part| part.size) else {
        return Err(ImageFileError::Empty);
    };
    let mut image = LayeredImage::new(size.width() as u32, size.height() as u32);
    image.attributes = known_attributes(&file.layer_data[0].attributes);
    let mut names = HashSet::new();
    for part in file.layer_data.into_iter().filter(|part| part.size == size) {
        let prefix = match &part.attributes.layer_name {
            Some(name) if has_parts => string(name),
            _ => String::new(),
        };
        for channel in part.channel_data.list {
            let name = string(&channel.name);
            let name = match name.strip_prefix(prefix.as_str()) {
                Some(rest) if rest.starts_with('.') => name,
                _ => full_name(&prefix, &name),
            };
            // Names are unique in the format.
            if !names.insert(name.clone()) {
                continue;
            }
            let samples = match channel.sample_data {
                FlatSamples::F16(halves) => Samples::Half(halves.into_iter().map(f16::to_f32).collect()),
                FlatSamples::F32(floats) => Samples::Float(floats),
                FlatSamples::U32(numbers) => Samples::Uint(numbers),
            };
            image.channels.push(Channel { name, samples });
        }
    }
    let kept = BYTES_PER_SAMPLE * (image.channels.len() * image.pixel_count()) as u64;
    if kept < memory.bytes() {
        memory.resize(kept).map_err(|shortage| ImageFileError::Memory {
            width: image.width.into(),
            height: image.height.into(),
            shortage,
        })?;
    }
    image.memory = memory.into();
    Ok(image)
}

/// The attributes, ordered by name.
fn known_attributes(attributes: &LayerAttributes) -> Vec<(String, Attribute)> {
    let texts = [
        ("software", &attributes.software_name),
        ("comments", &attributes.comments),
        ("owner", &attributes.owner),
        ("capDate", &attributes.capture_date),
    ];
    let matrices = [
        ("worldToCamera", &attributes.world_to_camera),
        ("worldToNDC", &attributes.world_to_normalized_device),
    ];
    let texts = texts
        .into_iter()
        .filter_map(|(name, value)| Some((name.to_owned(), Attribute::Text(string(value.as_ref()?)))));
    let matrices = matrices
        .into_iter()
        .filter_map(|(name, value)| Some((name.to_owned(), Attribute::Matrix((*value)?))));
    let others = attributes.other.iter().filter_map(|(name, value)| {
        let value = match value {
            AttributeValue::Text(value) => Attribute::Text(string(value)),
            AttributeValue::I32(value) => Attribute::Int(*value),
            AttributeValue::F32(value) => Attribute::Float(*value),
            AttributeValue::Matrix4x4(matrix) => Attribute::Matrix(*matrix),
            _ => return None,
        };
        Some((string(name), value))
    });
    let mut found: Vec<_> = texts.chain(matrices).chain(others).collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;

    /// Channels of all kinds, with bits that a careless conversion would lose.
    fn layered() -> LayeredImage {
        let (width, height) = (37, 41);
        let mut image = LayeredImage::new(width, height);
        let numbers = |scale: f32| {
            (0..width * height)
                .map(|i| (i as f32 * 0.37).sin() * scale)
                .collect::<Vec<f32>>()
        };
        for (name, scale) in [
            ("R", 1.0),
            ("G", 0.1),
            ("B", 7e4),
            ("Depth.Z", 1e6),
            ("Light.Key.R", 1e-9),
        ] {
            image.add_float(name, numbers(scale));
        }
        // Floats whose bits are hashes: some are no normal numbers.
        let hashes = (0..width * height).map(|i| f32::from_bits(i.wrapping_mul(0x9e37_79b9) & 0x7f7f_ffff));
        image.add_float("CryptoObject00.R", hashes.collect());
        image.channels.push(Channel {
            name: "Object.ID".into(),
            samples: Samples::Uint((0..width * height).map(|i| u32::MAX - i).collect()),
        });
        image.channels.push(Channel {
            name: "A".into(),
            samples: Samples::Half((0..width * height).map(|i| (i % 5) as f32 / 4.0).collect()),
        });
        image.set_attribute("software", Attribute::Text("Sunroom".into()));
        image.set_attribute("sunroom:spp", Attribute::Int(64));
        image.set_attribute("sunroom:seconds", Attribute::Float(1.5));
        image.set_attribute(
            "cryptomatte/1a2b3c4/manifest",
            Attribute::Text(r#"{"Stühle":"3f800000"}"#.repeat(40)),
        );
        image.set_attribute("worldToCamera", Attribute::Matrix(std::array::from_fn(|i| i as f32)));
        image
    }

    fn sorted(mut image: LayeredImage) -> LayeredImage {
        image.channels.sort_by(|a, b| a.name.cmp(&b.name));
        image.attributes.sort_by(|a, b| a.0.cmp(&b.0));
        image
    }

    #[test]
    fn every_bit_comes_back() {
        let put = sorted(layered());
        for compression in ExrCompression::ALL.into_iter().filter(|c| c.keeps_floats()) {
            let mut put = put.clone();
            if matches!(compression, ExrCompression::B44 | ExrCompression::B44a) {
                // These methods lose bits of halves only.
                put.channels.retain(|channel| channel.name != "A");
            }
            let bytes = encode_exr(&put, compression).unwrap();
            assert_eq!(bytes, encode_exr(&put, compression).unwrap(), "{compression:?}");
            assert_eq!(decode_exr(&bytes).unwrap(), put, "{compression:?}");
        }
    }

    #[test]
    fn lossy_ways_stay_near_and_spare_no_cryptomatte() {
        let mut put = layered();
        for compression in [ExrCompression::Pxr24, ExrCompression::Dwaa, ExrCompression::Dwab] {
            let text = encode_exr(&put, compression).unwrap_err().to_string();
            assert!(
                text.contains("`CryptoObject00.R`") && text.contains(compression.name()),
                "{text}"
            );
        }
        let smooth = (0..37 * 41).map(|i| 1.0 + 0.1 * (i as f32 * 0.05).sin());
        put = LayeredImage::new(37, 41);
        put.add_rgb("", &smooth.map(Rgb::splat).collect::<Vec<Rgb>>());
        put.store_colors_as_half();
        for compression in ExrCompression::ALL {
            let read = decode_exr(&encode_exr(&put, compression).unwrap()).unwrap();
            let (put, read) = (&put.channel("G").unwrap().samples, &read.channel("G").unwrap().samples);
            assert!(matches!(read, Samples::Half(_)), "{compression:?}");
            let error = (0..put.len()).map(|i| (put.value(i) - read.value(i)).abs());
            let error = error.fold(0.0, f32::max);
            assert!(error < 0.01, "{compression:?}: {error}");
        }
    }

    #[test]
    fn layers_of_data_are_not_taken_for_luminances() {
        let numbers: Vec<f32> = (0..37 * 41).map(|i| (i as f32 * 0.37).sin()).collect();
        let mut put = LayeredImage::new(37, 41);
        put.add_rgb("", &numbers.iter().map(|&x| Rgb::splat(x.abs())).collect::<Vec<Rgb>>());
        for name in ["Depth.Z", "UV.U", "UV.V", "A"] {
            put.add_float(name, numbers.clone());
        }
        put.add_channel("ObjectId.Y", Samples::Uint((0..37 * 41).collect()));
        for compression in [ExrCompression::Dwaa, ExrCompression::Dwab] {
            let read = decode_exr(&encode_exr(&put, compression).unwrap()).unwrap();
            for channel in put.channels.iter().filter(|channel| !"RGB".contains(&channel.name)) {
                assert_eq!(read.channel(&channel.name), Some(channel), "{compression:?}");
            }
            for name in ["Normal.Y", "Samples.Y"] {
                let mut damaged = put.clone();
                damaged.add_float(name, numbers.clone());
                let text = encode_exr(&damaged, compression).unwrap_err().to_string();
                let expected = format!("`{name}` would be damaged by the compression `{}`", compression.name());
                assert!(text.contains(&expected), "{text}");
                encode_exr(&damaged, ExrCompression::Pxr24).unwrap();
            }
        }
        // A picture of luminances alone is valid.
        put.convert_colors(crate::render::layered_image::StoredColors::Luminance);
        encode_exr(&put, ExrCompression::Dwaa).unwrap();
    }

    #[test]
    fn halves_are_rounded_and_stay_finite() {
        let mut put = LayeredImage::new(4, 1);
        put.channels.push(Channel {
            name: "R".into(),
            samples: Samples::Half(vec![1.0 + 1.0 / 1024.0 + 1.0 / 4096.0, 1e9, -1e9, f32::INFINITY]),
        });
        let read = decode_exr(&encode_exr(&put, ExrCompression::Zip).unwrap()).unwrap();
        let expected = vec![1.0 + 1.0 / 1024.0, 65504.0, -65504.0, f32::INFINITY];
        assert_eq!(read.channels[0].samples, Samples::Half(expected));
    }

    #[test]
    fn what_cannot_be_written_is_named() {
        let fails = |change: &dyn Fn(&mut LayeredImage), words: &str| {
            let mut image = layered();
            change(&mut image);
            let text = encode_exr(&image, ExrCompression::Zip).unwrap_err().to_string();
            assert!(text.contains(words), "{text}");
        };
        fails(&|image| image.channels.clear(), "0 pixels");
        fails(&|image| image.add_float("G", vec![0.0; 37 * 41]), "`G` is there twice");
        fails(
            &|image| image.add_float("X", vec![0.0; 7]),
            "`X` has 7 samples for 37 x 41 pixels",
        );
        fails(&|image| image.channels[0].name = "n".repeat(256), "255");
        fails(&|image| image.channels[0].name.clear(), "empty");
        fails(&|image| image.set_attribute("channels", Attribute::Int(1)), "channels");
    }

    #[test]
    fn damaged_files_give_errors() {
        let bytes = encode_exr(&layered(), ExrCompression::Zip).unwrap();
        for length in (0..bytes.len()).step_by(97) {
            decode_exr(&bytes[..length]).expect_err("a part of a file is none");
        }
        // A broken byte in a sample may go unnoticed; it never ends the process.
        for at in (0..bytes.len()).step_by(13) {
            let mut broken = bytes.clone();
            broken[at] ^= 0xff;
            drop(decode_exr(&broken));
        }
    }

    #[test]
    fn a_file_that_promises_too_much_is_refused() {
        let mut bytes = encode_exr(&layered(), ExrCompression::Zip).unwrap();
        // The data window: its last corner becomes a hundred thousand pixels away.
        let name = b"dataWindow\0box2i\0";
        let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
        for corner in [8, 12] {
            bytes[at + corner..at + corner + 4].copy_from_slice(&99_999_i32.to_le_bytes());
        }
        let error = decode_exr(&bytes).unwrap_err();
        assert!(
            matches!(
                error,
                ImageFileError::TooLarge {
                    width: 100_000,
                    height: 100_000,
                    ..
                } | ImageFileError::Damaged(_)
            ),
            "{error}"
        );
    }
}
