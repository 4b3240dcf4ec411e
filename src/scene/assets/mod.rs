//! Files that become data: meshes and scenes.

pub mod triangle_mesh;

pub use triangle_mesh::{MeshHandle, TriangleMesh};
