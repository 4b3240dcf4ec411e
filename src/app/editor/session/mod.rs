//! The state that the editor keeps beside the scene: history, preferences, messages, view settings, requests and
//! recovery. May import `command`, `words` and `camera`.

mod aside;
mod copying;
mod file_hashes;
pub mod full_film_question;
pub mod history;
pub mod kept_picture;
pub mod layout;
pub mod options;
pub mod panel_sizes;
pub(crate) mod picture_cache;
pub mod playback;
pub(crate) mod plugin;
pub mod preferences;
pub mod recovery;
pub(crate) mod recovery_words;
pub mod requests;
pub mod save_question;
pub(crate) mod stable_hash;
pub mod stored_views;
pub mod systems;
pub mod toasts;
pub mod trust;
pub mod tutorial;
pub mod view_settings;
pub mod views_file;
pub(crate) mod window_place;
