//! The visibility of shapes to the camera, and their outlines in the picture.

pub mod outer_walls;
pub mod sight;
pub mod silhouette;
