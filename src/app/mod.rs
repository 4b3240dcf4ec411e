//! The application: runs the scene and the engine, with or without a window.

mod allocator;
pub mod baking;
pub mod checkpoint;
#[cfg(feature = "window")]
pub mod editor;
pub mod headless;
pub mod interrupt;
pub mod metering;
pub mod origin;
pub mod signals;
pub mod terminal;
pub mod threads;
#[cfg(feature = "window")]
pub mod windowed;
