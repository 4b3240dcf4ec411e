//! Turns the film into the displayed picture: false colours, the denoiser, outlines, boxes and paths, and the pacing of
//! frames. May import `session` and the modules below it.

pub mod awaited_image;
pub mod axis_colors;
pub mod baking;
pub mod ball_picture;
pub(crate) mod carrying;
pub mod compare;
pub mod denoised;
pub mod denoiser;
mod denoiser_input;
pub mod depths;
mod false_colour;
mod filter_work;
pub mod frame_times;
pub mod lamp_light;
pub mod legend;
pub mod light_search;
pub(crate) mod material_ball;
pub mod metering;
pub(crate) mod motion;
pub mod noise_trend;
pub mod outline;
pub mod outline_pass;
pub mod overlay;
pub(crate) mod pacing;
pub mod painter;
pub mod paths;
pub(crate) mod plugin;
pub mod reasons;
pub(crate) mod reframing;
pub(crate) mod resolution;
pub mod search;
pub mod side_pictures;
pub(crate) mod texture;
pub mod wireframe;
