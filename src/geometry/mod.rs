//! Shapes: what a ray meets, in the shape's own space, and the files meshes come from.

pub mod mesh;
