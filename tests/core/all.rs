//! Tests of the package `sunroom-core`, which has no Bevy in it, as one program.

extern crate sunroom_core as sunroom;

/// The root of the repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

mod bsdf_support;
#[path = "../gltf_support/mod.rs"]
mod gltf_support;
mod material_support;
mod mesh_support;
#[path = "bsdf_support/principled_cases.rs"]
mod principled_cases;
#[path = "bsdf_support/principled_figures.rs"]
mod principled_figures;
#[path = "accel_support/random.rs"]
mod random;
#[path = "accel_support/shared_data.rs"]
mod shared_data;
#[path = "../support/split_mix.rs"]
mod split_mix;
mod statistics;
#[path = "../support/mod.rs"]
mod support;
#[path = "accel_support/wavy_sphere.rs"]
mod wavy_sphere;

mod accel;
mod accel_surface;
mod accel_together;
mod adjoint;
mod animation;
mod auto;
mod bake;
mod bidirectional;
mod bounded_work;
mod breakdown;
mod breakdown_hiding;
mod breakdown_media;
mod bsdf;
mod bsdf_delta;
mod bsdf_hair;
mod bsdf_plastic;
mod bsdf_principled;
mod bsdf_rough;
mod clamp;
mod curves;
#[cfg(feature = "denoise")]
mod denoise;
mod destinations;
mod diffuse_lobe;
mod document;
mod edited_hierarchy;
mod emission;
mod environment;
mod exr_pictures;
mod far_from_origin;
mod film;
mod fuzz_corpus;
mod generated_meshes;
mod ghosts;
mod gltf;
mod gltf_animation;
mod gltf_compressed;
mod gltf_layers;
mod gltf_limits;
mod gltf_meshes;
mod gltf_poses;
mod gltf_profiles;
mod guide;
mod inspect;
mod inverse_lighting;
mod lanes;
mod layers;
mod light_transport;
mod lights;
mod lumens;
mod many_lights;
mod materials;
mod media;
mod merging;
mod meshes;
mod meter;
mod motion;
mod outer_walls;
mod patterns;
mod photometry;
mod portals;
mod probes;
mod projected_light;
mod reach;
mod sampling;
mod sensors;
mod serialized_meshes;
mod shared_meshes;
mod sight;
mod silhouette;
mod small_scenes;
mod solids;
mod square_density;
mod textured_surface_light;
mod textures;
