//! The arithmetic of the view: flying, walking, orbiting, projecting and picking. May import `command`.

pub mod ground;
pub mod navigation;
pub mod orbit;
pub(crate) mod picking;
pub mod pose;
pub mod rounding;
pub mod screen;
pub mod side_view;
pub mod sizing;
pub mod snapping;
pub mod solid;
pub mod walking;
