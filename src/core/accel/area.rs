//! The area of a placed shape.
//!
//! An affine map with the matrix M stretches an area element of the normal n by |cof(M) n| with the cofactors of M.
//! What has no closed form, as for ellipsoids, is integrated.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use super::{Instance, Primitive};

/// The steps of an integral around an axis, and along it.
const STEPS: usize = 256;

impl Instance {
    /// The area of one side of the surface in world space, in f64 to within 0.01 %. Curves, which cannot be lights,
    /// have none.
    pub fn area(&self) -> f64 {
        let matrix = self.world_from_local.matrix3.as_dmat3();
        let cofactors = DMat3::from_cols(
            matrix.y_axis.cross(matrix.z_axis),
            matrix.z_axis.cross(matrix.x_axis),
            matrix.x_axis.cross(matrix.y_axis),
        );
        let stretch = |normal: DVec3| (cofactors * normal).length();
        match &self.primitive {
            Primitive::Rectangle => 4.0 * stretch(DVec3::Z),
            Primitive::Disk => PI * stretch(DVec3::Z),
            Primitive::Cylinder => TAU * around(|x, y| stretch(DVec3::new(x, y, 0.0))),
            Primitive::Sphere => {
                let slice = |index: usize| {
                    let z = (2 * index + 1) as f64 / STEPS as f64 - 1.0;
                    let radius = (1.0 - z * z).sqrt();
                    around(|x, y| stretch(DVec3::new(radius * x, radius * y, z)))
                };
                4.0 * PI * (0..STEPS).map(slice).sum::<f64>() / STEPS as f64
            }
            Primitive::Mesh(blas) => {
                let mesh = blas.mesh();
                let area = |index: usize| {
                    let [a, b, c] = mesh.regular_corners(index)?.map(|corner| corner.as_dvec3());
                    Some(0.5 * stretch((b - a).cross(c - a)))
                };
                (0..mesh.triangles.len()).filter_map(area).sum()
            }
            Primitive::Curves(_) => 0.0,
        }
    }
}

/// The mean of a function of the cosine and sine around a circle.
fn around(value: impl Fn(f64, f64) -> f64) -> f64 {
    let at = |index: usize| {
        let (sin, cos) = (TAU * index as f64 / STEPS as f64).sin_cos();
        value(cos, sin)
    };
    (0..STEPS).map(at).sum::<f64>() / STEPS as f64
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3};

    use super::*;

    fn area(primitive: Primitive, scale: Vec3) -> f64 {
        let instance = Instance::new(primitive, Affine3A::from_scale(scale));
        instance.expect("it can be inverted").area()
    }

    #[test]
    fn areas_follow_their_formulas() {
        let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-4, "{found}, {expected}");
        near(area(Primitive::Rectangle, Vec3::new(2.0, 3.0, 9.0)), 24.0);
        near(area(Primitive::Disk, Vec3::new(2.0, 3.0, 9.0)), 6.0 * PI);
        near(area(Primitive::Sphere, Vec3::splat(-2.0)), 16.0 * PI);
        near(area(Primitive::Cylinder, Vec3::new(2.0, 2.0, 5.0)), 20.0 * PI);
        // A prolate spheroid of the half axes 1, 1 and 2, and a flat one of 2, 2 and 1.
        let sine = 0.75f64.sqrt();
        near(
            area(Primitive::Sphere, Vec3::new(1.0, 1.0, 2.0)),
            TAU * (1.0 + 2.0 / sine * sine.asin()),
        );
        near(
            area(Primitive::Sphere, Vec3::new(2.0, 1.0, 2.0)),
            TAU * 4.0 * (1.0 + 0.25 / sine * sine.atanh()),
        );
    }
}
