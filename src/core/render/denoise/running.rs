//! Tracks running filters, and ends them before the process ends: a thread inside the library while the process unloads
//! it would crash.

use std::sync::RwLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Every running filter holds a read lock.
static RUNNING: RwLock<()> = RwLock::new(());
static IS_OVER: AtomicBool = AtomicBool::new(false);

/// The permission to run filters while it is held.
#[cfg(feature = "denoise")]
pub(super) type Running = std::sync::RwLockReadGuard<'static, ()>;

/// The permission; None when no filter may start any more.
#[cfg(feature = "denoise")]
pub(super) fn begin() -> Option<Running> {
    RUNNING.read().ok().filter(|_| !is_over())
}

/// Whether running filters must stop.
#[cfg(feature = "denoise")]
pub(super) fn is_over() -> bool {
    IS_OVER.load(Ordering::SeqCst)
}

/// Cancels all running filters, waits for their ends, and prevents others. To be called before the process ends.
pub fn end_all() {
    IS_OVER.store(true, Ordering::SeqCst);
    drop(RUNNING.write());
}
