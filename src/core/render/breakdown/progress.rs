//! The progress of a search of many tasks, which another thread watches and may give up.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

/// The tasks whose results are in memory at a time.
const TASKS_AT_ONCE: usize = 1024;

/// The progress of a search. The thread that waits for it reads it, and may cancel the search.
#[derive(Debug, Default)]
pub struct Progress {
    cancel: Arc<AtomicBool>,
    done: AtomicU64,
    all: AtomicU64,
}

impl Progress {
    /// The progress of a search that ends when the flag is set.
    pub fn cancelled_by(cancel: Arc<AtomicBool>) -> Self {
        Self {
            cancel,
            ..Self::default()
        }
    }

    /// Gives the search up.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// The flag that ends the search when it is set.
    pub fn flag(&self) -> &AtomicBool {
        &self.cancel
    }

    /// Whether the search is given up.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// The finished share, from 0 to 1.
    pub fn done(&self) -> f64 {
        let [done, all] = [&self.done, &self.all].map(|count| count.load(Ordering::Relaxed) as f64);
        if all > 0.0 { done / all } else { 0.0 }
    }

    /// Does tasks on the threads of the current `rayon` pool, and takes their results in the order of the tasks: sums
    /// of floats depend on it. None if cancelled, or if a task has no result.
    pub(super) fn follow<T: Send>(
        &self,
        tasks: u64,
        act: impl Fn(u64) -> Option<T> + Sync,
        mut take: impl FnMut(T),
    ) -> Option<()> {
        self.all.store(tasks, Ordering::Relaxed);
        self.done.store(0, Ordering::Relaxed);
        let act = |task| {
            let result = act(task);
            self.done.fetch_add(1, Ordering::Relaxed);
            result
        };
        for first in (0..tasks).step_by(TASKS_AT_ONCE) {
            let last = tasks.min(first + TASKS_AT_ONCE as u64);
            let results: Vec<Option<T>> = (first..last).into_par_iter().map(act).collect();
            for result in results {
                take(result?);
            }
        }
        (!self.is_cancelled()).then_some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_are_counted_and_their_results_are_in_order() {
        let progress = Progress::default();
        assert_eq!(progress.done(), 0.0);
        let mut found = Vec::new();
        let tasks = 2 * TASKS_AT_ONCE as u64 + 1;
        let end = progress.follow(tasks, Some, |task| {
            // Those of one round are done before the first of them is taken.
            assert!(progress.done() * tasks as f64 > task as f64);
            found.push(task);
        });
        assert_eq!((end, progress.done()), (Some(()), 1.0));
        assert!(found.into_iter().eq(0..tasks));
    }

    #[test]
    fn a_search_that_is_given_up_has_no_end() {
        let flag = Arc::new(AtomicBool::new(false));
        let progress = Progress::cancelled_by(flag.clone());
        let end = progress.follow(5, |task| (task < 3).then_some(()), |()| {});
        assert_eq!(end, None);
        progress.cancel();
        assert!(progress.is_cancelled() && flag.load(Ordering::Relaxed));
        assert_eq!(progress.follow(1, Some, |_| {}), None);
    }
}
