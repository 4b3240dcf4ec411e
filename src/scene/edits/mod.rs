//! Edits of things beyond one component: insertion, key frames, and the shown time of an animation.

pub mod insert;
pub(super) mod key_edits;
pub mod object_change;
pub(super) mod posing;
pub(super) mod turntable;
