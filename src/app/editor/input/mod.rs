//! Keys and their actions, and repairs to the events that egui gets. May import `command` and
//! `words`.

pub mod actions;
pub mod drags;
pub mod keys;
pub(crate) mod leaving;
pub(crate) mod modifier_dedup;
pub mod number_field;
pub mod press;
pub(crate) mod typing;
