//! Makes worker threads give way to the window.

/// Lowers the priority of the calling thread, so that a window that wants to answer a key gets its core at once: the more so where a
/// software driver draws the window on the same cores. Where the system has no such thing per thread, nothing happens.
pub(super) fn yield_to_window() {
    #[cfg(target_os = "linux")]
    {
        /// A third of the share of a thread that does not yield.
        const NICENESS: i32 = 5;
        // A system that refuses leaves the thread as it is.
        let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), NICENESS);
    }
}
