//! Geometry of rays, boxes and frames, and mathematical functions that the standard library lacks; no scene knowledge.
//!
//! Vectors, matrices and affine maps are glam's. A transform is named `a_from_b`: it takes coordinates of space b to
//! space a.

mod aabb;
mod affine;
mod bessel;
mod erf;
mod frame;
mod functions;
pub mod lanes;
mod matrix;
mod per_lane;
mod quadrature;
mod ray;
mod real;
mod rounding;

pub use aabb::Aabb;
pub use affine::is_invertible;
pub(crate) use bessel::scaled_bessel_i0;
pub(crate) use erf::{erf, erf_inv};
pub use frame::Frame;
pub(crate) use functions::{asin_positive, atan2, cube_root, exp, ln, sin_cos};
pub(crate) use matrix::Matrix;
pub(crate) use per_lane::{Held, LanesOf, PerLane, Same, per_lane, per_lane_array, real_struct};
pub(crate) use quadrature::gauss_legendre;
pub use ray::{Ray, offset_origin};
pub use real::{Mask, Real, Vector, Word};
pub(crate) use rounding::gamma;
