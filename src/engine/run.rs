//! Workers of a back end on one queue, until it is empty or they are stopped. Runs are independent of scenes and of the
//! kind of work.
//!
//! Every run has its own channel and flag: dropping the [`Run`] sets the flag and closes the channel, so that its
//! workers stop soon, none of them hangs at a full channel, and no result of theirs arrives any more.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, SendTimeoutError, Sender, bounded};

use super::backend::{Backend, TileResult, Work};
use super::control::Gate;
use super::event_loop_waker::EventLoopWaker;
use super::priority::processor_time;
use super::schedule::{WorkItem, WorkQueue};

/// The results that may wait to be collected, some 50 kB each. A preview is a fraction of that and fits as a whole, so
/// that workers do not wait for the next frame in the middle of a preview.
const CAPACITY: usize = 256;
/// The results per frame of each worker, if there are many workers.
const ROOM_PER_WORKER: usize = 16;
const LARGEST_CAPACITY: usize = 2048;
/// The longest wait of a worker for room in the channel between two checks of the flag. A run may be cancelled some
/// time before it is dropped.
const LONGEST_WAIT: Duration = Duration::from_millis(10);
/// The time between two checks of a closed gate.
const GATE_WAIT: Duration = Duration::from_millis(1);

pub(super) struct Run {
    cancel: Arc<AtomicBool>,
    pub queue: Arc<WorkQueue>,
    pub results: Receiver<TileResult>,
    /// The time of the first result, collected or not.
    pub first_result: Arc<OnceLock<Instant>>,
    worked: Arc<AtomicU64>,
}

struct Shared {
    cancel: Arc<AtomicBool>,
    queue: Arc<WorkQueue>,
    first_result: Arc<OnceLock<Instant>>,
    /// The processor time of all workers, in nanoseconds.
    worked: Arc<AtomicU64>,
    work: Box<Work>,
    waker: EventLoopWaker,
    gate: Gate,
    /// The number of waiting results from which on they should be collected soon.
    many: usize,
    /// The number of undelivered items of the G-buffer and the preview.
    first_left: AtomicUsize,
    workers_left: AtomicUsize,
}

impl Run {
    /// Starts all workers of `backend`. `first_items` is the number of items in the queue that are previews or parts of
    /// the G-buffer.
    pub fn start(
        backend: &Backend,
        queue: WorkQueue,
        first_items: usize,
        work: Box<Work>,
        waker: EventLoopWaker,
        gate: Gate,
    ) -> Self {
        let workers = backend.workers();
        let capacity = CAPACITY.max(ROOM_PER_WORKER * workers) + first_items;
        let capacity = capacity.min(LARGEST_CAPACITY);
        let (sender, results) = bounded(capacity);
        let shared = Arc::new(Shared {
            cancel: Arc::new(AtomicBool::new(false)),
            queue: Arc::new(queue),
            first_result: Arc::default(),
            worked: Arc::default(),
            work,
            waker,
            gate,
            many: capacity / 2,
            first_left: AtomicUsize::new(first_items),
            workers_left: AtomicUsize::new(workers),
        });
        for _ in 0..workers {
            let (shared, sender) = (shared.clone(), sender.clone());
            backend.spawn(move || shared.work_until_done(sender));
        }
        Self {
            cancel: shared.cancel.clone(),
            queue: shared.queue.clone(),
            first_result: shared.first_result.clone(),
            worked: shared.worked.clone(),
            results,
        }
    }

    /// The processor time of all its workers together for finished items.
    pub fn worked(&self) -> Duration {
        Duration::from_nanos(self.worked.load(Ordering::Relaxed))
    }

    /// Asks the workers to stop, without waiting for them.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        self.cancel();
    }
}

impl Shared {
    /// Works until the queue is empty. A panic in the work, or in the hook, ends the run with a message; otherwise it
    /// would end the program.
    fn work_until_done(&self, results: Sender<TileResult>) {
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| self.work_on_queue(&results))) {
            self.cancel.store(true, Ordering::Relaxed);
            // Waits until there is room or the run is dropped: without this message the job would be started again.
            let _ = results.send(TileResult::Failed(text_of_panic(payload.as_ref())));
        }
        drop(results);
        if self.workers_left.fetch_sub(1, Ordering::AcqRel) == 1 {
            // The event loop also wakes by itself after a while.
            let _ = catch_unwind(AssertUnwindSafe(|| self.waker.wake_now()));
        }
    }

    fn work_on_queue(&self, results: &Sender<TileResult>) {
        while !self.cancel.load(Ordering::Relaxed) {
            if self.gate.is_closed() {
                std::thread::sleep(GATE_WAIT);
                continue;
            }
            let Some(item) = self.queue.claim() else {
                break;
            };
            let begun = processor_time();
            let Some(result) = (self.work)(&item, &self.cancel) else {
                break;
            };
            let worked = processor_time().saturating_sub(begun);
            self.worked.fetch_add(worked.as_nanos() as u64, Ordering::Relaxed);
            self.first_result.get_or_init(Instant::now);
            if !self.deliver(results, result) {
                break;
            }
            match item {
                WorkItem::GBuffer { .. } | WorkItem::Preview { .. }
                    if self.first_left.fetch_sub(1, Ordering::AcqRel) == 1 =>
                {
                    self.waker.wake_now();
                }
                // The window is woken before the channel is full and workers wait.
                _ if results.len() >= self.many => self.waker.wake_now(),
                _ => self.waker.wake_throttled(),
            }
        }
    }

    /// Sends a result. False if the receiver is gone.
    fn deliver(&self, results: &Sender<TileResult>, mut result: TileResult) -> bool {
        loop {
            result = match results.send_timeout(result, LONGEST_WAIT) {
                Ok(()) => return true,
                Err(SendTimeoutError::Timeout(result)) if !self.cancel.load(Ordering::Relaxed) => result,
                Err(_) => return false,
            };
        }
    }
}

/// The message of a panic, if it has one.
pub(super) fn text_of_panic(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("a worker thread panicked")
        .to_owned()
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;
    use crate::engine::control::WakeUp;
    use crate::render::tile::{Tile, TileSamples};

    fn samples(index: usize, samples: std::ops::Range<u32>) -> TileResult {
        let tile = Tile {
            x: 0,
            y: 0,
            width: 0,
            height: 0,
        };
        TileResult::Samples {
            index,
            samples: TileSamples {
                tile,
                samples,
                pixels: Vec::new(),
                blocks: None,
                layers: Default::default(),
                first_hits: Vec::new(),
                splats: Default::default(),
                rays: 0,
                invalid: 0,
            },
        }
    }

    fn threads() -> Backend {
        Backend::cpu(3, false).expect("three threads")
    }

    /// Whether all threads are free at once.
    fn are_free(Backend::Cpu(pool): &Backend) -> bool {
        pool.broadcast(|_| 1).iter().sum::<i32>() == 3
    }

    fn start(backend: &Backend, items: usize, work: Box<Work>) -> Run {
        Run::start(
            backend,
            WorkQueue::new(&(0..items).map(|index| (index, 0)).collect::<Vec<_>>(), 1, &[], 1),
            0,
            work,
            EventLoopWaker::new(&WakeUp::default()),
            Gate::default(),
        )
    }

    fn sample_work() -> Box<Work> {
        Box::new(|item, _| match item {
            WorkItem::Samples {
                index, samples: range, ..
            } => Some(samples(*index, range.clone())),
            _ => None,
        })
    }

    #[test]
    fn everything_arrives_once_and_the_channel_closes() {
        let run = start(&threads(), 1000, sample_work());
        let mut seen: Vec<usize> = run
            .results
            .iter()
            .map(|result| match result {
                TileResult::Samples { index, .. } => index,
                other => panic!("{other:?}"),
            })
            .collect();
        seen.sort();
        assert!(seen.into_iter().eq(0..1000));
    }

    #[test]
    fn nothing_is_begun_while_the_gate_is_closed() {
        let (backend, gate) = (threads(), Gate::default());
        let (one, other) = (gate.close(), gate.close());
        let items: Vec<_> = (0..10).map(|index| (index, 0)).collect();
        let run = Run::start(
            &backend,
            WorkQueue::new(&items, 1, &[], 1),
            0,
            sample_work(),
            EventLoopWaker::new(&WakeUp::default()),
            gate,
        );
        one.open();
        one.open();
        drop(one);
        assert!(run.results.recv_timeout(Duration::from_millis(50)).is_err());
        drop(other);
        assert_eq!(run.results.iter().count(), 10);
    }

    #[test]
    fn somebody_is_woken_before_the_room_for_results_ends() {
        let woken = Arc::new(AtomicUsize::new(0));
        let count = woken.clone();
        let hook = WakeUp(Some(Arc::new(move || {
            count.fetch_add(1, Ordering::Relaxed);
        })));
        let items: Vec<_> = (0..CAPACITY - 1).map(|index| (index, 0)).collect();
        let backend = threads();
        let run = Run::start(
            &backend,
            WorkQueue::new(&items, 1, &[], 1),
            0,
            sample_work(),
            EventLoopWaker::new(&hook),
            Gate::default(),
        );
        // All of them end without collecting, because there is room. The hook is called while the second half is
        // filled, and at the end.
        let deadline = Instant::now() + Duration::from_secs(600);
        while run.results.len() < CAPACITY - 1 || woken.load(Ordering::Relaxed) < CAPACITY / 2 {
            assert!(Instant::now() < deadline, "{} results, {woken:?}", run.results.len());
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_panic_is_a_result_and_ends_the_run() {
        let work = |item: &WorkItem, cancel: &AtomicBool| match item {
            WorkItem::Samples { index: 7, .. } => panic!("number seven"),
            WorkItem::Samples {
                index, samples: range, ..
            } if *index < 7 => Some(samples(*index, range.clone())),
            _ => {
                while !cancel.load(Ordering::Relaxed) {
                    std::thread::yield_now();
                }
                None
            }
        };
        let run = start(&threads(), 100, Box::new(work));
        let results: Vec<TileResult> = run.results.iter().collect();
        assert_eq!(results.len(), 8, "{results:?}");
        let failed = |result: &TileResult| matches!(result, TileResult::Failed(text) if text == "number seven");
        assert!(results.iter().any(failed), "{results:?}");
    }

    #[test]
    fn a_panic_of_the_hook_ends_the_run_too() {
        let hook = WakeUp(Some(Arc::new(|| panic!("the hook"))));
        let items: Vec<_> = (0..10 * CAPACITY).map(|index| (index, 0)).collect();
        let backend = threads();
        let run = Run::start(
            &backend,
            WorkQueue::new(&items, 1, &[], 1),
            0,
            sample_work(),
            EventLoopWaker::new(&hook),
            Gate::default(),
        );
        // The hook is called when half of the room is filled: no result is collected before that.
        while !run.cancel.load(Ordering::Relaxed) {
            std::thread::yield_now();
        }
        let mut results = run.results.iter();
        assert!(results.any(|result| matches!(result, TileResult::Failed(text) if text == "the hook")));
        // The threads still work.
        assert!(are_free(&backend));
    }

    #[test]
    fn dropping_frees_workers_that_wait_at_a_full_channel() {
        let backend = threads();
        let run = start(&backend, 100_000, sample_work());
        let begin = Instant::now();
        while !run.results.is_full() {
            assert!(begin.elapsed() < Duration::from_secs(600));
            std::thread::yield_now();
        }
        drop(run);
        // This comes to an end only if all three threads are free.
        assert!(are_free(&backend));
    }
}
