//! Decides the number of threads that trace rays, and the cores left to others. No other module decides it: neither
//! Bevy's task pools nor rayon's global pool trace rays.

use std::num::NonZeroUsize;

use bevy::ecs::schedule::{Schedules, SingleThreadedExecutor};
use bevy::prelude::*;

/// The most threads that are started, more than the largest machines have cores. Each costs memory, and the system
/// refuses to start many more.
pub const MOST_WORKERS: usize = 1024;

/// The number of workers.
///
/// `requested`: None leaves it to us; a positive number is taken as it is, also beyond the number of cores, up to 1024;
/// zero or a negative number leaves that many cores free (at least one worker remains).
///
/// Without a window all cores work. With one, a core stays with the window, but never fewer than two workers where
/// there are two cores: the window's thread sleeps most of the time and the scheduler of the operating system lets a
/// thread that wakes up go before one that has been computing all along, while a second worker halves the time until a
/// moved camera shows its first picture.
pub fn worker_count(requested: Option<i32>, windowed: bool) -> NonZeroUsize {
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    of_cores(cores, requested, windowed)
}

/// Lets the systems of a frame run one after the other on the thread that drives the app: most take microseconds, which
/// is less than waking another thread takes, and the other threads' cores trace rays.
pub(crate) fn run_systems_in_turn(app: &mut App) {
    let mut schedules = app.world_mut().resource_mut::<Schedules>();
    for (_, schedule) in schedules.iter_mut() {
        schedule.set_executor(SingleThreadedExecutor::new());
    }
}

fn of_cores(cores: usize, requested: Option<i32>, windowed: bool) -> NonZeroUsize {
    let workers = match requested {
        Some(n) if n > 0 => (n.unsigned_abs() as usize).min(MOST_WORKERS),
        Some(n) => cores.saturating_sub(n.unsigned_abs() as usize),
        None if windowed => (cores - 1).max(2).min(cores),
        None => cores,
    };
    NonZeroUsize::new(workers).unwrap_or(NonZeroUsize::MIN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn policy() {
        let table = [
            (1, None, true, 1),
            (2, None, true, 2),
            (4, None, true, 3),
            (8, None, false, 8),
            (8, Some(3), true, 3),
            (2, Some(16), false, 16),
            (2, Some(i32::MAX), false, 1024),
            (8, Some(-2), false, 6),
            (8, Some(0), true, 8),
            (2, Some(-5), false, 1),
            (2, Some(i32::MIN), false, 1),
        ];
        for (cores, requested, windowed, expected) in table {
            let workers = of_cores(cores, requested, windowed).get();
            assert_eq!(workers, expected, "{cores} cores, {requested:?}, windowed {windowed}");
        }
    }
}
