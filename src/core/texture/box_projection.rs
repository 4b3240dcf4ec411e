//! Textures laid on shapes from the six sides of a box, in lengths of the scene.

use glam::{Affine2, Affine3A, Vec2, Vec3};

use super::{Parameter, TexturePoint};
use crate::color::Rgb;

/// A texture that is looked up by the place on the shape instead of by uv.
///
/// The box has the axes of the shape, and its coordinates are lengths of the world along these from the origin of the
/// shape: its scale does not stretch the texture. A sheared shape shears it. Of the six sides that counts which the
/// geometric normal faces most. On the sides v points upwards; above and below, u and v are two of the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxProjection {
    /// The texture before this one in the table, or a constant.
    pub input: Parameter<Rgb>,
    /// The direction in the world that is up.
    pub up: Up,
    /// The transform of the coordinates, before those of the texture itself.
    pub to_uv: Affine2,
}

declare_names! {
    /// The direction in the world that is up.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Up {
        /// The y axis.
        #[default]
        Y = "y",
        /// The z axis.
        Z = "z",
    }
}

impl BoxProjection {
    /// The point at which the input is looked up.
    pub(super) fn point<'a>(&self, at: &TexturePoint<'a>) -> TexturePoint<'a> {
        let uv = at.object.map_or(at.uv, |object| object.project(self.up).0);
        TexturePoint {
            uv: self.to_uv.transform_point2(uv),
            mesh: at.mesh,
            object: None,
        }
    }
}

/// A point on a shape, for box projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectPoint {
    /// The place along each of `axes` from the shape's origin, in lengths of the world.
    pub place: Vec3,
    /// The directions of the shape's own axes in the world, unit vectors.
    pub axes: [Vec3; 3],
    /// The derivatives of `place` by the position in the world. They are the axes unless the shape is sheared.
    pub gradients: [Vec3; 3],
    /// The geometric normal in the world.
    pub normal: Vec3,
    /// The derivatives of the point in the world by the surface's own u and v.
    pub derivatives: [Vec3; 2],
}

/// Among sides that a normal faces alike the earlier axis is taken, so that rounding does not decide.
const PREFERENCE: [f32; 3] = [1.0, 0.9999, 0.9998];

impl ObjectPoint {
    /// The point `position` of a shape with this transform, where the geometric normal is `normal` and the derivatives
    /// of the point by u and v are `derivatives`, all in the world.
    pub fn new(world_from_shape: &Affine3A, position: Vec3, normal: Vec3, derivatives: [Vec3; 2]) -> Self {
        let columns = world_from_shape.matrix3.to_cols_array_2d().map(Vec3::from);
        let axes = columns.map(Vec3::normalize_or_zero);
        let lengths = columns.map(Vec3::length);
        let inverse = world_from_shape.inverse();
        let local = inverse.transform_point3(position);
        let rows = inverse.matrix3.transpose().to_cols_array_2d().map(Vec3::from);
        // A flat transform has no inverse.
        let is_flat = !(local.is_finite() && rows.iter().all(|row| row.is_finite()));
        Self {
            place: match is_flat {
                true => Vec3::ZERO,
                false => Vec3::from(lengths) * local,
            },
            axes,
            gradients: match is_flat {
                true => axes,
                false => std::array::from_fn(|axis| lengths[axis] * rows[axis]),
            },
            normal,
            derivatives,
        }
    }

    /// The point that lies this far along the surface's u and v, on the same side of the box.
    pub(super) fn moved(&self, step: Vec2) -> Self {
        let [u, v] = self.derivatives;
        let way = step.x * u + step.y * v;
        Self {
            place: self.place + Vec3::from(self.gradients.map(|gradient| gradient.dot(way))),
            ..*self
        }
    }

    /// The number of the shape's axis that is nearest to the vertical, and whether it points down.
    pub fn upright(&self, up: Up) -> (usize, bool) {
        let upwards = match up {
            Up::Y => Vec3::Y,
            Up::Z => Vec3::Z,
        };
        let upright = nearest(&self.axes, upwards);
        (upright, self.axes[upright].dot(upwards) < 0.0)
    }

    /// The coordinates on the side that the point is on, and their derivatives by the position in the world.
    pub fn project(&self, up: Up) -> (Vec2, [Vec3; 2]) {
        // The sides of a sheared box are perpendicular to the gradients.
        let across = self.gradients.map(Vec3::normalize_or_zero);
        let side = nearest(&across, self.normal);
        let (vertical, is_down) = match self.upright(up) {
            // On level sides there is no upright direction.
            (upright, _) if upright == side => ([2, 2, 1][side], false),
            found => found,
        };
        let horizontal = 3 - side - vertical;
        let v = if is_down { -1.0 } else { 1.0 };
        // Seen from outside, u grows to the right.
        let right = (v * self.axes[vertical]).cross(self.normal);
        let u = if self.axes[horizontal].dot(right) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let uv = Vec2::new(u * self.place[horizontal], v * self.place[vertical]);
        (uv, [u * self.gradients[horizontal], v * self.gradients[vertical]])
    }
}

/// The direction of three that is nearest to another or its opposite.
fn nearest(directions: &[Vec3; 3], other: Vec3) -> usize {
    let nearness = |axis: usize| PREFERENCE[axis] * other.dot(directions[axis]).abs();
    let nearer = |best: usize, axis: usize| if nearness(axis) > nearness(best) { axis } else { best };
    (1..3).fold(0, nearer)
}
