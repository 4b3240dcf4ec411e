//! Shapes: ray intersection in the shape's own space, and the readers of mesh files.

pub mod attribute;
pub mod cylinder;
mod decimal;
pub mod disk;
pub mod local;
pub mod mesh;
pub mod mesh_file;
pub mod mtl;
pub mod mtl_map;
pub mod obj;
mod obj_lines;
mod obj_part;
mod obj_vertices;
pub mod ply;
mod ply_attributes;
mod ply_header;
mod ply_records;
mod ply_source;
pub mod ply_write;
mod polygon;
pub mod primitives;
pub mod rectangle;
pub mod serialized;
pub mod solid;
pub mod sphere;
pub mod triangle;
pub mod vertex_normals;
