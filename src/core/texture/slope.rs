//! Derivatives of textures, for bump maps.
//!
//! The slope is that along the surface: the whole point of the look-up moves by a step of the surface's u or v, its uv
//! as well as its place on the shape, and each texture turns the step into its own coordinates.

use glam::{Affine2, Mat2, Vec2, Vec3};

use super::pattern::stretch;
use super::{BoxProjection, ObjectPoint, Parameter, Texture, TextureId, TexturePoint, TextureTable};
use crate::color::Rgb;

/// The least step, as a share of the numbers from which coordinates are computed. Smaller ones would show rounding.
const LEAST: f32 = 1e-5;

/// The step inside a square of a checkerboard and inside a texel, as a share of their extents.
const STEP_OF_SQUARE: f32 = 1.0 / 32.0;

/// How the coordinates of a texture change along the surface.
#[derive(Clone, Copy)]
struct Change {
    /// The derivatives of the coordinates by the surface's u and v, in its columns.
    by_surface: Mat2,
    /// The largest number from which the coordinates are computed, in their unit: the rounding is a share of it.
    size: f32,
    /// The place on the shape, outside of box projections.
    object: Option<ObjectPoint>,
}

impl Change {
    fn of_surface(at: &TexturePoint) -> Self {
        Self {
            by_surface: Mat2::IDENTITY,
            size: at.uv.abs().max_element(),
            object: at.object,
        }
    }

    /// The change of the coordinates after a map.
    fn mapped(&self, map: &Affine2) -> Self {
        Self {
            by_surface: map.matrix2 * self.by_surface,
            size: (stretch(map) * self.size).max(map.translation.abs().max_element()),
            ..*self
        }
    }

    /// The change of the coordinates inside a box projection.
    fn in_box(&self, projection: &BoxProjection) -> Self {
        let on_side = match &self.object {
            Some(object) => {
                let gradients = object.project(projection.up).1;
                Self {
                    by_surface: Mat2::from_cols_array_2d(
                        &object
                            .derivatives
                            .map(|derivative| gradients.map(|gradient| gradient.dot(derivative))),
                    ),
                    size: object.place.abs().max_element(),
                    object: None,
                }
            }
            None => *self,
        };
        on_side.mapped(&projection.to_uv)
    }

    /// The steps of the surface's u and v over which the coordinates move by `detail`, or by more where that is below
    /// their rounding; infinite where they do not move.
    fn steps(&self, detail: f32) -> Vec2 {
        let rates = Vec2::new(self.by_surface.x_axis.length(), self.by_surface.y_axis.length());
        Vec2::splat(detail.max(LEAST * self.size)) / rates
    }
}

impl TextureTable {
    /// The derivative of [`Self::float`] by the surface's u and v, in units per unit of uv, for bump maps. Zero for
    /// checkerboards, bitmaps that are not bilinear and mesh attributes, as in Mitsuba. That of patterns is a quotient
    /// of differences.
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
        let steps = self.steps(Parameter::Texture(id), &Change::of_surface(at));
        let slope = |step: f32, along: Vec2| {
            if !(step > 0.0 && step.is_finite()) {
                return 0.0;
            }
            let value = |offset: f32| self.float_of(id, &at.moved(offset * along));
            (value(step) - value(-step)) / (2.0 * step)
        };
        Vec2::new(slope(steps.x, Vec2::X), slope(steps.y, Vec2::Y))
    }

    /// The steps of the surface's u and v that show the finest detail of a texture and those inside it; infinite
    /// without any.
    fn steps(&self, parameter: Parameter<Rgb>, change: &Change) -> Vec2 {
        let Parameter::Texture(id) = parameter else {
            return Vec2::INFINITY;
        };
        let finest = |parameters: &[Parameter<Rgb>], change: &Change| {
            let steps = parameters.iter().map(|parameter| self.steps(*parameter, change));
            steps.fold(Vec2::INFINITY, Vec2::min)
        };
        let own = |map: &Affine2, detail: f32| change.mapped(map).steps(detail);
        match &self.textures[id.0 as usize] {
            Texture::Noise(noise) => own(&noise.to_uv, noise.step()).min(finest(&noise.colors, change)),
            Texture::Cells(cells) => own(&cells.to_uv, cells.step()).min(finest(&cells.colors, change)),
            Texture::Bricks(bricks) => {
                let plane = change.mapped(&bricks.to_uv);
                let on_brick = Change {
                    size: plane.size.max(bricks.farthest()),
                    ..plane
                };
                let inside = finest(&bricks.colors, &on_brick);
                plane
                    .steps(bricks.step())
                    .min(inside)
                    .min(finest(&[bricks.joint_color], change))
            }
            Texture::Wood(wood) => own(&wood.to_uv, wood.step()).min(finest(&wood.colors, change)),
            Texture::Ramp(ramp) => match ramp.input {
                Some(input) => ramp.narrowest() * finest(&[input], change),
                None => own(&ramp.to_uv, ramp.step()),
            },
            Texture::Mix(mix) => finest(&[mix.colors[0], mix.colors[1], mix.weight], change),
            Texture::BoxProjection(projection) => finest(&[projection.input], &change.in_box(projection)),
            Texture::Checkerboard(checkerboard) => {
                let square = own(&checkerboard.to_uv, 0.5 * STEP_OF_SQUARE);
                square.min(finest(&checkerboard.colors, change))
            }
            Texture::Bitmap(bitmap) => own(&bitmap.to_uv, STEP_OF_SQUARE * bitmap.texel_extent()),
            Texture::MeshAttribute(attribute) => finest(attribute.times.map(Parameter::Texture).as_slice(), change),
        }
    }
}

#[cfg(test)]
mod tests;
