//! Writes pictures, cube maps and volume textures as KTX 2.0, with four channels of half floats.
//!
//! Source: the KTX File Format Specification 2.0.4, and the Khronos Data Format Specification 1.3.1, chapter 5, for the
//! descriptor.

use glam::{UVec2, UVec3};
use half::f16;

use super::cube::CubePicture;
use crate::color::Rgb;

const IDENTIFIER: [u8; 12] = [
    0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, b'\r', b'\n', 0x1A, b'\n',
];
/// `VK_FORMAT_R16G16B16A16_SFLOAT`.
const FORMAT: u32 = 97;
/// Bytes of the header and the index, and of the index of a mip level.
const HEAD: usize = 48 + 32;
const LEVEL: usize = 24;
/// Bytes of a texel; mip levels are aligned to them.
const TEXEL: usize = 8;
/// Red, green, blue and alpha in the descriptor.
const CHANNELS: [u8; 4] = [0, 1, 2, 15];
/// The qualifiers of a signed float.
const SIGNED_FLOAT: u8 = 0xC0;

/// The metadata of a file.
struct Head {
    /// The width, the height, and the depth, which is 0 for pictures.
    size: UVec3,
    /// 6 for cube maps, else 1.
    faces: u32,
    /// The directions of growing columns, rows and slices.
    orientation: &'static str,
}

/// The file of a linear picture, row by row from the top. Values above the largest half float are clamped to it.
pub fn picture(size: UVec2, pixels: impl IntoIterator<Item = Rgb>) -> Vec<u8> {
    let head = Head {
        size: size.extend(0),
        faces: 1,
        orientation: "rd",
    };
    file(&head, &[halves(pixels)])
}

/// The file of a cube map, given its mip levels, each half as wide as the one before.
pub fn cube(levels: &[CubePicture]) -> Vec<u8> {
    let size = levels.first().map_or(0, |level| level.size);
    let head = Head {
        size: UVec3::new(size, size, 0),
        faces: 6,
        orientation: "rd",
    };
    let levels: Vec<Vec<u8>> = levels
        .iter()
        .map(|level| halves(level.texels.iter().copied()))
        .collect();
    file(&head, &levels)
}

/// The file of a volume texture, first along x, then along y, then along z.
pub fn volume(size: UVec3, texels: impl IntoIterator<Item = Rgb>) -> Vec<u8> {
    let head = Head {
        size,
        faces: 1,
        orientation: "rdi",
    };
    file(&head, &[halves(texels)])
}

/// The texels of a mip level as half floats, opaque.
fn halves(texels: impl IntoIterator<Item = Rgb>) -> Vec<u8> {
    let half = |value: f32| f16::from_f32(value.clamp(0.0, f16::MAX.to_f32()));
    let channels = |texel: Rgb| [half(texel.x), half(texel.y), half(texel.z), f16::ONE];
    texels
        .into_iter()
        .flat_map(channels)
        .flat_map(f16::to_le_bytes)
        .collect()
}

/// The file with these mip levels, given largest first. The file stores them smallest first.
fn file(head: &Head, levels: &[Vec<u8>]) -> Vec<u8> {
    let (descriptor, texts) = (descriptor(), texts(head.orientation));
    let descriptor_at = HEAD + LEVEL * levels.len();
    let texts_at = descriptor_at + descriptor.len();
    let levels_at = (texts_at + texts.len()).next_multiple_of(TEXEL);
    let mut file = Vec::with_capacity(levels_at + levels.iter().map(Vec::len).sum::<usize>());
    file.extend(IDENTIFIER);
    let size_of_component = 2;
    let (layers, compression) = (0, 0);
    let header = [
        FORMAT,
        size_of_component,
        head.size.x,
        head.size.y,
        head.size.z,
        layers,
        head.faces,
        levels.len() as u32,
        compression,
    ];
    let index = [
        descriptor_at as u32,
        descriptor.len() as u32,
        texts_at as u32,
        texts.len() as u32,
    ];
    file.extend(header.into_iter().chain(index).flat_map(u32::to_le_bytes));
    let global_data = [0, 0];
    file.extend(global_data.into_iter().flat_map(u64::to_le_bytes));
    let smaller = |level: usize| levels[level + 1..].iter().map(Vec::len).sum::<usize>();
    for (number, level) in levels.iter().enumerate() {
        let at = (levels_at + smaller(number)) as u64;
        let length = level.len() as u64;
        file.extend([at, length, length].into_iter().flat_map(u64::to_le_bytes));
    }
    file.extend(descriptor);
    file.extend(texts);
    file.resize(levels_at, 0);
    levels.iter().rev().for_each(|level| file.extend(level));
    file
}

/// The data format descriptor: the meaning of the bits of a texel.
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
    let bytes_of_planes = [TEXEL as u8, 0, 0, 0, 0, 0, 0, 0];
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

/// The key and value pairs.
fn texts(orientation: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    for text in [
        &format!("KTXorientation\0{orientation}\0"),
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

    fn word(file: &[u8], at: usize) -> usize {
        u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize
    }

    fn first_half(file: &[u8], at: usize) -> f32 {
        f16::from_le_bytes([file[at], file[at + 1]]).to_f32()
    }

    #[test]
    fn levels_of_a_cube_are_found_by_the_index_and_lie_from_small_to_large() {
        let level = |size: u32, red: f32| CubePicture {
            size,
            texels: vec![Rgb::splat(red); 6 * size as usize * size as usize],
        };
        let file = cube(&[level(8, 1.0), level(4, 2.0)]);
        assert_eq!([20, 24, 28, 36, 40].map(|at| word(&file, at)), [8, 8, 0, 6, 2]);
        let (large, small) = (word(&file, 80), word(&file, 104));
        assert_eq!((word(&file, 88), word(&file, 112)), (8 * 6 * 64, 8 * 6 * 16));
        assert_eq!((first_half(&file, large), first_half(&file, small)), (1.0, 2.0));
        assert_eq!((small + 8 * 6 * 16, large + 8 * 6 * 64), (large, file.len()));
    }

    #[test]
    fn a_volume_has_a_depth() {
        let file = volume(UVec3::new(2, 1, 3), (0..6).map(|texel| Rgb::splat(texel as f32)));
        assert_eq!([20, 24, 28, 36, 40].map(|at| word(&file, at)), [2, 1, 3, 1, 1]);
        let level = word(&file, 80);
        assert_eq!(first_half(&file, level + 5 * 8), 5.0);
        assert!(file.windows(19).any(|text| text == b"KTXorientation\0rdi\0"));
    }

    #[test]
    fn the_parts_lie_where_the_index_says() {
        let pixels = [Rgb::new(0.5, 1.0, 2.0), Rgb::splat(1e9), Rgb::splat(-1.0)];
        let file = picture(UVec2::new(3, 1), pixels);
        let word = |at: usize| word(&file, at);
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
