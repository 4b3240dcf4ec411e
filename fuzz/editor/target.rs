//! Fuzzes the editor's parser that the variable `PARSER` names: one of `ENTRIES`.
#![no_main]
#![allow(unsafe_code)]

use std::sync::LazyLock;
use std::{panic, process, slice};

#[path = "../common.rs"]
mod common;
#[path = "../editor_entries.rs"]
mod editor_entries;
#[path = "../../tests/support/meaning.rs"]
mod meaning;

static ENTRY: LazyLock<fn(&[u8])> = LazyLock::new(|| {
    common::prepare();
    // What a parser breaks is a crash, even if something would catch the panic.
    let show = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        show(info);
        process::abort();
    }));
    common::chosen(&editor_entries::ENTRIES)
});

/// What libFuzzer calls with each input.
///
/// # Safety
///
/// `data` points to `size` bytes, which must not change during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn LLVMFuzzerTestOneInput(data: *const u8, size: usize) -> i32 {
    // SAFETY: as the caller promises; without bytes the pointer may be null.
    let bytes = if size == 0 {
        &[]
    } else {
        unsafe { slice::from_raw_parts(data, size) }
    };
    ENTRY(bytes);
    0
}
