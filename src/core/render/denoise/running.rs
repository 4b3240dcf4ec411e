//! The filters that run, and their end before the process ends: a thread that is in the library while the process
//! unloads it would crash.

use std::sync::RwLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Every filter that runs holds it.
static RUNNING: RwLock<()> = RwLock::new(());
static IS_OVER: AtomicBool = AtomicBool::new(false);

/// The permission to run filters, as long as it lives.
#[cfg(feature = "denoise")]
pub(super) type Running = std::sync::RwLockReadGuard<'static, ()>;

/// The permission; None when no filter may begin any more.
#[cfg(feature = "denoise")]
pub(super) fn begin() -> Option<Running> {
    RUNNING.read().ok().filter(|_| !is_over())
}

/// Whether filters that run are to stop.
#[cfg(feature = "denoise")]
pub(super) fn is_over() -> bool {
    IS_OVER.load(Ordering::SeqCst)
}

/// Cancels all filters that run, waits for their ends, and lets no other begin. To be called before the process ends.
pub fn end_all() {
    IS_OVER.store(true, Ordering::SeqCst);
    drop(RUNNING.write());
}
