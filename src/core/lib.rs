//! The package `sunroom-core`: everything that does not know Bevy. The kernel (`math` to `render`) traces rays,
//! `document` is the XML format, `gltf` turns glTF files into such documents, `bake` makes lightmaps, `files` opens and
//! writes files, and `memory` counts what they hold.
//!
//! It is a package of its own so that its tests, benches and fuzz targets build without Bevy, and a change of the
//! editor does not compile the kernel again. The program's crate root (`src/lib.rs`) exports these modules under the
//! same names.

#[macro_use]
mod names;

pub mod accel;
pub mod bake;
pub mod color;
pub mod document;
pub mod files;
pub mod geometry;
pub mod gltf;
pub mod inverse_lighting;
pub mod layer;
pub mod light;
pub mod material;
pub mod math;
pub mod medium;
pub mod memory;
pub mod meter;
pub mod metrics;
pub mod photometry;
pub mod render;
pub mod sampling;
pub mod shading;
pub mod texture;
