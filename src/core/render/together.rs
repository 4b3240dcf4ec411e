//! A result computed by all workers that wait for it: each computes some of its blocks.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, OnceLock, PoisonError};

/// A result computed from the parts `T` of all blocks, in the order of their numbers.
pub(super) struct Together<T, R> {
    /// The part of each block, until the result is computed from them.
    blocks: Vec<Mutex<Option<T>>>,
    /// The number of the next block that no worker has started.
    next: AtomicUsize,
    /// The number of blocks that are finished or failed.
    done: Mutex<usize>,
    progress: Condvar,
    /// The result; its inner None means that a block has failed.
    result: OnceLock<Option<R>>,
}

impl<T, R: Clone> Together<T, R> {
    pub fn new(blocks: usize) -> Self {
        Self {
            blocks: std::iter::repeat_with(Mutex::default).take(blocks).collect(),
            next: AtomicUsize::new(0),
            done: Mutex::new(0),
            progress: Condvar::new(),
            result: OnceLock::new(),
        }
    }

    /// The result, which `finish` computes from the parts. `make` computes the part of block number n. None if `cancel`
    /// was set in the meantime, or if a block has failed.
    pub fn get(&self, make: impl Fn(u32) -> T, finish: impl FnOnce(Vec<T>) -> R, cancel: &AtomicBool) -> Option<R> {
        if let Some(result) = self.result.get() {
            return result.clone();
        }
        while !cancel.load(Ordering::Relaxed) {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(block) = self.blocks.get(number) else {
                return self.finished(finish);
            };
            let counted = Counted(self);
            let part = make(number as u32);
            *block.lock().unwrap_or_else(PoisonError::into_inner) = Some(part);
            drop(counted);
        }
        None
    }

    /// The result if it is already computed.
    pub fn known(&self) -> Option<R> {
        self.result.get().cloned().flatten()
    }

    /// Waits for the blocks of other workers.
    fn finished(&self, finish: impl FnOnce(Vec<T>) -> R) -> Option<R> {
        let done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        let waits = |done: &mut usize| *done < self.blocks.len();
        drop(self.progress.wait_while(done, waits));
        let part = |block: &Mutex<Option<T>>| block.lock().unwrap_or_else(PoisonError::into_inner).take();
        let result = || {
            let parts: Option<Vec<T>> = self.blocks.iter().map(part).collect();
            parts.map(finish)
        };
        self.result.get_or_init(result).clone()
    }
}

/// Counts a block when it is finished, and also when its worker panics: the others must not wait for it.
struct Counted<'a, T, R>(&'a Together<T, R>);

impl<T, R> Drop for Counted<'_, T, R> {
    fn drop(&mut self) {
        *self.0.done.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.0.progress.notify_all();
    }
}
