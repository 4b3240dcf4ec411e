//! The records of shapes and the hierarchy over them, either packed as a whole or edited.

mod all_shapes;
mod named_mesh;
pub(super) mod packing;
pub(super) mod rebuild;
mod shapes;
pub(super) mod solid_meshes;
pub(super) mod splice;
