//! Geometry of rays, boxes and frames, and what the standard library lacks of analysis; no scene knowledge.
//!
//! Vectors, matrices and affine maps are glam's. A transform is named `a_from_b`: it takes coordinates of space b to space a.

mod aabb;
mod erf;
mod frame;
pub mod lanes;
mod quadrature;
mod ray;
mod rounding;

pub use aabb::Aabb;
pub use erf::{erf, erf_inv};
pub use frame::Frame;
pub use quadrature::gauss_legendre;
pub use ray::{Ray, offset_origin};
pub use rounding::gamma;
