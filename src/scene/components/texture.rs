//! Textures, and parameters that may be one. They are values: a texture that several materials share is copied in each.

use std::path::PathBuf;

use bevy::math::Affine2;
use bevy::prelude::*;

use super::declare::declare_plugin_type;
use super::pattern::{Choice, Stop, with_patterns};
use crate::color::Rgb;

/// A parameter that is constant or varies over the surface.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Parameter<T> {
    /// The same value everywhere.
    Constant(T),
    /// A value that varies over the surface.
    Texture(Texture),
}

/// A picture that replaces a value or another picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChosenPicture {
    /// The absolute path.
    pub path: PathBuf,
    /// The transform of uv if there was no picture before.
    pub to_uv: Affine2,
}

impl<P: Into<PathBuf>> From<P> for ChosenPicture {
    /// The picture with the identity as uv transform.
    fn from(path: P) -> Self {
        Self {
            path: path.into(),
            to_uv: Affine2::IDENTITY,
        }
    }
}

impl<T> Parameter<T> {
    /// Sets the picture. It keeps the filter and wrapping of the picture before it.
    pub fn set_picture(&mut self, picture: ChosenPicture) {
        let before = match self {
            Self::Constant(_) => None,
            Self::Texture(texture) => Some(&*texture),
        };
        let mut texture = Texture::of_picture(picture.path, before);
        if !matches!(before, Some(Texture::Bitmap(_)))
            && let Texture::Bitmap(bitmap) = &mut texture
        {
            bitmap.to_uv = picture.to_uv;
        }
        *self = Self::Texture(texture);
    }

    /// Sets the picture at a place within the texture. A place that does not exist changes nothing.
    pub fn set_picture_at(&mut self, place: SquarePath, picture: ChosenPicture) {
        let Some((square, rest)) = place.split() else {
            return self.set_picture(picture);
        };
        if let Self::Texture(texture) = self {
            texture.for_nested(square, &mut |nested| nested.set_picture_at(rest, picture.clone()));
        }
    }
}

/// A place within nested textures: the choices among the parameters of each that may be textures, outermost first, as
/// octal digits below a leading one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SquarePath(u64);

/// The bits of a digit.
const DIGIT: u32 = 3;

impl SquarePath {
    /// The parameter itself.
    pub const WHOLE: Self = Self(1);

    /// The parameter number `square` of the texture at this place, as the two colours (0 and 1) of a checkerboard.
    /// Places beyond 21 textures are not distinguished.
    pub fn within(self, square: u32) -> Self {
        self.0
            .checked_mul(1 << DIGIT)
            .map_or(self, |place| Self(place | u64::from(square)))
    }

    /// The number in the outermost texture, and the place from there; None for the parameter itself.
    fn split(self) -> Option<(u32, Self)> {
        let digits = (self.0.checked_ilog2()? / DIGIT).checked_sub(1)?;
        let leading = 1 << (DIGIT * digits);
        let first = (self.0 >> (DIGIT * digits)) & ((1 << DIGIT) - 1);
        Some((first as u32, Self((self.0 & (leading - 1)) | leading)))
    }
}

impl<T: Copy> Parameter<T> {
    /// The value, if it is the same everywhere.
    pub fn constant(&self) -> Option<T> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Texture(_) => None,
        }
    }
}

impl From<Rgb> for Parameter<Rgb> {
    fn from(color: Rgb) -> Self {
        Self::Constant(color)
    }
}

impl From<f32> for Parameter<f32> {
    fn from(number: f32) -> Self {
        Self::Constant(number)
    }
}

/// A texture of the scene file.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq)]
pub enum Texture {
    /// A picture over uv. Large variants are boxed: every parameter of every material has room for a texture.
    Bitmap(Box<Bitmap>),
    /// A checkerboard of two colours, with two by two squares per unit of uv.
    Checkerboard {
        /// The colour of the square at the origin of uv; for numbers, that of the other squares.
        color0: Box<Parameter<Rgb>>,
        /// The colour of the other squares.
        color1: Box<Parameter<Rgb>>,
        /// The transform that is applied to uv before the look-up.
        to_uv: Box<Affine2>,
    },
    /// An attribute of the mesh, per vertex or face.
    MeshAttribute {
        /// The name given by the mesh's reader: `vertex_color`, `face_...`.
        name: String,
        /// A factor on the value.
        scale: f32,
        /// Another factor, a texture.
        times: Option<Box<Self>>,
    },
    /// A procedural texture.
    Pattern(Box<Pattern>),
}

with_patterns!(declare_plugin_type);

/// A picture with its filter, wrapping and uv transform.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bitmap {
    /// The absolute path.
    pub path: PathBuf,
    /// The interpolation between texel centres.
    pub filter: TextureFilter,
    /// The continuation outside of the unit square along u.
    pub wrap: TextureWrap,
    /// The continuation along v; None means the same as along u, as in the format.
    pub wrap_v: Option<TextureWrap>,
    /// Whether values are used as in the file, not decoded to linear.
    pub raw: bool,
    /// Applied to uv before the look-up.
    pub to_uv: Affine2,
}

impl Bitmap {
    /// The continuation outside of the unit square along u and along v.
    pub fn wraps(&self) -> [TextureWrap; 2] {
        [self.wrap, self.wrap_v.unwrap_or(self.wrap)]
    }
}

declare_names! {
    /// The interpolation between texel centres.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum TextureFilter {
        /// The texel that the point lies in.
        Nearest = "nearest",
        /// Linear between the four texels around the point.
        #[default]
        Bilinear = "bilinear",
    }
}

declare_names! {
    /// The continuation of a picture outside of the unit square.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum TextureWrap {
        /// Repetition of the picture.
        #[default]
        Repeat = "repeat",
        /// Repetition of the picture, every other time mirrored.
        Mirror = "mirror",
        /// The texels of the edge.
        Clamp = "clamp",
    }
}

impl Texture {
    /// A picture with the filter and wrapping of the one before it, if there was one.
    pub fn of_picture(path: PathBuf, before: Option<&Self>) -> Self {
        let mut bitmap = match before {
            Some(Self::Bitmap(bitmap)) => bitmap.clone(),
            _ => Box::default(),
        };
        bitmap.path = path;
        Self::Bitmap(bitmap)
    }

    /// The plugin's name in the file.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Bitmap(_) => "bitmap",
            Self::Checkerboard { .. } => "checkerboard",
            Self::MeshAttribute { .. } => "mesh_attribute",
            Self::Pattern(pattern) => pattern.plugin(),
        }
    }

    /// Calls `meet` with every texture directly inside it.
    pub(crate) fn for_each_nested<'t>(&'t self, meet: &mut dyn FnMut(&'t Self)) {
        match self {
            Self::Bitmap(_) => {}
            Self::Checkerboard { color0, color1, .. } => {
                for color in [color0, color1] {
                    if let Parameter::Texture(texture) = &**color {
                        meet(texture);
                    }
                }
            }
            Self::MeshAttribute { times, .. } => times.iter().for_each(|times| meet(times)),
            Self::Pattern(pattern) => pattern.for_each_nested(meet),
        }
    }

    /// Calls `meet` with every texture directly inside it, mutable.
    pub(crate) fn for_each_nested_mut(&mut self, meet: &mut dyn FnMut(&mut Self)) {
        match self {
            Self::Bitmap(_) => {}
            Self::Checkerboard { color0, color1, .. } => {
                for color in [color0, color1] {
                    if let Parameter::Texture(texture) = &mut **color {
                        meet(texture);
                    }
                }
            }
            Self::MeshAttribute { times, .. } => times.iter_mut().for_each(|times| meet(times)),
            Self::Pattern(pattern) => pattern.for_each_nested_mut(meet),
        }
    }

    /// Calls `meet` with the parameter of this number among those that may be textures.
    fn for_nested(&mut self, number: u32, meet: &mut dyn FnMut(&mut Parameter<Rgb>)) {
        match self {
            Self::Bitmap(_) => {}
            Self::Checkerboard { color0, color1, .. } => meet(if number == 0 { color0 } else { color1 }),
            Self::MeshAttribute { times, .. } => {
                if let Some(times) = times {
                    let mut inside = Parameter::Texture((**times).clone());
                    meet(&mut inside);
                    if let Parameter::Texture(changed) = inside {
                        **times = changed;
                    }
                }
            }
            Self::Pattern(pattern) => pattern.for_nested(number, meet),
        }
    }

    /// Calls `meet` with the uv transform of every texture that has one, nested ones included. Inside a box projection,
    /// whose own transform is met, textures have coordinates of their own.
    pub fn for_each_placing(&mut self, meet: &mut dyn FnMut(&mut Affine2)) {
        match self {
            Self::Bitmap(bitmap) => meet(&mut bitmap.to_uv),
            Self::Checkerboard { to_uv, .. } => meet(to_uv),
            Self::MeshAttribute { .. } => {}
            Self::Pattern(pattern) => {
                pattern.for_own_placing(meet);
                if pattern.has_own_coordinates() {
                    return;
                }
            }
        }
        self.for_each_nested_mut(&mut |nested| nested.for_each_placing(meet));
    }

    /// Calls `meet` with the transform and the upward axis of every box projection, nested ones included.
    pub(crate) fn for_each_projection(&mut self, meet: &mut dyn FnMut(&mut Affine2, &mut Choice)) {
        if let Self::Pattern(pattern) = self
            && let Pattern::BoxProjection { to_uv, up, .. } = &mut **pattern
        {
            meet(to_uv, up);
        }
        self.for_each_nested_mut(&mut |nested| nested.for_each_projection(meet));
    }

    /// Calls `meet` with every picture, nested ones included.
    pub fn for_each_bitmap<'t>(&'t self, meet: &mut dyn FnMut(&'t Bitmap)) {
        if let Self::Bitmap(bitmap) = self {
            meet(bitmap);
        }
        self.for_each_nested(&mut |nested| nested.for_each_bitmap(meet));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_get_into_nested_checkerboards() {
        let board = |color0: Parameter<Rgb>, color1: Parameter<Rgb>| Texture::Checkerboard {
            color0: Box::new(color0),
            color1: Box::new(color1),
            to_uv: Box::new(Affine2::IDENTITY),
        };
        let grey = || Parameter::Constant(Rgb::ONE);
        let inner = board(grey(), grey());
        let mut outer = Parameter::<f32>::Texture(board(grey(), Parameter::Texture(inner)));
        let place = SquarePath::WHOLE.within(1).within(0);
        outer.set_picture_at(place, "/a.png".into());
        let picture = Parameter::Texture(Texture::of_picture("/a.png".into(), None));
        let expected = board(grey(), Parameter::Texture(board(picture.clone(), grey())));
        assert_eq!(outer, Parameter::Texture(expected.clone()));
        // A place that does not exist.
        outer.set_picture_at(SquarePath::WHOLE.within(0).within(0), "/b.png".into());
        assert_eq!(outer, Parameter::Texture(expected));
        let mut whole = grey();
        whole.set_picture_at(SquarePath::WHOLE, "/a.png".into());
        assert_eq!(whole, picture);
    }
}
