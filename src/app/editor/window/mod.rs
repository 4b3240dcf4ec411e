//! The window as a whole: menus, docked panels, dialogs, questions, and sheets over them. May import everything but
//! `automation`.

pub(crate) mod assets;
pub mod baking;
pub(crate) mod dialog;
pub(crate) mod dialogs;
pub(crate) mod docking;
pub(crate) mod dropping;
pub mod field_keys;
pub mod file_dialog;
pub mod full_film;
mod guards;
pub(crate) mod late_quit;
pub mod palette;
pub mod picture_question;
pub(crate) mod plugin;
mod pointed;
pub(crate) mod preview;
mod preview_work;
mod question;
pub mod recovery_question;
pub mod save_question;
pub mod scene_question;
pub(crate) mod sheet;
pub mod shortcuts;
pub mod start_page;
pub mod style;
pub mod title;
pub mod toasts;
pub mod trust_question;
pub mod tutorial;
pub(crate) mod ui;
pub mod unsaved_question;
pub mod widgets;
