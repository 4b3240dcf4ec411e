//! Makes the pictures that the scene format needs from those of the file: one channel, a factor applied, an alpha cut
//! off, normals scaled. The format has no products of textures, and metallic and roughness are separate pictures there.

use glam::Vec3;
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgb32FImage};

use super::combine::{Stretch, StretchImages, combined, from_specular};
use super::{Gltf, GltfError, ReadFile, basis};
use crate::color::{linear_from_srgb, luminance, srgb_from_linear};
use crate::memory::Reservation;
use crate::texture::decode_picture;

/// A picture that a material has requested.
pub(super) struct KnownPicture {
    /// The name of its file; None if it cannot be read.
    pub name: Option<String>,
    /// Its mean colour, once requested.
    pub mean: Option<Vec3>,
}

/// A picture derived from an image. Equal ones share a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The index among the images of the file.
    pub image: usize,
    pub made: Made,
}

/// How alpha becomes an opacity: times a factor; with a cutoff 0 below it and 1 from it on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alpha {
    /// Multiplies the alpha.
    pub factor: f32,
    /// The least alpha of visible texels.
    pub cutoff: Option<f32>,
}

impl Alpha {
    /// The opacity for an alpha.
    pub fn of(self, alpha: f32) -> f32 {
        let alpha = self.factor * alpha;
        match self.cutoff {
            Some(cutoff) => f32::from(u8::from(alpha >= cutoff)),
            None => alpha,
        }
    }
}

/// The operation on the file's image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Made {
    /// Colours as sRGB, each channel times a factor (of the linear value).
    Color([f32; 3]),
    /// Numbers: a channel times a factor.
    Channel { channel: usize, factor: f32 },
    /// Numbers: 1 less a channel times a factor.
    Complement { channel: usize, factor: f32 },
    /// Numbers: the luminance of a colour times a factor (of the linear value).
    Brightness([f32; 3]),
    /// Numbers: a parameter of stretched facets. `factors`: of the roughness and of the strength.
    Stretched {
        part: Stretch,
        images: StretchImages,
        factors: [f32; 2],
    },
    /// The base colour (sRGB) of a picture of specular colour and of another one of diffuse colour.
    BaseOfSpecular {
        diffuse: [f32; 3],
        specular: [f32; 3],
        of: Option<usize>,
    },
    /// Numbers: the metallic of the same.
    MetalOfSpecular {
        diffuse: [f32; 3],
        specular: [f32; 3],
        of: Option<usize>,
    },
    /// Numbers: the opacity from alpha.
    Alpha(Alpha),
    /// Emission as sRGB: a colour times the opacity, and times another image, if there is one.
    Light {
        color: [f32; 3],
        of: Option<usize>,
        alpha: Alpha,
    },
    /// Normals, with x and y scaled.
    Normals { scale: f32 },
}

impl Made {
    /// The second image, if the picture is made of two.
    pub(super) fn second(self) -> Option<usize> {
        match self {
            Self::Light { of, .. } | Self::BaseOfSpecular { of, .. } | Self::MetalOfSpecular { of, .. } => of,
            Self::Stretched {
                images: StretchImages::Both(image),
                ..
            } => Some(image),
            _ => None,
        }
    }

    /// Whether the picture is that of the file.
    fn is_unchanged(self) -> bool {
        matches!(self, Self::Color([1.0, 1.0, 1.0]) | Self::Normals { scale: 1.0 })
    }

    /// Whether the samples are numbers, not decoded from sRGB. Colours brighter than white are as well: otherwise
    /// Mitsuba warns of them.
    pub fn is_raw(&self) -> bool {
        match self {
            Self::Color(factor) | Self::Light { color: factor, .. } => factor.iter().any(|&factor| factor > 1.0),
            Self::BaseOfSpecular { .. } => false,
            Self::Channel { .. }
            | Self::Complement { .. }
            | Self::Brightness(_)
            | Self::Stretched { .. }
            | Self::MetalOfSpecular { .. }
            | Self::Alpha(_)
            | Self::Normals { .. } => true,
        }
    }
}

/// A picture in a file of its own.
pub struct PictureFile {
    pub bytes: Vec<u8>,
    /// The extension: `png`, `jpg` or `exr`.
    pub extension: &'static str,
    /// False if the picture was replaced since it was written with the glTF file.
    pub is_as_written: bool,
    /// The number of pixels that were made; 0 if the image file is unchanged.
    pub pixels: u64,
}

impl Gltf {
    /// Makes the file of a picture: the original image file if nothing has to be changed.
    pub fn picture(&self, picture: &Picture, read: &mut ReadFile) -> Result<PictureFile, GltfError> {
        let index = picture.image;
        let bad = |what: String| GltfError::Image { index, what };
        let bytes = self.image_file(index, read)?;
        let image = self.root.images.get(index);
        let is_as_written = image.is_none_or(|image| self.root.is_as_written(&image.extras, &bytes));
        let kept = kept_extension(&bytes).filter(|_| picture.made.is_unchanged());
        if let Some(extension) = kept {
            return Ok(PictureFile {
                bytes: bytes.into_owned(),
                extension,
                is_as_written,
                pixels: 0,
            });
        }
        let (image, _memory) = decoded(&bytes).map_err(bad)?;
        let other = picture.made.second();
        let second = match other.filter(|other| *other != index) {
            Some(index) => {
                let bytes = self.image_file(index, read)?;
                Some(decoded(&bytes).map_err(|what| GltfError::Image { index, what })?)
            }
            None => None,
        };
        let second = second.as_ref().map(|(image, _)| image);
        let made = make(&image, second.or(other.map(|_| &image)), picture.made);
        let pixels = u64::from(made.width()) * u64::from(made.height());
        let (format, extension) = match made {
            DynamicImage::ImageRgb32F(_) => (ImageFormat::OpenExr, "exr"),
            _ => (ImageFormat::Png, "png"),
        };
        let mut bytes = std::io::Cursor::new(Vec::new());
        made.write_to(&mut bytes, format)
            .map_err(|error| bad(error.to_string()))?;
        Ok(PictureFile {
            bytes: bytes.into_inner(),
            extension,
            is_as_written,
            pixels,
        })
    }
}

/// The extension of a file that other readers of the scene format know; None if it has to be converted.
fn kept_extension(bytes: &[u8]) -> Option<&'static str> {
    match image::guess_format(bytes).ok()? {
        ImageFormat::Png => Some("png"),
        ImageFormat::Jpeg => Some("jpg"),
        _ => None,
    }
}

/// The picture of a file, and the memory for it and for what is made of it.
fn decoded(bytes: &[u8]) -> Result<(DynamicImage, Reservation), String> {
    if basis::is_ktx2(bytes) {
        return basis::decode(bytes, CONVERTED_BYTES);
    }
    let format = image::guess_format(bytes).map_err(|error| error.to_string())?;
    match format {
        ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP => {
            decode_picture(bytes, format, CONVERTED_BYTES).map_err(|error| error.to_string())
        }
        _ => Err("is neither PNG, JPEG, WebP nor KTX 2".to_owned()),
    }
}

/// Bytes per pixel for the four floats that an image is converted to, and for the three of the result.
const CONVERTED_BYTES: u64 = 28;

/// A number from 0 to 1 in 16 bits.
fn unit(share: f32) -> u16 {
    (share.clamp(0.0, 1.0) * 65535.0).round() as u16
}

/// Linear colours as a picture.
fn encoded(linear: Rgb32FImage, made: Made) -> DynamicImage {
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

/// `second`: the second image, if the picture is made of two.
fn make(image: &DynamicImage, second: Option<&DynamicImage>, made: Made) -> DynamicImage {
    let grey_of = |width: u32, height: u32, values: Vec<f32>| {
        let pixels = values.into_iter().map(unit).collect();
        let grey: Option<ImageBuffer<Luma<u16>, _>> = ImageBuffer::from_raw(width, height, pixels);
        DynamicImage::ImageLuma16(grey.unwrap_or_default())
    };
    let grey = |of: &dyn Fn([f32; 4]) -> f32| {
        let source = image.to_rgba32f();
        let values = source.pixels().map(|pixel| of(pixel.0)).collect();
        grey_of(source.width(), source.height(), values)
    };
    let colors = |(width, height, values): (u32, u32, Vec<f32>)| {
        encoded(ImageBuffer::from_raw(width, height, values).unwrap_or_default(), made)
    };
    match made {
        unchanged if unchanged.is_unchanged() => DynamicImage::ImageRgb8(image.to_rgb8()),
        Made::Color(factor) => {
            let mut linear = image.to_rgb32f();
            for pixel in linear.pixels_mut() {
                for (value, factor) in pixel.0.iter_mut().zip(factor) {
                    *value = factor * linear_from_srgb(*value);
                }
            }
            encoded(linear, made)
        }
        Made::Light { color, alpha, .. } => colors(combined(image, second, |first, [r, g, b, _]| {
            let light = Vec3::from(color) * Vec3::new(r, g, b).map(linear_from_srgb);
            (alpha.of(first[3]).max(0.0) * light).to_array()
        })),
        Made::BaseOfSpecular { diffuse, specular, .. } => colors(combined(image, second, |first, second| {
            from_specular(diffuse.into(), specular.into(), first, second)
                .0
                .to_array()
        })),
        Made::MetalOfSpecular { diffuse, specular, .. } => {
            let metal = |first, second| [from_specular(diffuse.into(), specular.into(), first, second).1];
            let (width, height, values) = combined(image, second, metal);
            grey_of(width, height, values)
        }
        Made::Stretched { part, images, factors } => {
            let facets = |first, second| [part.of(images, factors, first, second)];
            let (width, height, values) = combined(image, second, facets);
            grey_of(width, height, values)
        }
        Made::Complement { channel, factor } => grey(&|pixel| 1.0 - factor * pixel[channel.min(3)]),
        Made::Brightness(factor) => {
            grey(&|[r, g, b, _]| luminance(Vec3::from(factor) * Vec3::new(r, g, b).map(linear_from_srgb)))
        }
        Made::Channel { channel, factor } => grey(&|pixel| factor * pixel[channel.min(3)]),
        Made::Alpha(alpha) => grey(&|pixel| alpha.of(pixel[3])),
        Made::Normals { scale } => {
            let source = image.to_rgb32f();
            let scaled = source.pixels().flat_map(|pixel| {
                let [x, y, z] = pixel.0.map(|value| 2.0 * value - 1.0);
                let normal = glam::Vec3::new(scale * x, scale * y, z).normalize_or(glam::Vec3::Z);
                normal.to_array().map(|value| unit(0.5 + 0.5 * value))
            });
            let scaled: Option<ImageBuffer<Rgb<u16>, _>> =
                ImageBuffer::from_raw(source.width(), source.height(), scaled.collect());
            DynamicImage::ImageRgb16(scaled.unwrap_or_default())
        }
    }
}
