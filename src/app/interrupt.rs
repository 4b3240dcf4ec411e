//! Signals that ask the program to end in order: SIGINT, SIGTERM and SIGHUP (on other systems the equivalents of
//! Ctrl+C).

/// Calls `handler` on a thread of its own for each such signal. SIGHUP stays ignored if it was, so that `nohup` keeps a
/// render alive when its terminal is closed.
pub fn on_interrupt(handler: impl FnMut() + Send + 'static) -> Result<(), ctrlc::Error> {
    #[cfg(unix)]
    let hang_up_was_ignored = hang_up::ignore();
    ctrlc::set_handler(handler)?;
    #[cfg(unix)]
    if hang_up_was_ignored {
        hang_up::ignore();
    }
    Ok(())
}

#[cfg(unix)]
#[allow(unsafe_code, reason = "the disposition of a signal has no safe interface")]
mod hang_up {
    use nix::sys::signal::{SigHandler, Signal, signal};

    /// Ignores SIGHUP; returns whether it was ignored before.
    pub fn ignore() -> bool {
        // SAFETY: `signal` is unsafe for handlers that are functions, which may be called at any moment. `SIG_IGN`
        // calls nothing, and the old disposition is only compared.
        let before = unsafe { signal(Signal::SIGHUP, SigHandler::SigIgn) };
        matches!(before, Ok(SigHandler::SigIgn))
    }
}
