//! Keys and the actions they stand for, and repairs to the events that egui is given. May import `command`.

pub mod actions;
pub mod keys;
pub(crate) mod leaving;
pub(crate) mod modifier_dedup;
pub mod press;
pub(crate) mod typing;
