//! A picture loaded from a file, for textures and environments.

use std::path::Path;
use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;

use crate::files::{Access, FileError};
use crate::memory;
use crate::scene::{Bitmap, SceneAccess, TextureFilter, TextureWrap};
use crate::texture::{self, Filter, Image, ImageFileError, Wrap, load_image};

/// A texture of the scene as lookups have it, with its picture.
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
    /// The number of pixels that have a channel below zero; as light these channels count as zero.
    pub negative_pixels: usize,
}

/// Reads every kind of picture, which it recognises by the content.
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
            "png", "jpg", "jpeg", "bmp", "tga", "ppm", "pgm", "pnm", "exr", "hdr", "rgbe", "pfm",
        ]
    }
}

/// A picture file of any kind, read from the disk if `access` permits.
pub(crate) fn load_picture(path: &Path, access: &Access) -> Result<TextureMap, TextureMapError> {
    let bytes = memory::read_data(path, access)?;
    let image = Arc::new(load_image(&bytes)?);
    Ok(TextureMap {
        negative_pixels: image.negative_pixels(),
        image,
    })
}
