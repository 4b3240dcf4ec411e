//! Which shapes the camera sees, and where their edges are in the picture.

pub mod outer_walls;
pub mod sight;
pub mod silhouette;
