//! Open cylinders that emit, circular or not. They are sampled uniformly in angle and height, which is uniform in area
//! for circular ones.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3, Vec3A};

use super::hit::{AreaSample, SurfaceHit, axes, solid_angle_pdf};
use crate::math::{Real, Vector, sin_cos};

#[derive(Clone, Debug)]
pub(super) struct CylinderLight {
    world_from_local: Affine3A,
    local_from_world: Affine3A,
    /// The emitting side: 1 outwards, -1 inwards.
    side: f32,
}

impl CylinderLight {
    pub fn new(world_from_local: Affine3A, local_from_world: Affine3A, side: f32) -> Self {
        Self {
            world_from_local,
            local_from_world,
            side,
        }
    }

    /// The area. It is exact for circular cylinders, and by Ramanujan's circumference of an ellipse for others; only
    /// the choice between lights depends on it.
    pub fn area(&self) -> f32 {
        let axis = self.world_from_local.matrix3.z_axis;
        let length = axis.length();
        // The parts of the other two axes that are perpendicular to the first span the cross-section.
        let across = |v: Vec3A| v.cross(axis) / length;
        let (x, y) = (
            across(self.world_from_local.matrix3.x_axis),
            across(self.world_from_local.matrix3.y_axis),
        );
        let (sum, product) = (x.length_squared() + y.length_squared(), x.cross(y).length());
        // The half axes from the sum of their squares and their product.
        let (plus, minus) = ((sum + 2.0 * product).sqrt(), (sum - 2.0 * product).max(0.0).sqrt());
        let h = (minus / plus).powi(2);
        0.5 * TAU * plus * length * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()))
    }

    /// Density per area at the local angle with this cosine and sine.
    #[inline(always)]
    fn pdf_around<R: Real>(&self, cos: R, sin: R) -> R {
        let [x, y, z] = axes(&self.world_from_local).map(R::Vec3::same);
        let across = (y * cos - x * sin).cross(z);
        R::ONE / (R::splat(TAU) * across.length_squared().sqrt())
    }

    /// The point of the axis at the fraction `height` of the height.
    pub fn on_axis(&self, height: f32) -> Vec3 {
        self.world_from_local.transform_point3(Vec3::new(0.0, 0.0, height))
    }

    /// A point that is uniform in angle and height.
    #[inline(always)]
    pub fn sample_area<R: Real>(&self, [u, v]: [R; 2]) -> AreaSample<R> {
        let (sin, cos) = sin_cos(R::splat(TAU) * u);
        let around = R::Vec3::of(cos, sin, R::ZERO);
        let normal = around.coordinates(axes(&self.local_from_world)).normalize();
        AreaSample {
            position: R::Vec3::same(self.world_from_local.translation.into())
                + around.with_third(v).along(axes(&self.world_from_local)),
            normal: normal * R::splat(self.side),
            pdf_area: self.pdf_around(cos, sin),
        }
    }

    pub fn pdf(&self, reference: Vec3, hit: &SurfaceHit) -> f32 {
        solid_angle_pdf(self.pdf_area(hit.position), hit.position, hit.normal, reference)
    }

    /// Density per area of [`Self::sample_area`].
    pub fn pdf_area(&self, position: Vec3) -> f32 {
        let local = self.local_from_world.transform_point3(position);
        let Vec2 { x, y } = local.truncate().normalize_or_zero();
        self.pdf_around(x, y)
    }
}
