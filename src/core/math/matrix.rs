//! Matrices of either form of numbers.

use glam::Mat3A;

use super::{Real, Vector, real_struct};

real_struct! {
    /// A 3 x 3 matrix by its columns.
    pub(crate) struct Matrix<R> {
        pub x: R::Vec3,
        pub y: R::Vec3,
        pub z: R::Vec3,
    }
}

impl<R: Real> Matrix<R> {
    /// The product with a vector.
    #[inline(always)]
    pub fn times(&self, v: R::Vec3) -> R::Vec3 {
        let row = |of: fn(R::Vec3) -> R| v.x().mul_add(of(self.x), v.y().mul_add(of(self.y), v.z() * of(self.z)));
        R::Vec3::of(row(Vector::x), row(Vector::y), row(Vector::z))
    }

    /// The matrix of the magnitudes.
    #[inline(always)]
    pub fn abs(&self) -> Self {
        let [x, y, z] = [self.x, self.y, self.z].map(|column| column.map(R::abs));
        Self { x, y, z }
    }

    /// The product of the transposed matrix with a vector.
    #[inline(always)]
    pub fn transposed_times(&self, v: R::Vec3) -> R::Vec3 {
        R::Vec3::of(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}

impl From<Mat3A> for Matrix {
    #[inline(always)]
    fn from(matrix: Mat3A) -> Self {
        Self {
            x: matrix.x_axis.into(),
            y: matrix.y_axis.into(),
            z: matrix.z_axis.into(),
        }
    }
}
