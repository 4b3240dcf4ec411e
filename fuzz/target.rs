//! Fuzzes the kernel's parser that the variable `PARSER` names: one of `ENTRIES`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;

mod common;
mod entries;

static ENTRY: LazyLock<entries::Entry> = LazyLock::new(|| common::chosen(&entries::ENTRIES));

fuzz_target!(init: common::prepare(), |bytes: &[u8]| ENTRY(bytes));
