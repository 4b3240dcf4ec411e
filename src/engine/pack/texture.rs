//! Packs the textures of the scene for the renderer, each once however often it is used.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::{Arc, LazyLock};

use crate::scene::assets::packed_pattern::packed_pattern;
use crate::scene::assets::texture_map::packed_bitmap;
use crate::scene::{Bitmap, Parameter, Texture};
use crate::texture::{self, Checkerboard, Image, TextureId};

/// The textures packed so far.
pub(in crate::engine) struct TexturePacker<'a> {
    /// The pictures that are loaded, and [`no_picture`] for those that failed, by absolute path.
    pictures: &'a dyn Fn(&Path) -> Option<Arc<Image>>,
    known: Vec<Texture>,
    /// The indices in `known` of the textures with each hash.
    places: HashMap<u64, Vec<u32>>,
    packed: Vec<texture::Texture>,
}

/// The replacement of a missing picture: grey, neither black nor white.
static NO_PICTURE: LazyLock<Arc<Image>> = LazyLock::new(|| Arc::new(Image::uniform(0.5)));

/// The replacement of a picture that cannot be read.
pub(in crate::engine) fn no_picture() -> Arc<Image> {
    NO_PICTURE.clone()
}

impl<'a> TexturePacker<'a> {
    pub fn new(pictures: &'a dyn Fn(&Path) -> Option<Arc<Image>>) -> Self {
        Self {
            pictures,
            known: Vec::new(),
            places: HashMap::new(),
            packed: Vec::new(),
        }
    }

    /// The packed parameter for this texture.
    pub fn parameter<T>(&mut self, texture: &Texture) -> texture::Parameter<T> {
        texture::Parameter::Texture(self.id(texture))
    }

    fn id(&mut self, texture: &Texture) -> TextureId {
        let alike = alike(texture);
        let known = self.places.get(&alike).into_iter().flatten();
        if let Some(&place) = known.into_iter().find(|&&place| self.known[place as usize] == *texture) {
            return TextureId(place);
        }
        // Nested textures come before the one that refers to them.
        let packed = match texture {
            Texture::Bitmap(bitmap) => texture::Texture::Bitmap(self.bitmap(bitmap)),
            Texture::Checkerboard { color0, color1, to_uv } => texture::Texture::Checkerboard(Checkerboard {
                colors: [self.packed(color0), self.packed(color1)],
                to_uv: **to_uv,
            }),
            Texture::MeshAttribute { name, scale, times } => texture::Texture::MeshAttribute(texture::MeshAttribute {
                name: name.as_str().into(),
                scale: *scale,
                times: times.as_deref().map(|times| self.id(times)),
            }),
            Texture::Pattern(pattern) => packed_pattern(pattern, &mut |nested| self.id(nested)),
        };
        let place = self.packed.len() as u32;
        self.known.push(texture.clone());
        self.packed.push(packed);
        self.places.entry(alike).or_default().push(place);
        TextureId(place)
    }

    /// The packed parameter: the constant itself, or the texture.
    pub fn packed<T: Copy>(&mut self, parameter: &Parameter<T>) -> texture::Parameter<T> {
        match parameter {
            Parameter::Constant(value) => texture::Parameter::Constant(*value),
            Parameter::Texture(texture) => self.parameter(texture),
        }
    }

    /// A picture; None while it is not loaded.
    pub fn picture(&self, path: &Path) -> Option<Arc<Image>> {
        (self.pictures)(path)
    }

    /// Width over height of a picture; 1 for other parameters.
    pub fn aspect<T>(&self, parameter: &Parameter<T>) -> f32 {
        let image = match parameter {
            Parameter::Texture(Texture::Bitmap(bitmap)) => self.picture(&bitmap.path),
            _ => None,
        };
        image.map_or(1.0, |image| image.width() as f32 / image.height() as f32)
    }

    fn bitmap(&self, bitmap: &Bitmap) -> texture::Bitmap {
        let image = (self.pictures)(&bitmap.path).unwrap_or_else(no_picture);
        packed_bitmap(bitmap, image)
    }

    pub fn finish(self) -> Vec<texture::Texture> {
        self.packed
    }
}

/// A hash for which equal textures agree and few others do.
fn alike(texture: &Texture) -> u64 {
    let mut hasher = DefaultHasher::new();
    texture.plugin().hash(&mut hasher);
    if let Texture::Pattern(pattern) = texture {
        // Equal patterns have equal texts, and most others differ in their numbers.
        format!("{pattern:?}").hash(&mut hasher);
    }
    match texture {
        Texture::Bitmap(bitmap) => bitmap.path.hash(&mut hasher),
        Texture::MeshAttribute { name, .. } => name.hash(&mut hasher),
        Texture::Checkerboard { .. } | Texture::Pattern(_) => {}
    }
    hasher.finish()
}
