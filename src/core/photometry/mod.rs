//! Photometry: the light of lamps as the eye weighs it, and files that lamp makers publish.
//!
//! The renderer computes in radiometric units. One watt of Rec. 709 luminance stands for 683 lumens: the luminous
//! efficacy of monochromatic light of 540 THz, by which the SI defines the candela (BIPM, The International System of
//! Units, 9th edition, 2019, section 2.3.1).

mod cursor;
mod distribution;
mod eulumdat;
pub mod exposure;
mod ies;
pub mod lamps;
mod light_unit;
mod polar;
pub mod units;

pub use cursor::ProfileError;
pub use distribution::{Distribution, Geometry, IntensityPicture, solid_angle_of_row};
pub use light_unit::{LightUnit, Measure};
pub use polar::PolarCurve;

/// Lumens per watt of Rec. 709 luminance.
pub const LUMENS_PER_WATT: f32 = 683.0;

/// The bytes at the beginning of a file that decide on its format.
const BEGINNING: usize = 1 << 16;

/// The most bytes of a file. Large ones have some 400,000.
const MOST_BYTES: usize = 16 << 20;

/// Whether the bytes look like a file that [`read_profile`] reads: a text, but not a picture of text (PNM).
pub fn is_profile(bytes: &[u8]) -> bool {
    let beginning = &bytes[..bytes.len().min(BEGINNING)];
    let is_pnm = matches!(beginning, [b'P', b'1'..=b'7', after, ..] if after.is_ascii_whitespace());
    let is_binary = beginning.iter().take(512).any(|byte| *byte == 0);
    !is_pnm && !is_binary && (ies::is_ies(beginning) || eulumdat::is_eulumdat(beginning))
}

/// Whether the bytes are an IES file (LM-63), and no EULUMDAT file.
pub fn is_ies(bytes: &[u8]) -> bool {
    ies::is_ies(&bytes[..bytes.len().min(BEGINNING)])
}

/// Reads a file of luminous intensities, IES LM-63 or EULUMDAT; its content decides on the format.
pub fn read_profile(bytes: &[u8]) -> Result<Distribution, ProfileError> {
    if bytes.len() > MOST_BYTES {
        return Err(ProfileError::new(1, "the file has more than 16 MiB"));
    }
    let text = String::from_utf8_lossy(bytes);
    match is_ies(bytes) {
        true => ies::read(&text),
        false => eulumdat::read(&text),
    }
}
