//! The common part of readers of picture files: the errors, and the check of the size that a header declares.
//!
//! The declared size is compared with the length of the file before memory is taken for it.

use thiserror::Error;

use super::image::Image;
use crate::memory::{self, Reservation, Shortage};
use crate::photometry::ProfileError;

/// The reason why bytes are not a picture. Callers add the file's name.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ImageFileError {
    #[error("not a picture in a known format: PNG, JPEG, BMP, TGA, PPM, EXR, HDR or PFM, nor a lamp (IES, EULUMDAT)")]
    UnknownFormat,
    #[error("the file of luminous intensities has a fault in {0}")]
    Profile(#[from] ProfileError),
    #[error("pictures in the format {0} are not read; save it as PNG, JPEG, HDR or EXR")]
    UnsupportedFormat(String),
    #[error("a picture of {width} x {height} pixels is promised, which is more than a file of {bytes} bytes can hold")]
    TooLarge { width: u64, height: u64, bytes: usize },
    #[error("{width} x {height} pixels need {shortage}")]
    Memory {
        width: u64,
        height: u64,
        shortage: Shortage,
    },
    #[error("the picture has no pixels")]
    Empty,
    #[error("the picture is damaged: {0}")]
    Damaged(String),
    #[error("the EXR picture has no channels R, G, B, nor Y, and more than one: {0}")]
    Channels(String),
    #[error("{0}; save the EXR picture with ZIP compression and full resolution, without depth samples")]
    UnsupportedExr(String),
}

/// The most bytes of a picture in one byte of any compressed format: DWAB needs two bytes for a constant block of 64
/// halves, and deflate packs 1032 of those into one.
const MOST_PER_BYTE: u64 = 64 * 1032;

/// The size that the header of a picture declares.
pub(super) struct PromisedSize {
    /// Width and height in pixels.
    pub width: u64,
    pub height: u64,
    /// Bytes that the file must hold, before compression.
    pub decoded_bytes: u64,
    /// The most bytes of memory for decoding and for the picture afterwards.
    pub memory_bytes: u64,
}

impl PromisedSize {
    /// Reserves the memory. An error if the file is too short for the picture, or the budget too small.
    pub fn reserve(&self, file_bytes: usize) -> Result<Reservation, ImageFileError> {
        let (width, height) = (self.width, self.height);
        if width == 0 || height == 0 {
            return Err(ImageFileError::Empty);
        }
        if self.decoded_bytes > MOST_PER_BYTE.saturating_mul(file_bytes as u64) {
            return Err(ImageFileError::TooLarge {
                width,
                height,
                bytes: file_bytes,
            });
        }
        memory::reserve(self.memory_bytes).map_err(|shortage| ImageFileError::Memory {
            width,
            height,
            shortage,
        })
    }
}

/// The picture, which keeps only the part of `memory` that its samples need.
pub(super) fn hold(image: Image, mut memory: Reservation) -> Result<Image, ImageFileError> {
    let bytes = image.memory_bytes().min(memory.bytes());
    memory.resize(bytes).map_err(|shortage| ImageFileError::Memory {
        width: image.width().into(),
        height: image.height().into(),
        shortage,
    })?;
    Ok(image.holding(memory))
}

/// An error of the crate `image` while it reads a file of a known format.
pub(super) fn damaged(error: ::image::ImageError) -> ImageFileError {
    ImageFileError::Damaged(error.to_string())
}
