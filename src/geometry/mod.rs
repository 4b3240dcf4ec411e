//! Shapes: what a ray meets, in the shape's own space, and the files meshes come from.

pub mod disk;
pub mod local;
pub mod mesh;
pub mod rectangle;
pub mod sphere;
pub mod triangle;
