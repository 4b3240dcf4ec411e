//! Values that vary over a surface: the contract of all textures, and the dispatch to them.
//!
//! A texture maps a [`TexturePoint`] to a colour (linear Rec. 709) or a number. Parameters of materials and lights are
//! either constant or name a texture of the scene's [`TextureTable`]; light transport sees numbers only.

mod bitmap;
mod box_projection;
mod checkerboard;
mod exr_color;
mod exr_file;
mod image;
mod image_file;
mod image_header;
mod jpeg_file;
mod mesh_attribute;
pub mod pattern;
mod pfm_file;
mod profile_file;
mod slope;
mod value;

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::color::{Rgb, luminance};
use crate::geometry::mesh::MeshData;

pub use bitmap::{Bitmap, Filter, Wrap};
pub use box_projection::{BoxProjection, ObjectPoint, Up};
pub use checkerboard::Checkerboard;
pub(crate) use exr_file::{is_exr, read_exr_parts, reserve_exr};
pub use image::{Image, Samples, Transfer};
pub(crate) use image_file::decode_picture;
pub use image_file::load_image;
pub use image_header::ImageFileError;
pub use mesh_attribute::MeshAttribute;
pub use pattern::{Bricks, Cells, Mix, Noise, Ramp, Wood};
pub(crate) use value::TextureValue;

/// An index into a [`TextureTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TextureId(pub u32);

/// A parameter that is constant or textured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter<T> {
    /// The value of a constant parameter.
    Constant(T),
    /// A texture of the scene's table.
    Texture(TextureId),
}

/// The point at which a texture is looked up.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint<'a> {
    /// Surface coordinates, before the texture's own transform.
    pub uv: Vec2,
    /// The point on the mesh, if the surface is one, at which mesh attributes are interpolated.
    pub mesh: Option<MeshPoint<'a>>,
    /// The place on the shape for box projection; None where there is no shape, and if no texture of the scene needs
    /// it. Box projections then take uv.
    pub object: Option<ObjectPoint>,
}

impl TexturePoint<'_> {
    /// A point without a mesh and without a place on a shape.
    pub fn of_uv(uv: Vec2) -> Self {
        Self {
            uv,
            mesh: None,
            object: None,
        }
    }

    /// The point that lies this far along the surface's u and v. Values of meshes stay those of this point.
    fn moved(&self, step: Vec2) -> Self {
        Self {
            uv: self.uv + step,
            object: self.object.map(|object| object.moved(step)),
            ..*self
        }
    }
}

/// A point on a triangle of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct MeshPoint<'a> {
    /// The mesh whose attributes may be looked up.
    pub mesh: &'a MeshData,
    /// Index into the mesh's triangles.
    pub triangle: u32,
    /// Weights of the triangle's corners; their sum is 1.
    pub barycentric: Vec3,
}

/// A texture with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// A picture over uv.
    Bitmap(Bitmap),
    /// Two alternating values over uv.
    Checkerboard(Checkerboard),
    /// Values stored with a mesh.
    MeshAttribute(MeshAttribute),
    /// Gradient noise.
    Noise(Noise),
    /// Cells around scattered points.
    Cells(Cells),
    /// Bricks, tiles and boards with joints.
    Bricks(Bricks),
    /// The grain of wood.
    Wood(Wood),
    /// Colours by a value.
    Ramp(Ramp),
    /// Two textures by a third.
    Mix(Mix),
    /// Another texture by the place on the shape.
    BoxProjection(BoxProjection),
}

/// All textures of a scene. A texture may only refer to others before it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextureTable {
    textures: Vec<Texture>,
    /// Whether any of them is a box projection.
    projects: bool,
}

impl TextureTable {
    /// A table whose [`TextureId`]s are the positions in `textures`.
    pub fn new(textures: Vec<Texture>) -> Self {
        let projects = textures
            .iter()
            .any(|texture| matches!(texture, Texture::BoxProjection(_)));
        Self { textures, projects }
    }

    /// The same table with one more texture, and the id of that.
    pub fn with(&self, texture: Texture) -> (Self, TextureId) {
        let id = TextureId(self.textures.len() as u32);
        (Self::new(self.textures.iter().cloned().chain([texture]).collect()), id)
    }

    /// Whether any texture asks for the place on the shape.
    pub(crate) fn projects(&self) -> bool {
        self.projects
    }

    /// The number of pictures, and the bytes of memory that they take. A picture that several textures share counts
    /// once.
    pub fn pictures(&self) -> (usize, u64) {
        let mut pictures: HashMap<*const Image, u64> = HashMap::new();
        for texture in &self.textures {
            if let Texture::Bitmap(bitmap) = texture {
                pictures.insert(Arc::as_ptr(&bitmap.image), bitmap.image.memory_bytes());
            }
        }
        (pictures.len(), pictures.values().sum())
    }

    /// Returns the texture of an id; None for an id of another table.
    pub fn get(&self, id: TextureId) -> Option<&Texture> {
        self.textures.get(id.0 as usize)
    }

    /// The parameter's colour at a point, linear Rec. 709. A grey texture gives three equal components.
    pub fn color(&self, parameter: Parameter<Rgb>, at: &TexturePoint) -> Rgb {
        match parameter {
            Parameter::Constant(color) => color,
            Parameter::Texture(id) => self.color_of(id, at),
        }
    }

    /// The parameter as emitted light: negative colours, which pixels of EXR and PFM pictures may have, are black.
    pub fn light(&self, parameter: Parameter<Rgb>, at: &TexturePoint) -> Rgb {
        self.color(parameter, at).max(Rgb::ZERO)
    }

    /// The parameter's number at a point. A colour picture gives its luminance; a colour inside another texture gives
    /// its mean, as a single colour does when a scene is read.
    pub fn float(&self, parameter: Parameter<f32>, at: &TexturePoint) -> f32 {
        match parameter {
            Parameter::Constant(number) => number,
            Parameter::Texture(id) => self.float_of(id, at),
        }
    }

    /// Average colour over uv.
    pub(crate) fn mean_color(&self, parameter: Parameter<Rgb>) -> Rgb {
        match parameter {
            Parameter::Constant(color) => color,
            Parameter::Texture(id) => match &self.textures[id.0 as usize] {
                Texture::Bitmap(bitmap) => bitmap.mean(),
                Texture::Checkerboard(checkerboard) => {
                    let [a, b] = checkerboard.colors.map(|color| self.mean_color(color));
                    0.5 * (a + b)
                }
                Texture::MeshAttribute(attribute) => {
                    let times = attribute.times.map(Parameter::Texture);
                    attribute.mean() * times.map_or(Rgb::ONE, |times| self.mean_color(times))
                }
                _ => self.sampled_mean(id),
            },
        }
    }

    /// The mean of a few points of the unit square.
    fn sampled_mean(&self, id: TextureId) -> Rgb {
        const SIDE: u32 = 16;
        let place = |i: u32| Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32;
        let places = (0..SIDE * SIDE).map(|i| TexturePoint::of_uv(place(i)));
        places.map(|at| self.color_of(id, &at)).sum::<Rgb>() / (SIDE * SIDE) as f32
    }

    fn color_of(&self, id: TextureId, at: &TexturePoint) -> Rgb {
        match &self.textures[id.0 as usize] {
            Texture::Bitmap(bitmap) => bitmap.color(at.uv),
            Texture::Checkerboard(checkerboard) => self.color(checkerboard.color(at.uv), at),
            Texture::MeshAttribute(attribute) => {
                let times = attribute.times.map_or(Rgb::ONE, |times| self.color_of(times, at));
                times * attribute.color(at.mesh)
            }
            other => self.pattern(other, at),
        }
    }

    fn float_of(&self, id: TextureId, at: &TexturePoint) -> f32 {
        match &self.textures[id.0 as usize] {
            Texture::Checkerboard(checkerboard) => f32::nested(self, checkerboard.number(at.uv), at),
            Texture::Bitmap(_) | Texture::MeshAttribute(_) => luminance(self.color_of(id, at)),
            other => self.pattern(other, at),
        }
    }

    /// The value of a texture that treats colours and numbers alike.
    fn pattern<V: TextureValue>(&self, texture: &Texture, at: &TexturePoint) -> V {
        match texture {
            Texture::Noise(noise) => noise.value(self, at),
            Texture::Cells(cells) => cells.value(self, at),
            Texture::Bricks(bricks) => bricks.value(self, at),
            Texture::Wood(wood) => wood.value(self, at),
            Texture::Ramp(ramp) => ramp.value(self, at),
            Texture::Mix(mix) => mix.value(self, at),
            Texture::BoxProjection(projection) => V::nested(self, projection.input, &projection.point(at)),
            Texture::Bitmap(_) | Texture::Checkerboard(_) | Texture::MeshAttribute(_) => V::of_color(Rgb::ZERO),
        }
    }
}
