//! The priorities of threads, by which they yield to the window and to each other, and the processor time they have
//! used.

use std::time::Duration;

/// Lowers the priority of the calling thread, so that a window that reacts to a key gets its core at once, above all
/// where a software driver draws the window on the same cores. Without priorities per thread in the system, nothing
/// happens.
pub(crate) fn yield_to_window() {
    /// This gives a third of the share of a thread that does not yield.
    const NICENESS: i32 = 5;
    set_niceness(NICENESS);
}

/// Lowers the priority below that of render threads: the thread, and those that it starts, get a third of their share.
pub(crate) fn yield_to_rendering() {
    const NICENESS: i32 = 10;
    set_niceness(NICENESS);
}

/// Lowers the priority further: the thread gets a tenth of the share of render threads.
pub(crate) fn yield_to_all() {
    const NICENESS: i32 = 15;
    set_niceness(NICENESS);
}

#[cfg(target_os = "linux")]
fn set_niceness(niceness: i32) {
    // If the system refuses, the priority stays.
    let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), niceness);
}

#[cfg(not(target_os = "linux"))]
fn set_niceness(_niceness: i32) {}

/// The processor time of the calling thread; wall-clock time where the system does not report it.
#[cfg(target_os = "linux")]
pub(super) fn processor_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

#[cfg(not(target_os = "linux"))]
pub(super) fn processor_time() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;

    static BEGINNING: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGINNING.elapsed()
}
