//! Faults as a table: what is injected, what the user sees, what is left on the disk. Each row is a test, and
//! `docs/faults.md` shows the table; a test fails when the page differs.
#![cfg(all(feature = "window", target_os = "linux"))]

mod baking;
mod cache;
mod denoiser;
mod killed;
mod memory;
mod panics;
mod program;
mod reloading;
mod rendering;
mod saving;
mod sets;
mod stopping;
mod table;
mod window;
#[path = "../window_support/mod.rs"]
mod window_support;

use table::Section;

const SECTIONS: [&Section; 12] = [
    &rendering::SECTION,
    &stopping::SECTION,
    &baking::SECTION,
    &saving::SECTION,
    &killed::SECTION,
    &sets::SECTION,
    &reloading::SECTION,
    &memory::SECTION,
    &cache::SECTION,
    &denoiser::SECTION,
    &panics::SECTION,
    &window::SECTION,
];

/// Faults that cannot be brought about here, and why.
const NOT_INJECTED: [(&str, &str); 2] = [
    (
        "The graphics device is lost while the window is open.",
        "A software driver never loses its device, and no driver offers a way to lose it on demand.",
    ),
    (
        "The power fails.",
        "It needs a machine of its own. New content is flushed to the disk before it replaces the old one.",
    ),
];

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/faults.md");

#[test]
fn the_page_shows_the_table() {
    let expected = table::page(&SECTIONS, &NOT_INJECTED);
    if std::env::var_os("SUNROOM_WRITE_FAULTS").is_some() {
        std::fs::write(PAGE, &expected).expect("the page can be written");
    }
    let page = std::fs::read_to_string(PAGE).expect("the page is there");
    assert!(
        page == expected,
        "docs/faults.md differs from the table: run with SUNROOM_WRITE_FAULTS=1"
    );
}
