//! What both fuzz targets have in common: the choice of an entry, and limits that turn waste of memory into a crash.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Reads bytes as one kind of file.
type Entry = fn(&[u8]);

/// The program's memory budget in bytes, as `--memory` sets it: so small that inputs which promise too much meet it,
/// and that what stays within it is quick.
const BUDGET: u64 = 32 << 20;

/// Bytes that a parser may hold at once. What is beyond the budget was not reserved before it was allocated.
const MOST_MEMORY: usize = 256 << 20;

/// Counts what is allocated. Memory that was taken but never touched is invisible to the limits of the fuzzer itself.
struct Limited;

static HELD: AtomicUsize = AtomicUsize::new(0);

#[global_allocator]
static ALLOCATOR: Limited = Limited;

fn take(size: usize) {
    let held = HELD.fetch_add(size, Relaxed) + size;
    if held > MOST_MEMORY {
        // An allocator must not panic; the fuzzer keeps the input when the process aborts.
        eprintln!("{size} bytes more make {held} bytes in all");
        std::process::abort();
    }
}

// SAFETY: the system's allocator does everything; only sizes are counted here.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        HELD.fetch_sub(layout.size(), Relaxed);
        take(size);
        unsafe { System.realloc(place, layout, size) }
    }
}

/// The entry that the variable `PARSER` names.
pub fn chosen(entries: &[(&str, Entry)]) -> Entry {
    let wanted = std::env::var("PARSER").unwrap_or_default();
    let found = entries.iter().find(|(name, _)| *name == wanted);
    let known: Vec<&str> = entries.iter().map(|(name, _)| *name).collect();
    found
        .unwrap_or_else(|| panic!("PARSER is `{wanted}`, not one of {}", known.join(", ")))
        .1
}

/// To be called once. Sets the memory budget; and one thread does all work, so that no time is lost between threads.
pub fn prepare() {
    sunroom_core::memory::budget().name_limit(BUDGET);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("there is no pool yet");
}
