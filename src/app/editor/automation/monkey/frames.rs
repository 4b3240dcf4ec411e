//! The processor time of a thread, on a machine with other load.

use std::ops::{Add, AddAssign, Sub};
use std::time::{Duration, Instant};

use super::gauge::ThreadTimes;

/// A span of time of one thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    pub wall: Duration,
    /// The time without the time in which the thread was ready to run and other threads had the cores. Waiting for
    /// locks and disks counts.
    pub own: Duration,
    /// The time on a core.
    pub computed: Duration,
}

impl Add for Span {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            wall: self.wall + other.wall,
            own: self.own + other.own,
            computed: self.computed + other.computed,
        }
    }
}

impl AddAssign for Span {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// The difference, at least zero.
impl Sub for Span {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            wall: self.wall.saturating_sub(other.wall),
            own: self.own.saturating_sub(other.own),
            computed: self.computed.saturating_sub(other.computed),
        }
    }
}

/// Measures the time of the thread that starts it.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    times: ThreadTimes,
    begun: Instant,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self {
            times: ThreadTimes::read(),
            begun: Instant::now(),
        }
    }

    /// The time since the start. To be called on the thread that started it.
    pub fn elapsed(&self) -> Span {
        let wall = self.begun.elapsed();
        let now = ThreadTimes::read();
        Span {
            wall,
            own: wall.saturating_sub(now.waited.saturating_sub(self.times.waited)),
            computed: now.computed.saturating_sub(self.times.computed),
        }
    }
}
