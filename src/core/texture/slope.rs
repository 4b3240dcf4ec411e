//! Derivatives of textures, for bump maps.

use glam::{Vec2, Vec3};

use super::pattern::stretch;
use super::{BoxProjection, Parameter, Texture, TextureId, TexturePoint, TextureTable};
use crate::color::Rgb;

/// The step of uv for textures inside others that have no detail of their own.
const COARSE: f32 = 1e-3;

impl TextureTable {
    /// The derivative of [`Self::float`] by u and v, in units per unit of uv, for bump maps. Zero for checkerboards,
    /// bitmaps that are not bilinear and mesh attributes, as in Mitsuba. That of patterns is a quotient of differences.
    pub(crate) fn gradient(&self, parameter: Parameter<f32>, at: &TexturePoint) -> Vec2 {
        let Parameter::Texture(id) = parameter else {
            return Vec2::ZERO;
        };
        match &self.textures[id.0 as usize] {
            Texture::Bitmap(bitmap) => bitmap.gradient(at.uv),
            Texture::Checkerboard(_) | Texture::MeshAttribute(_) => Vec2::ZERO,
            Texture::BoxProjection(projection) => self.projected_gradient(projection, at),
            _ => self.difference(id, at),
        }
    }

    /// The gradient along the sides of the box, as derivatives by the surface's own coordinates: the chain rule.
    fn projected_gradient(&self, projection: &BoxProjection, at: &TexturePoint) -> Vec2 {
        let Parameter::Texture(input) = projection.input else {
            return Vec2::ZERO;
        };
        let inner = self.gradient(Parameter::Texture(input), &projection.point(at));
        let by_box = projection.to_uv.matrix2.transpose() * inner;
        let Some(object) = at.object else {
            return by_box;
        };
        let [u, v] = object.project(projection.up).1;
        let in_world: Vec3 = by_box.x * u + by_box.y * v;
        Vec2::from(object.derivatives.map(|derivative| in_world.dot(derivative)))
    }

    fn difference(&self, id: TextureId, at: &TexturePoint) -> Vec2 {
        // A step below the rounding of uv would show that rounding.
        let least = 1e-5 * at.uv.abs().max_element().max(1e-2);
        let step = self.step(Parameter::Texture(id)).min(COARSE).max(least);
        let value = |offset: Vec2| {
            let uv = at.uv + step * offset;
            self.float_of(id, &TexturePoint { uv, ..*at })
        };
        let (u, v) = (value(Vec2::X) - value(Vec2::NEG_X), value(Vec2::Y) - value(Vec2::NEG_Y));
        Vec2::new(u, v) / (2.0 * step)
    }

    /// The step of uv that shows the finest detail of a texture and those inside it; infinite without any.
    fn step(&self, parameter: Parameter<Rgb>) -> f32 {
        let Parameter::Texture(id) = parameter else {
            return f32::INFINITY;
        };
        let finest = |parameters: &[Parameter<Rgb>]| {
            let steps = parameters.iter().map(|parameter| self.step(*parameter));
            steps.fold(f32::INFINITY, f32::min)
        };
        match &self.textures[id.0 as usize] {
            Texture::Noise(noise) => noise.step().min(finest(&noise.colors)),
            Texture::Cells(cells) => cells.step().min(finest(&cells.colors)),
            Texture::Bricks(bricks) => {
                let [a, b] = bricks.colors;
                // Textures of bricks are in lengths of the pattern.
                let inside = finest(&[a, b]) / stretch(&bricks.to_uv);
                bricks.step().min(inside).min(finest(&[bricks.joint_color]))
            }
            Texture::Wood(wood) => wood.step().min(finest(&wood.colors)),
            Texture::Ramp(ramp) => ramp.input.map_or(ramp.step(), |input| finest(&[input])),
            Texture::Mix(mix) => finest(&[mix.colors[0], mix.colors[1], mix.weight]),
            Texture::BoxProjection(projection) => finest(&[projection.input]) / stretch(&projection.to_uv),
            Texture::Checkerboard(checkerboard) => finest(&checkerboard.colors),
            Texture::Bitmap(_) | Texture::MeshAttribute(_) => f32::INFINITY,
        }
    }
}
