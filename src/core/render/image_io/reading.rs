//! Reads pictures of every format for comparisons.

use super::exr::decode_exr;
use crate::color::Rgb;
use crate::memory;
use crate::render::layered_image::LayeredImage;
use crate::texture::{ImageFileError, Transfer, is_exr, load_image};

/// A picture from a file.
#[derive(Clone, Debug)]
pub struct LoadedPicture {
    /// The linear colours, with the layers of an EXR file. The channel of a grey picture is `Y`.
    pub image: LayeredImage,
    /// Whether the file holds the displayed picture in place of radiance.
    pub is_displayed: bool,
}

/// Reads a picture in any format of textures, with all channels of EXR files.
pub fn load_picture(bytes: &[u8]) -> Result<LoadedPicture, ImageFileError> {
    if is_exr(bytes) {
        return Ok(LoadedPicture {
            image: decode_exr(bytes)?,
            is_displayed: false,
        });
    }
    let picture = load_image(bytes)?;
    let (width, height) = (picture.width(), picture.height());
    let bytes = u64::from(width) * u64::from(height) * size_of::<Rgb>() as u64;
    let memory = memory::reserve(bytes).map_err(|shortage| ImageFileError::Memory {
        width: width.into(),
        height: height.into(),
        shortage,
    })?;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels: Vec<_> = places.map(|(x, y)| picture.pixel(x, y)).collect();
    let mut image = LayeredImage::new(width, height);
    match picture.channels() {
        1 => image.add_float("Y", pixels.iter().map(|pixel| pixel.x).collect()),
        _ => image.add_rgb("", &pixels),
    }
    image.memory = memory.into();
    Ok(LoadedPicture {
        image,
        is_displayed: picture.transfer() == Transfer::Srgb,
    })
}
