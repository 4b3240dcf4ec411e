//! Renders pixels from the tables of a scene and a view. It knows nothing of entities or files of scenes.

pub mod camera;
pub mod denoise;
mod dimensions;
pub mod exposure;
pub mod film;
pub mod filter;
mod headlight;
pub mod image_io;
pub mod inspect;
mod lanes;
pub mod layered_image;
pub mod light_layers;
mod mis;
pub mod noise;
pub mod observer;
pub mod path;
mod path_state;
mod roulette;
pub mod scene;
pub mod sight;
pub mod silhouette;
pub mod splats;
pub mod tile;
pub mod tonemap;
mod transmittance;
pub mod view;
pub mod white_balance;
