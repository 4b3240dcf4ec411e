//! Loads scenes and the files that they name into the world.

pub(super) mod framing;
pub(super) mod loading;
pub mod mesh_check;
pub(super) mod meshes;
pub(super) mod opening;
pub mod picture_check;
pub(super) mod pictures;
pub mod plugin;
pub(super) mod scene_file;
pub mod spawn;
pub(super) mod stand_in;
pub mod volume_check;
pub(super) mod volumes;
pub mod watch;
