//! Measures the resources of the process: memory, threads, open files, and how long a thread has waited for a core. It
//! reads Linux's `/proc`; on other systems nothing is known, and nothing is judged.

use std::time::Duration;

/// A measurement of the process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Gauge {
    /// Resident memory in kB.
    pub memory_kb: u64,
    pub threads: u64,
    /// Open file descriptors.
    pub files: u64,
}

impl Gauge {
    /// Reads the present values. None on other systems.
    pub fn read() -> Option<Self> {
        let status = std::fs::read_to_string("/proc/self/status").ok()?;
        let of = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name))?;
            line.split_whitespace().next()?.parse().ok()
        };
        // The listing itself has one file open.
        let files = std::fs::read_dir("/proc/self/fd").ok()?.count().saturating_sub(1);
        Some(Self {
            memory_kb: of("VmRSS:")?,
            threads: of("Threads:")?,
            files: files as u64,
        })
    }
}

/// The times of a thread since it began. Zero on other systems.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ThreadTimes {
    /// The time on a core.
    pub computed: Duration,
    /// The time in which it was ready to run while other threads had the cores.
    pub waited: Duration,
}

impl ThreadTimes {
    /// Reads the figures of the calling thread.
    pub fn read() -> Self {
        // The file has the nanoseconds on a core, those of waiting for one, and the number of turns (Linux,
        // Documentation/scheduler/sched-stats.rst).
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
        let mut times = text.split_whitespace().map(|time| time.parse().unwrap_or(0));
        let mut next = || Duration::from_nanos(times.next().unwrap_or(0));
        Self {
            computed: next(),
            waited: next(),
        }
    }
}

/// The number of running or ready threads of the whole machine, for each core, as a mean over the last minute. Zero on
/// other systems.
pub(crate) fn threads_per_core() -> f32 {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = text.split_whitespace().next().and_then(|load| load.parse().ok());
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
    load.unwrap_or(0.0) / cores as f32
}

#[cfg(test)]
mod tests {
    #[cfg(target_os = "linux")]
    #[test]
    fn an_open_file_is_counted() {
        let before = super::Gauge::read().expect("Linux has /proc");
        let files: Vec<_> = (0..20)
            .filter_map(|_| std::fs::File::open("/proc/self/status").ok())
            .collect();
        let after = super::Gauge::read().expect("Linux has /proc");
        assert_eq!(files.len(), 20);
        // Other tests of this process open and close files meanwhile.
        assert!(after.files + 10 > before.files + 20, "{before:?} {after:?}");
        assert!(after.memory_kb > 1000 && after.threads >= 1);
    }
}
