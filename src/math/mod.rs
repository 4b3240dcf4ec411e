//! Geometry of rays, boxes and frames; no scene knowledge.
//!
//! Vectors, matrices and affine maps are glam's. A transform is named `a_from_b`: it takes coordinates of space b to space a.

mod aabb;
mod frame;
mod ray;
mod rounding;

pub use aabb::Aabb;
pub use frame::Frame;
pub use ray::{Ray, offset_origin};
pub use rounding::gamma;
