//! The editor without a user: scripts, screenshots, measurements, and the monkey that tests it. May import every other
//! module of the editor.

mod acts;
pub(crate) mod exit_door;
pub mod finish;
pub(crate) mod latency;
pub mod monkey;
pub(crate) mod plugin;
pub mod screenshot;
pub mod script;
pub(crate) mod settling;
