//! Keys and their actions, and corrections of the events for egui. May import `command` and `words`.

pub mod actions;
pub mod drags;
pub mod keys;
pub(crate) mod leaving;
pub(crate) mod modifier_dedup;
pub mod number_field;
pub mod pipette;
pub mod press;
pub(crate) mod typing;
