//! Fuzzes the parser that the variable `PARSER` names: one of `ENTRIES`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use sunroom_fuzz::entries::{ENTRIES, Entry};

static ENTRY: LazyLock<Entry> = LazyLock::new(|| {
    let wanted = std::env::var("PARSER").unwrap_or_default();
    let known = ENTRIES.map(|(name, _)| name).join(", ");
    let found = ENTRIES.iter().find(|(name, _)| *name == wanted);
    found
        .unwrap_or_else(|| panic!("PARSER is `{wanted}`, not one of {known}"))
        .1
});

fuzz_target!(init: sunroom_fuzz::prepare(), |bytes: &[u8]| ENTRY(bytes));
