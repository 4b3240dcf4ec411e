//! Makes the pictures that the scene format needs from those of the file: one channel, a factor applied, an alpha cut off, normals turned. The
//! format has no textures that are products of others, and neither metals nor roughness share a picture there.

use image::{DynamicImage, ImageBuffer, Luma, Rgb};

use super::{Gltf, GltfError, ReadFile};
use crate::color::{linear_from_srgb, srgb_from_linear};
use crate::texture::decode_picture;

/// A picture that materials of the file use. Two that are equal are one.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The index among the images of the file.
    pub image: usize,
    pub made: Made,
}

/// The operation on the file's image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Made {
    /// Colours as sRGB, each channel times a factor (of the linear value).
    Color([f32; 3]),
    /// Numbers: a channel times a factor.
    Channel { channel: usize, factor: f32 },
    /// Numbers: alpha times a factor; with a cutoff 0 below and 1 from there on.
    Alpha { factor: f32, cutoff: Option<f32> },
    /// Normals, with x and y scaled. In the file y is up, in the format it goes along v, which is down.
    Normals { scale: f32 },
}

impl Made {
    /// Whether the samples are numbers that are not decoded from sRGB. Colours brighter than white are: Mitsuba warns of them otherwise.
    pub fn is_raw(&self) -> bool {
        !matches!(self, Self::Color(factor) if factor.iter().all(|&factor| factor <= 1.0))
    }
}

/// A picture in a file of its own.
pub struct PictureFile {
    pub bytes: Vec<u8>,
    /// The extension: `png`, `jpg` or `exr`.
    pub extension: &'static str,
    /// False if another picture has taken the place of the one that was written with the glTF file.
    pub is_as_written: bool,
}

impl Gltf {
    /// Makes the file of a picture: that of the glTF file if nothing has to be done to it.
    pub fn picture(&self, picture: &Picture, read: &mut ReadFile) -> Result<PictureFile, GltfError> {
        let index = picture.image;
        let bad = |what: String| GltfError::Image { index, what };
        let bytes = self.image_file(index, read)?;
        let image = self.root.images.get(index);
        let is_as_written = image.is_none_or(|image| self.root.is_as_written(&image.extras, &bytes));
        let format = image::guess_format(&bytes).map_err(|error| bad(error.to_string()))?;
        let extension = match format {
            image::ImageFormat::Png => "png",
            image::ImageFormat::Jpeg => "jpg",
            _ => return Err(bad("is neither PNG nor JPEG".to_owned())),
        };
        if picture.made == Made::Color([1.0; 3]) {
            return Ok(PictureFile {
                bytes: bytes.into_owned(),
                extension,
                is_as_written,
            });
        }
        let (image, _memory) =
            decode_picture(&bytes, format, CONVERTED_BYTES).map_err(|error| bad(error.to_string()))?;
        let made = make(&image, picture.made);
        let (format, extension) = match made {
            DynamicImage::ImageRgb32F(_) => (image::ImageFormat::OpenExr, "exr"),
            _ => (image::ImageFormat::Png, "png"),
        };
        let mut bytes = std::io::Cursor::new(Vec::new());
        made.write_to(&mut bytes, format)
            .map_err(|error| bad(error.to_string()))?;
        Ok(PictureFile {
            bytes: bytes.into_inner(),
            extension,
            is_as_written,
        })
    }
}

/// Bytes per pixel for the four floats that a picture is converted to, and for the three that it becomes.
const CONVERTED_BYTES: u64 = 28;

fn make(image: &DynamicImage, made: Made) -> DynamicImage {
    let unit = |share: f32| (share.clamp(0.0, 1.0) * 65535.0).round() as u16;
    let grey = |of: &dyn Fn([f32; 4]) -> f32| {
        let source = image.to_rgba32f();
        let pixels = source.pixels().map(|pixel| unit(of(pixel.0))).collect();
        let grey: Option<ImageBuffer<Luma<u16>, _>> = ImageBuffer::from_raw(source.width(), source.height(), pixels);
        DynamicImage::ImageLuma16(grey.unwrap_or_default())
    };
    match made {
        Made::Color(factor) => {
            let mut linear = image.to_rgb32f();
            for pixel in linear.pixels_mut() {
                for (value, factor) in pixel.0.iter_mut().zip(factor) {
                    *value = factor * linear_from_srgb(*value);
                }
            }
            // A PNG cannot hold values above white.
            if made.is_raw() {
                return DynamicImage::ImageRgb32F(linear);
            }
            let encoded = linear
                .pixels()
                .flat_map(|pixel| pixel.0.map(|value| unit(srgb_from_linear(value))));
            let encoded: Option<ImageBuffer<Rgb<u16>, _>> =
                ImageBuffer::from_raw(linear.width(), linear.height(), encoded.collect());
            DynamicImage::ImageRgb16(encoded.unwrap_or_default())
        }
        Made::Channel { channel, factor } => grey(&|pixel| factor * pixel[channel.min(3)]),
        Made::Alpha { factor, cutoff: None } => grey(&|pixel| factor * pixel[3]),
        Made::Alpha {
            factor,
            cutoff: Some(cutoff),
        } => grey(&|pixel| if factor * pixel[3] >= cutoff { 1.0 } else { 0.0 }),
        Made::Normals { scale } => {
            let source = image.to_rgb32f();
            let turned = source.pixels().flat_map(|pixel| {
                let [x, y, z] = pixel.0.map(|value| 2.0 * value - 1.0);
                let normal = glam::Vec3::new(scale * x, -scale * y, z).normalize_or(glam::Vec3::Z);
                normal.to_array().map(|value| unit(0.5 + 0.5 * value))
            });
            let turned: Option<ImageBuffer<Rgb<u16>, _>> =
                ImageBuffer::from_raw(source.width(), source.height(), turned.collect());
            DynamicImage::ImageRgb16(turned.unwrap_or_default())
        }
    }
}
