//! The application: drives the scene and the engine, with or without a window.

pub mod headless;
pub mod threads;
