//! Pictures of KHR_texture_basisu: KTX 2 files with a supercompressed texture, which the crate `basisu` unpacks.

use basisu::{DecodeFlags, SourceFormat, TargetFormat, Transcoder};
use image::{DynamicImage, RgbaImage};

use super::guard::guarded;
use crate::memory::{self, Reservation};

/// The first bytes of every KTX 2 file.
const START: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";

/// The width and the height, and the unpacked bytes of the largest level, by their places in the header (KTX 2.0,
/// section 3).
fn sizes(bytes: &[u8]) -> Option<[u64; 3]> {
    let side = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?).into());
    let level = u64::from_le_bytes(*bytes.get(96..)?.first_chunk()?);
    Some([side(20)?, side(24)?, level])
}

/// The most pixels in a byte of the file: four bits of a block of sixteen are rarely fewer, but Zstandard may pack
/// constant pictures much further.
const MOST_PER_BYTE: u64 = 1 << 16;

/// The bytes of memory for each pixel of the picture and of its unpacked blocks.
const PIXEL_BYTES: u64 = 8;

/// Whether bytes are a KTX 2 file.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(START)
}

/// The largest level of the picture. The memory reserved with it has `more_bytes` for each pixel.
pub(super) fn decode(bytes: &[u8], more_bytes: u64) -> Result<(DynamicImage, Reservation), String> {
    let [width, height, level] = sizes(bytes).ok_or("the KTX 2 file has no whole header")?;
    let pixels = width * height;
    if pixels == 0 || pixels > MOST_PER_BYTE.saturating_mul(bytes.len() as u64) {
        return Err(format!("the KTX 2 file cannot have {width} x {height} pixels"));
    }
    // Blocks of 4 x 4 pixels have at most 16 bytes. A decoder would believe any number of them.
    if level > 16u64.saturating_mul(width.div_ceil(4) * height.div_ceil(4)) {
        return Err(format!(
            "the KTX 2 file promises {level} bytes for {width} x {height} pixels"
        ));
    }
    let needed = pixels.saturating_mul(PIXEL_BYTES + more_bytes);
    let memory = memory::reserve(needed).map_err(|shortage| format!("{width} x {height} pixels need {shortage}"))?;
    let unpack = || -> Result<Vec<u8>, String> {
        let file = Transcoder::new(bytes).map_err(|error| format!("{error:?}"))?;
        if !matches!(file.source_format(), SourceFormat::Etc1s | SourceFormat::UastcLdr) {
            return Err("it holds neither ETC1S nor UASTC".to_owned());
        }
        if file.base_dimensions() != (width as u32, height as u32) {
            return Err("its sizes do not agree".to_owned());
        }
        file.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE)
            .map_err(|error| format!("{error:?}"))
    };
    let texels = guarded(unpack).unwrap_or_else(|| Err("it is damaged".to_owned()));
    let texels = texels.map_err(|error| format!("the KTX 2 file cannot be unpacked: {error}"))?;
    let image = RgbaImage::from_raw(width as u32, height as u32, texels);
    let image = image.ok_or("the KTX 2 file has no whole picture")?;
    Ok((DynamicImage::ImageRgba8(image), memory))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of 4 x 4 pixels of one colour (UASTC, mode 8).
    pub(in crate::gltf) fn file(color: [u8; 4]) -> Vec<u8> {
        let mut bytes = START.to_vec();
        // Format, type size, width, height, depth, layers, faces, levels, supercompression.
        bytes.extend([0u32, 1, 4, 4, 0, 0, 1, 1, 0].into_iter().flat_map(u32::to_le_bytes));
        // Places of the descriptor of the format, and of no further data.
        bytes.extend([104u32, 44, 0, 0, 0, 0, 0, 0].into_iter().flat_map(u32::to_le_bytes));
        // The place, the bytes and the unpacked bytes of the level.
        bytes.extend([160u64, 16, 16].into_iter().flat_map(u64::to_le_bytes));
        // One block of UASTC, linear, with 4 x 4 pixels of 16 bytes, and its channels.
        let descriptor = [
            44u32,
            0,
            2 | 40 << 16,
            166 | 1 << 8 | 1 << 16,
            3 | 3 << 8,
            16,
            0,
            3 << 24 | 127 << 16,
        ];
        bytes.extend(
            descriptor
                .into_iter()
                .chain([0, 0, u32::MAX])
                .flat_map(u32::to_le_bytes),
        );
        bytes.resize(160, 0);
        let block = color
            .iter()
            .rev()
            .fold(0u128, |bits, channel| bits << 8 | u128::from(*channel))
            << 5
            | 0x17;
        bytes.extend(block.to_le_bytes());
        bytes
    }

    #[test]
    fn a_picture_of_one_colour_is_unpacked() {
        let color = [200, 100, 50, 255];
        let (image, _memory) = decode(&file(color), 0).expect("is whole");
        assert_eq!((image.width(), image.height()), (4, 4));
        assert!(
            image.to_rgba8().pixels().all(|pixel| pixel.0 == color),
            "{:?}",
            image.to_rgba8()
        );
    }

    #[test]
    fn broken_pictures_are_errors() {
        let whole = file([9; 4]);
        for length in 0..whole.len() {
            let _ = decode(&whole[..length], 0);
        }
        assert!(decode(&whole[..150], 0).is_err() && decode(&whole[..90], 0).is_err());
        let with = |at: usize, bytes: &[u8]| {
            let mut file = whole.clone();
            file[at..at + bytes.len()].copy_from_slice(bytes);
            decode(&file, 0).map(|_| ()).expect_err("is broken")
        };
        let huge = with(20, &[255; 8]);
        assert!(huge.contains("cannot have 4294967295 x 4294967295 pixels"), "{huge}");
        let packed = with(96, &[255; 8]);
        assert!(packed.contains("promises"), "{packed}");
        let other = with(116, &[167]);
        assert!(other.contains("cannot be unpacked"), "{other}");
    }
}
