//! Writes a picture as KTX 2.0, the container that graphics cards are given textures in: half floats, four channels, one level.
//!
//! Source: the KTX File Format Specification 2.0.4, and the Khronos Data Format Specification 1.3.1, chapter 5, for the descriptor.

use glam::UVec2;
use half::f16;

use crate::color::Rgb;

const IDENTIFIER: [u8; 12] = [
    0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, b'\r', b'\n', 0x1A, b'\n',
];
/// `VK_FORMAT_R16G16B16A16_SFLOAT`.
const FORMAT: u32 = 97;
/// Bytes of the header, the index, and the index of the one level.
const HEAD: usize = 48 + 32 + 24;
/// Red, green, blue and alpha in the descriptor.
const CHANNELS: [u8; 4] = [0, 1, 2, 15];
/// The qualifiers of a signed float.
const SIGNED_FLOAT: u8 = 0xC0;

/// The file of a linear picture, row by row from the top. Values above the largest half float become that one.
pub fn ktx2(size: UVec2, pixels: impl IntoIterator<Item = Rgb>) -> Vec<u8> {
    let descriptor = descriptor();
    let texts = texts();
    let texts_at = HEAD + descriptor.len();
    let level_at = (texts_at + texts.len()).next_multiple_of(8);
    let level_length = 8 * size.x as usize * size.y as usize;
    let mut file = Vec::with_capacity(level_at + level_length);
    file.extend(IDENTIFIER);
    let size_of_component = 2;
    let (depth, layers, faces, levels, compression) = (0, 0, 1, 1, 0);
    let header = [
        FORMAT,
        size_of_component,
        size.x,
        size.y,
        depth,
        layers,
        faces,
        levels,
        compression,
    ];
    let index = [
        HEAD as u32,
        descriptor.len() as u32,
        texts_at as u32,
        texts.len() as u32,
    ];
    file.extend(header.into_iter().chain(index).flat_map(u32::to_le_bytes));
    let global_data = [0, 0];
    let level = [level_at as u64, level_length as u64, level_length as u64];
    file.extend(global_data.into_iter().chain(level).flat_map(u64::to_le_bytes));
    file.extend(descriptor);
    file.extend(texts);
    file.resize(level_at, 0);
    let half = |value: f32| f16::from_f32(value.clamp(0.0, f16::MAX.to_f32()));
    for pixel in pixels {
        let channels = [half(pixel.x), half(pixel.y), half(pixel.z), f16::ONE];
        file.extend(channels.into_iter().flat_map(f16::to_le_bytes));
    }
    file
}

/// What the bits of a texel mean.
fn descriptor() -> Vec<u8> {
    let block = 24 + 16 * CHANNELS.len();
    let mut bytes = Vec::new();
    bytes.extend((4 + block as u32).to_le_bytes());
    let (vendor_and_kind, version) = (0u32, 2u16);
    bytes.extend(vendor_and_kind.to_le_bytes());
    bytes.extend(version.to_le_bytes());
    bytes.extend((block as u16).to_le_bytes());
    let (rgb, rec_709, linear, no_flags) = (1, 1, 1, 0);
    bytes.extend([rgb, rec_709, linear, no_flags]);
    let one_texel = [0; 4];
    bytes.extend(one_texel);
    let bytes_of_planes = [8, 0, 0, 0, 0, 0, 0, 0];
    bytes.extend(bytes_of_planes);
    for (number, channel) in (0u16..).zip(CHANNELS) {
        bytes.extend((16 * number).to_le_bytes());
        let last_bit = 15;
        bytes.extend([last_bit, channel | SIGNED_FLOAT]);
        let place = [0; 4];
        bytes.extend(place);
        bytes.extend((-1.0f32).to_le_bytes());
        bytes.extend(1.0f32.to_le_bytes());
    }
    bytes
}

/// The key and value pairs: rows go to the right, and downwards.
fn texts() -> Vec<u8> {
    let mut bytes = Vec::new();
    for text in [
        "KTXorientation\0rd\0",
        concat!("KTXwriter\0Sunroom ", env!("CARGO_PKG_VERSION"), "\0"),
    ] {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.bytes());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_lie_where_the_index_says() {
        let pixels = [Rgb::new(0.5, 1.0, 2.0), Rgb::splat(1e9), Rgb::splat(-1.0)];
        let file = ktx2(UVec2::new(3, 1), pixels);
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize;
        let (descriptor, texts, level) = (word(48), word(56), word(80));
        assert_eq!(word(descriptor), word(52));
        assert_eq!(descriptor + word(52), texts);
        assert_eq!(&file[texts + 4..texts + 18], b"KTXorientation");
        assert!(level.is_multiple_of(8) && level >= texts + word(60));
        assert_eq!(file.len(), level + word(88));
        let halves: Vec<f32> = file[level..]
            .chunks_exact(2)
            .map(|bytes| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32())
            .collect();
        assert_eq!(
            halves,
            [0.5, 1.0, 2.0, 1.0, 65504.0, 65504.0, 65504.0, 1.0, 0.0, 0.0, 0.0, 1.0]
        );
    }
}
