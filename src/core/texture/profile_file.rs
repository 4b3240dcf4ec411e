//! Pictures of the intensities that files of lamps hold.

use super::image::{ENVIRONMENT_BYTES, Image, Samples, Transfer};
use super::image_header::{ImageFileError, PromisedSize, hold};
use crate::photometry::{LUMENS_PER_WATT, read_profile};

/// Reads an IES or EULUMDAT file as a grey picture of all directions in W/sr. The axis of the beam is in the bottom
/// row; [`IntensityPicture`](crate::photometry::IntensityPicture) tells the columns.
pub(super) fn load_profile(bytes: &[u8]) -> Result<Image, ImageFileError> {
    let picture = read_profile(bytes)?.picture();
    let pixels = picture.candela.len() as u64;
    let promise = PromisedSize {
        width: picture.width.into(),
        height: picture.height.into(),
        // The grid may be finer than the angles of the file.
        decoded_bytes: 0,
        memory_bytes: pixels * (4 + ENVIRONMENT_BYTES),
    };
    let memory = promise.reserve(bytes.len())?;
    let watts = picture
        .candela
        .iter()
        .map(|candela| candela / LUMENS_PER_WATT)
        .collect();
    let image = Image::new(picture.width, picture.height, 1, Samples::F32(watts), Transfer::Linear);
    hold(image.ok_or(ImageFileError::Empty)?, memory)
}
