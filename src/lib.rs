//! Sunroom: a small level editor whose viewport is a path tracer.
//!
//! The kernel (`math` to `render`) knows nothing of Bevy; `document` is the XML format, `gltf` makes such documents of glTF files; `scene` holds the authoring state as entities
//! and assets; `engine` is the only place that knows both sides; `app` drives it with or without a window.

pub mod accel;
pub mod app;
pub mod color;
pub mod document;
pub mod engine;
pub mod files;
pub mod geometry;
pub mod gltf;
pub mod light;
pub mod material;
pub mod math;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod shading;
pub mod texture;
