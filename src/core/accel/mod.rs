//! Finds the hits of rays with wide bounding volume hierarchies: one over each mesh's triangles ([`Blas`]) or the
//! curves of a file ([`CurveBlas`]), and one over the instances placed in the world ([`Tlas`]). In between, a group of
//! shapes that is placed many times has its own.
//!
//! A ray taken into an instance's local space is not renormalised, so its `t` is the world's `t` everywhere.

mod affine_mesh;
mod area;
mod binning;
mod blas;
mod build;
mod build_prim;
mod bvh;
mod collapse;
mod curve_blas;
mod edit;
mod edited_part;
mod hit;
mod instance;
mod instances;
mod interleaved;
mod memory;
mod mesh_surface;
mod node;
mod obstacle;
mod occlusion;
mod order;
mod placement;
mod ray_lanes;
mod ray_packet;
mod rounding;
mod shape_block;
mod shape_blocks;
mod shape_lanes;
mod shared_list;
mod skip_list;
mod small_scene;
mod spatial;
mod surface;
mod tiny_mesh;
mod tlas;
mod traverse;
mod tree_edit;
mod triangle_block;
mod work;

pub use blas::Blas;
pub use build::SplitMethod;
pub use bvh::{Bvh, BvhBox, BvhStats};
pub use curve_blas::CurveBlas;
pub use hit::{CurveHit, Detail, Hit, MeshHit, SurfacePoint};
pub use instance::{Instance, Primitive};
pub use instances::{Instances, ShapeEdits};
pub(crate) use mesh_surface::SurfaceLanes;
pub use obstacle::{Obstacle, Obstacles};
pub use placement::Placement;
pub use ray_lanes::RayLanes;
pub use tlas::Tlas;
pub use traverse::TraversalStats;
