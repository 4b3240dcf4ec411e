//! Bakes the light of a level for game engines.
//!
//! Lightmaps are the irradiance on its surfaces, in pictures that lie on it by a second set of texture coordinates.
//! [`unwrap`] gives meshes these coordinates, [`texels`] finds the place of each texel in the world, [`lightmap`]
//! gathers light there with the path tracer, and [`finish`] makes pictures of it that can be filtered: without texels
//! that lie inside of walls, without gaps beside the charts, and with equal values on both sides of a seam. [`level`]
//! does the first for the meshes of a glTF file that is being made.
//!
//! Probes are for what lightmaps have no answer to. A [`reflection`] probe is what metals mirror: a picture of all
//! directions ([`mod@cube`]), filtered for every roughness ([`prefilter`]). An irradiance [`volume`] lights what moves.
//! [`placement`] says where they are.
//!
//! [`layers`] divides the light by lamps, which a game can dim.
//!
//! [`preview`] shows a level by its lightmaps, and [`glimpse`] a lightmap as a small picture.
//!
//! [`job`] does all of it in turn, and can be watched and cancelled; [`part`] keeps its light in files, and [`merging`]
//! puts shares of it together. [`ktx2`] writes textures for graphics cards, [`files`] writes everything, and
//! [`manifest`] says how the files belong together.

pub mod blueprint;
pub mod cube;
pub mod error;
pub mod files;
pub mod finish;
pub mod glimpse;
pub mod in_sight;
pub mod job;
pub mod ktx2;
pub mod layers;
pub mod level;
pub mod lightmap;
pub mod limits;
pub mod manifest;
pub mod merging;
pub mod part;
pub mod placement;
pub mod prefilter;
pub mod preview;
pub mod probes;
pub mod progress;
pub mod reflection;
pub mod seams;
pub mod sides;
pub mod spread;
pub mod texels;
pub mod unwrap;
pub mod volume;
