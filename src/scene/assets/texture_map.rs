//! A picture loaded from a file, for textures and environments.

use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;

use crate::texture::{Image, ImageFileError, load_image};

/// `image` is a new `Arc` after each reload.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct TextureMap {
    pub image: Arc<Image>,
    /// How many pixels have a channel below zero; as light these channels count as zero.
    pub negative_pixels: usize,
}

/// Reads every kind of picture; which it is, the content says.
#[derive(Default, TypePath)]
pub struct TextureMapLoader;

#[derive(Debug, thiserror::Error)]
pub enum TextureMapError {
    #[error(transparent)]
    Io(#[from] std::io::Error),
    #[error(transparent)]
    Image(#[from] ImageFileError),
}

impl AssetLoader for TextureMapLoader {
    type Asset = TextureMap;
    type Settings = ();
    type Error = TextureMapError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        _context: &mut LoadContext<'_>,
    ) -> Result<TextureMap, TextureMapError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let image = Arc::new(load_image(&bytes)?);
        Ok(TextureMap {
            negative_pixels: image.negative_pixels(),
            image,
        })
    }

    fn extensions(&self) -> &[&str] {
        &[
            "png", "jpg", "jpeg", "bmp", "tga", "ppm", "pgm", "pnm", "exr", "hdr", "rgbe", "pfm",
        ]
    }
}
