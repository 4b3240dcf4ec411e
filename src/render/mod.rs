//! From the tables of a scene and a view to pixels. Knows nothing of entities or files of scenes.

pub mod camera;
pub mod denoise;
pub mod film;
pub mod filter;
pub mod image_io;
pub mod path;
pub mod scene;
pub mod tile;
pub mod tonemap;
pub mod view;
