//! Bakes lightmaps: the irradiance on the surfaces of a level, in pictures that lie on it by a second set of texture coordinates.
//!
//! [`unwrap`] gives meshes these coordinates, [`texels`] finds the place of each texel in the world, [`lightmap`] gathers light there with the
//! path tracer, and [`finish`] makes pictures of it that can be filtered: without texels that lie inside of walls, without gaps beside the charts, and
//! with equal values on both sides of a seam. [`level`] does the first for the meshes of a glTF file that is being made, [`ktx2`] writes a picture for
//! graphics cards, and [`manifest`] says how the files belong together.

pub mod finish;
pub mod ktx2;
pub mod level;
pub mod lightmap;
pub mod manifest;
pub mod seams;
pub mod sides;
pub mod texels;
pub mod unwrap;
