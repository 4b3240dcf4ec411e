//! A picture loaded from a file, for textures and environments.

use std::path::Path;
use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;

use crate::color::BRIGHTEST;
use crate::files::{Access, FileError};
use crate::memory;
use crate::scene::{Bitmap, SceneAccess, TextureFilter, TextureWrap};
use crate::texture::{self, Filter, Image, ImageFileError, Wrap, load_image};

/// A bitmap of the scene with its picture, for the texture table.
pub(crate) fn packed_bitmap(bitmap: &Bitmap, image: Arc<Image>) -> texture::Bitmap {
    texture::Bitmap {
        image,
        filter: match bitmap.filter {
            TextureFilter::Nearest => Filter::Nearest,
            TextureFilter::Bilinear => Filter::Bilinear,
        },
        wrap: bitmap.wraps().map(|wrap| match wrap {
            TextureWrap::Repeat => Wrap::Repeat,
            TextureWrap::Mirror => Wrap::Mirror,
            TextureWrap::Clamp => Wrap::Clamp,
        }),
        raw: bitmap.raw,
        to_uv: bitmap.to_uv,
    }
}

/// A picture as an asset. `image` is a new `Arc` after each reload.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct TextureMap {
    /// The picture, with finite samples.
    pub image: Arc<Image>,
    /// The number of pixels with a negative channel; as light these channels count as zero.
    pub negative_pixels: usize,
    /// The number of pixels with a channel that was infinite or NaN, which is now zero.
    pub not_finite: usize,
    /// The number of pixels with a channel that was above [`BRIGHTEST`], which is now its value.
    pub too_bright: usize,
}

impl TextureMap {
    /// A sentence about changed values; None if all are as in the file. Negative pixels matter only to lights.
    pub(crate) fn warning(&self, is_light: bool) -> Option<String> {
        let too_bright = format!("a value above {BRIGHTEST:e}, which takes its place");
        let negative = if is_light { self.negative_pixels } else { 0 };
        let found = [
            (
                self.not_finite,
                "a value that is infinite or no number: zero takes its place",
            ),
            (self.too_bright, too_bright.as_str()),
            (negative, "a negative value, which as light counts as zero"),
        ];
        let found = found.into_iter().filter(|(pixels, _)| *pixels > 0);
        let said = found.map(|(pixels, what)| match pixels {
            1 => format!("1 pixel has {what}"),
            _ => format!("{pixels} pixels have {what}"),
        });
        said.reduce(|one, other| format!("{one}; {other}"))
    }
}

/// Loads pictures of every format, which it recognises by the content.
#[derive(Default, TypePath)]
pub(crate) struct TextureMapLoader {
    pub access: SceneAccess,
}

#[derive(Debug, thiserror::Error)]
pub(crate) enum TextureMapError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Image(#[from] ImageFileError),
}

impl AssetLoader for TextureMapLoader {
    type Asset = TextureMap;
    type Settings = ();
    type Error = TextureMapError;

    async fn load(
        &self,
        _reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<TextureMap, TextureMapError> {
        load_picture(context.path().path(), &self.access.get())
    }

    fn extensions(&self) -> &[&str] {
        &[
            "png", "jpg", "jpeg", "bmp", "tga", "ppm", "pgm", "pnm", "exr", "hdr", "rgbe", "pfm", "ies", "ldt",
        ]
    }
}

/// A picture file of any format, read from the disk if `access` permits.
pub(crate) fn load_picture(path: &Path, access: &Access) -> Result<TextureMap, TextureMapError> {
    let bytes = memory::read_data(path, access)?;
    let mut image = load_image(&bytes)?;
    Ok(TextureMap {
        negative_pixels: image.negative_pixels(),
        not_finite: image.not_finite(),
        too_bright: image.limit(),
        image: Arc::new(image),
    })
}
