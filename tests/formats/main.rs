//! Scenes from files to entities, and back into files.

#[path = "../gltf_support/mod.rs"]
mod gltf_support;
#[path = "../support/meaning.rs"]
mod meaning;

mod bounded_work;
mod curves;
mod dialect;
mod emitters;
mod export;
mod gltf;
mod groups;
mod hot_reload;
mod markers;
mod media;
mod mesh_files;
mod opening;
mod patterns;
mod properties;
mod saving;
mod scene;
mod sensors;
mod solids;
mod workshop;
