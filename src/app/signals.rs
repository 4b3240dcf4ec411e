//! Signals of a render farm: SIGTERM, which requests a checkpoint, and SIGUSR1, which requests the picture so far.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

static SHOW: AtomicBool = AtomicBool::new(false);
static TERMINATED: AtomicBool = AtomicBool::new(false);
static CANCEL: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Records SIGUSR1 for [`take_show`] from now on. Other systems have no such signal.
pub fn note_show() {
    #[cfg(unix)]
    handlers::note_show();
}

/// Makes SIGTERM set this flag from now on, and records it for [`is_terminated`]. On other systems, and after the first
/// call, this does nothing.
pub fn note_termination(cancel: Arc<AtomicBool>) {
    if CANCEL.set(cancel).is_ok() {
        #[cfg(unix)]
        handlers::note_termination();
    }
}

/// Whether SIGUSR1 has come since the last call.
pub fn take_show() -> bool {
    SHOW.swap(false, Ordering::Relaxed)
}

/// Whether SIGTERM has come.
pub fn is_terminated() -> bool {
    TERMINATED.load(Ordering::Relaxed)
}

#[cfg(unix)]
#[allow(unsafe_code, reason = "the disposition of a signal has no safe interface")]
mod handlers {
    use std::sync::atomic::Ordering;

    use nix::libc::c_int;
    use nix::sys::signal::{SaFlags, SigAction, SigHandler, SigSet, Signal, sigaction};

    use super::{CANCEL, SHOW, TERMINATED};

    pub fn note_show() {
        set(Signal::SIGUSR1, show);
    }

    pub fn note_termination() {
        set(Signal::SIGTERM, terminate);
    }

    /// Sets a handler. If this fails, the signal acts as before.
    fn set(signal: Signal, handler: extern "C" fn(c_int)) {
        let action = SigAction::new(SigHandler::Handler(handler), SaFlags::SA_RESTART, SigSet::empty());
        // SAFETY: the handlers may be called at any moment. They load and store atomic values, and do nothing else.
        let _ = unsafe { sigaction(signal, &action) };
    }

    extern "C" fn show(_: c_int) {
        SHOW.store(true, Ordering::Relaxed);
    }

    extern "C" fn terminate(_: c_int) {
        TERMINATED.store(true, Ordering::Relaxed);
        if let Some(cancel) = CANCEL.get() {
            cancel.store(true, Ordering::Relaxed);
        }
    }
}
