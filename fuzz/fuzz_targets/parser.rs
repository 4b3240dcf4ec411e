//! Fuzzes the parser that the variable `PARSER` names: one of `ENTRIES`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use sunroom_fuzz::chosen;
use sunroom_fuzz::entries::ENTRIES;
use sunroom_fuzz::entries::Entry;

static ENTRY: LazyLock<Entry> = LazyLock::new(|| chosen(&ENTRIES));

fuzz_target!(init: sunroom_fuzz::prepare(), |bytes: &[u8]| ENTRY(bytes));
