//! The panels around the picture. Each is a function of an egui `Ui` and plain data that returns the user's input as
//! [`Command`]s; none touches the ECS, so that tests can drive them without a window. May import `model`, `input` and
//! the modules below them.
//!
//! [`Command`]: crate::app::editor::command::Command

pub mod assets;
pub mod baking;
pub mod camera_angles;
pub mod caption;
pub mod color_field;
mod color_picker;
pub mod comparison;
mod component;
pub mod diagnostics;
pub mod dimensions;
pub(crate) mod drag_start;
pub mod emission;
pub mod excerpt;
mod exposure;
pub mod fields;
pub mod history;
pub mod inspector;
pub mod key_bindings;
mod key_buttons;
pub(crate) mod key_marks;
mod kind_icons;
pub mod lamp_light;
mod lamp_placing;
mod lamps;
pub mod layers;
pub mod lengths;
pub mod library;
pub mod light_mixing;
pub mod light_painting;
mod light_section;
pub mod light_strength;
pub mod look;
pub mod material;
pub mod material_header;
pub mod material_tree;
mod medium;
mod medium_section;
pub mod menu_bar;
mod menu_marks;
pub mod meter;
pub mod missing_files;
pub mod outliner;
pub mod paths;
pub(super) mod pattern_rows;
pub mod plain_value;
mod polar_curve;
pub mod preferences;
pub mod projection;
mod properties;
pub mod reasons;
pub mod render;
pub mod section;
pub mod sensor;
pub mod series;
mod solid;
pub mod statistics;
pub mod status;
pub mod texture;
pub mod texture_slot;
pub mod timeline;
mod tracks;
pub mod transform;
mod typed;
