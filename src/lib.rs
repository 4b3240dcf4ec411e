//! Sunroom: a small level editor whose viewport is a path tracer.
//!
//! The package `sunroom-core` (the folder `core`) has everything without Bevy and is exported here again: the kernel,
//! `document` and `gltf`. `scene` holds the authoring state as entities and assets; `engine` is the only place that
//! knows both sides; `app` drives it with or without a window.

// The scene and the engine have much that only the window uses.
#![cfg_attr(not(feature = "window"), allow(dead_code, unused_imports))]

#[macro_use]
extern crate sunroom_core;

pub use sunroom_core::{
    accel, bake, color, document, files, geometry, gltf, inverse_lighting, layer, light, material, math, medium,
    memory, meter, metrics, photometry, render, sampling, shading, texture,
};

pub mod app;
pub mod engine;
pub mod scene;
