//! A search on threads of its own, beside those that render: one question at a time, which can be cancelled.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crossbeam_channel::{Receiver, TryRecvError, bounded};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::engine::WakeUp;

#[derive(Debug)]
struct Running<Q, A> {
    question: Q,
    cancel: Arc<AtomicBool>,
    result: Receiver<A>,
}

/// A search that answers questions `Q` by `A`.
#[derive(Debug)]
pub(super) struct Search<Q, A> {
    pool: Option<ThreadPool>,
    running: Option<Running<Q, A>>,
    /// The question that had no answer; it is not asked again.
    failed: Option<Q>,
}

impl<Q, A> Default for Search<Q, A> {
    fn default() -> Self {
        Self {
            pool: None,
            running: None,
            failed: None,
        }
    }
}

impl<Q: Clone + Send + 'static, A: Send + 'static> Search<Q, A> {
    /// Whether a question is being answered.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Whether the question that is being answered, or had no answer, is the one that `is_same` knows.
    pub fn is_about(&self, is_same: impl Fn(&Q) -> bool) -> bool {
        let running = self.running.as_ref().map(|running| &running.question);
        running.or(self.failed.as_ref()).is_some_and(is_same)
    }

    /// Gives the question up.
    pub fn cancel(&mut self) {
        self.failed = None;
        if let Some(running) = self.running.take() {
            running.cancel.store(true, Ordering::Relaxed);
        }
    }

    /// The question and its answer, once.
    pub fn collect(&mut self) -> Option<(Q, A)> {
        match self.running.as_ref()?.result.try_recv() {
            Ok(answer) => {
                let question = self.running.take()?.question;
                Some((question, answer))
            }
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                self.failed = self.running.take().map(|running| running.question);
                None
            }
        }
    }

    /// Asks a question in place of the one before. `threads` is the number of threads that render, of which half are
    /// used; `wake_up` is called at the end.
    pub fn start(
        &mut self,
        question: Q,
        threads: usize,
        wake_up: &WakeUp,
        find: impl FnOnce(Q, &AtomicBool) -> Option<A> + Send + 'static,
    ) {
        self.cancel();
        if self.pool.is_none() {
            let pool = ThreadPoolBuilder::new().num_threads(threads.div_ceil(2));
            // Without threads there is no answer.
            self.pool = pool.thread_name(|index| format!("search {index}")).build().ok();
        }
        let Some(pool) = &self.pool else {
            self.failed = Some(question);
            return;
        };
        let (sender, result) = bounded(1);
        let cancel = Arc::new(AtomicBool::new(false));
        let (asked, flag, wake_up) = (question.clone(), cancel.clone(), wake_up.clone());
        pool.spawn(move || {
            // A panic that escapes from a job of this pool would end the program.
            let found = catch_unwind(AssertUnwindSafe(|| find(asked, &flag)));
            if let Ok(Some(answer)) = found {
                let _ = sender.send(answer);
            }
            drop(sender);
            if let Some(wake) = &wake_up.0 {
                wake();
            }
        });
        self.running = Some(Running {
            question,
            cancel,
            result,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answered(search: &mut Search<u32, u32>) -> Option<u32> {
        for _ in 0..1000 {
            if let Some((_, answer)) = search.collect() {
                return Some(answer);
            }
            if !search.is_running() {
                return None;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        panic!("there is no end");
    }

    #[test]
    fn a_question_is_answered_once() {
        let mut search = Search::default();
        search.start(3, 1, &WakeUp::default(), |question, _| Some(2 * question));
        assert!(search.is_about(|question| *question == 3) && !search.is_about(|question| *question == 4));
        assert_eq!(answered(&mut search), Some(6));
        assert!(!search.is_running() && search.collect().is_none());
    }

    #[test]
    fn a_question_without_an_answer_is_known() {
        let mut search: Search<u32, u32> = Search::default();
        search.start(3, 1, &WakeUp::default(), |_, _| None);
        assert_eq!(answered(&mut search), None);
        assert!(search.is_about(|question| *question == 3));
        search.cancel();
        assert!(!search.is_about(|question| *question == 3));
    }

    #[test]
    fn a_new_question_cancels_the_one_before() {
        let mut search = Search::default();
        search.start(1, 2, &WakeUp::default(), |_, cancel| {
            while !cancel.load(Ordering::Relaxed) {
                std::thread::yield_now();
            }
            None
        });
        search.start(2, 2, &WakeUp::default(), |question, _| Some(question));
        assert_eq!(answered(&mut search), Some(2));
    }
}
