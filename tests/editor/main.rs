//! The editor without a window: commands, handles, mouse and keys, panels, and the parsers of its files.
#![cfg(feature = "window")]

#[path = "../../fuzz/editor_entries.rs"]
mod editor_entries;
#[path = "../support/meaning.rs"]
mod meaning;
#[path = "../../fuzz/replay.rs"]
mod replay;
#[path = "../support/split_mix.rs"]
mod split_mix;
mod support;

mod baking;
mod blocking;
mod corpus;
mod editing;
mod four_views;
mod four_views_keys;
mod gizmo;
mod importing;
mod keys;
mod media;
mod missing;
mod numbers;
mod opening_handles;
mod orientation;
mod panels;
mod recovery;
mod shell;
mod snapshots;
mod start_page;
mod texturing;
mod trust;
mod undone_saves;
mod viewport;
