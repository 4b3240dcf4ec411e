//! Textures of the scene as those of the renderer, each once however often it is used.

use crate::color::Rgb;
use crate::scene::{Parameter, Texture};
use crate::texture::{self, Checkerboard, TextureId};

/// The textures met so far.
#[derive(Default)]
pub(in crate::engine) struct TexturePacker {
    known: Vec<Texture>,
    packed: Vec<texture::Texture>,
}

impl TexturePacker {
    /// What a parameter that is this texture becomes.
    pub fn parameter<T>(&mut self, texture: &Texture) -> texture::Parameter<T> {
        if let Some(place) = self.known.iter().position(|known| known == texture) {
            return texture::Parameter::Texture(TextureId(place as u32));
        }
        // Those inside come before the one that refers to them.
        let packed = match texture {
            Texture::Checkerboard { color0, color1, to_uv } => texture::Texture::Checkerboard(Checkerboard {
                colors: [self.color(color0), self.color(color1)],
                to_uv: *to_uv,
            }),
        };
        self.known.push(texture.clone());
        self.packed.push(packed);
        texture::Parameter::Texture(TextureId(self.packed.len() as u32 - 1))
    }

    fn color(&mut self, color: &Parameter<Rgb>) -> texture::Parameter<Rgb> {
        match color {
            Parameter::Constant(color) => texture::Parameter::Constant(*color),
            Parameter::Texture(texture) => self.parameter(texture),
        }
    }

    pub fn finish(self) -> Vec<texture::Texture> {
        self.packed
    }
}
