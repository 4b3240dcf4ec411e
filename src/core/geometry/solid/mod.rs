//! Meshes of building parts that are given by a few numbers: walls with openings, stairs, prisms.
//!
//! All stand on the plane z = 0 of their own space, with z upwards. They are closed surfaces with flat normals outward.
//! Texture coordinates are lengths on the face in the units of the space, u to the right and v downwards as seen from
//! outside, so that pictures stand upright and keep their size on faces of all sizes.

mod facets;
pub mod ply;
pub mod prism;
pub mod stairs;
pub mod wall;

pub use prism::prism;
pub use stairs::stairs;
pub use wall::{Hole, wall};
