//! A search on threads of its own, of lower priority than those that render: one question at a time, which can be
//! cancelled.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use crossbeam_channel::{Receiver, TryRecvError, bounded};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::engine::{WakeUp, yield_to_rendering};
use crate::render::breakdown::Progress;

/// The state of a search.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum SearchState {
    /// Nothing is being looked for.
    #[default]
    Idle,
    /// This share of the search is done, from 0 to 1.
    Running(f64),
    /// The question has no answer, for this reason: a sentence without a full stop.
    Failed(String),
}

#[derive(Debug)]
struct Running<Q, A> {
    question: Q,
    progress: Arc<Progress>,
    result: Receiver<Result<A, String>>,
}

/// A search that answers questions `Q` by `A`.
#[derive(Debug)]
pub(super) struct Search<Q, A> {
    pool: Option<ThreadPool>,
    running: Option<Running<Q, A>>,
    /// The question that had no answer, and the reason; it is not asked again.
    failed: Option<(Q, String)>,
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

    /// The state of the search for the answer to the last question.
    pub fn state(&self) -> SearchState {
        match (&self.running, &self.failed) {
            (Some(running), _) => SearchState::Running(running.progress.done()),
            (None, Some((_, reason))) => SearchState::Failed(reason.clone()),
            (None, None) => SearchState::Idle,
        }
    }

    /// Whether the question that is being answered, or had no answer, is the one that `is_same` knows.
    pub fn is_about(&self, is_same: impl Fn(&Q) -> bool) -> bool {
        let running = self.running.as_ref().map(|running| &running.question);
        let failed = self.failed.as_ref().map(|(question, _)| question);
        running.or(failed).is_some_and(is_same)
    }

    /// Gives the question up.
    pub fn cancel(&mut self) {
        self.failed = None;
        if let Some(running) = self.running.take() {
            running.progress.cancel();
        }
    }

    /// The question and its answer, once.
    pub fn collect(&mut self) -> Option<(Q, A)> {
        let result = match self.running.as_ref()?.result.try_recv() {
            Ok(result) => result,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err("an error of the program ended the search".to_owned()),
        };
        let question = self.running.take()?.question;
        match result {
            Ok(answer) => Some((question, answer)),
            Err(reason) => {
                self.failed = Some((question, reason));
                None
            }
        }
    }

    /// Asks a question in place of the one before. `threads` is the number of threads that render, of which half are
    /// used; `wake_up` is called at the end. The error of `find` is a sentence without a full stop.
    pub fn start(
        &mut self,
        question: Q,
        threads: usize,
        wake_up: &WakeUp,
        find: impl FnOnce(Q, &Progress) -> Result<A, String> + Send + 'static,
    ) {
        self.cancel();
        if self.pool.is_none() {
            let pool = ThreadPoolBuilder::new()
                .num_threads(threads.div_ceil(2))
                .start_handler(|_| yield_to_rendering());
            match pool.thread_name(|index| format!("search {index}")).build() {
                Ok(pool) => self.pool = Some(pool),
                Err(error) => self.failed = Some((question.clone(), format!("no threads could be started: {error}"))),
            }
        }
        let Some(pool) = &self.pool else {
            return;
        };
        let (sender, result) = bounded(1);
        let progress = Arc::new(Progress::default());
        let (asked, watched, wake_up) = (question.clone(), progress.clone(), wake_up.clone());
        pool.spawn(move || {
            // A panic that escapes from a job of this pool would end the program.
            if let Ok(found) = catch_unwind(AssertUnwindSafe(|| find(asked, &watched))) {
                let _ = sender.send(found);
            }
            drop(sender);
            if let Some(wake) = &wake_up.0 {
                wake();
            }
        });
        self.running = Some(Running {
            question,
            progress,
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
        search.start(3, 1, &WakeUp::default(), |question, _| Ok(2 * question));
        assert!(search.is_about(|question| *question == 3) && !search.is_about(|question| *question == 4));
        assert_eq!(answered(&mut search), Some(6));
        assert!(!search.is_running() && search.collect().is_none());
    }

    #[test]
    fn a_question_without_an_answer_is_known() {
        let mut search: Search<u32, u32> = Search::default();
        search.start(3, 1, &WakeUp::default(), |_, _| Err("there is none".to_owned()));
        assert_eq!(answered(&mut search), None);
        assert_eq!(search.state(), SearchState::Failed("there is none".to_owned()));
        assert!(search.is_about(|question| *question == 3));
        search.cancel();
        assert!(!search.is_about(|question| *question == 3));
        assert_eq!(search.state(), SearchState::Idle);
    }

    #[test]
    fn a_panic_is_a_question_without_an_answer() {
        let mut search: Search<u32, u32> = Search::default();
        search.start(3, 1, &WakeUp::default(), |_, _| {
            panic!("a search that panics, as the test wants")
        });
        assert_eq!(answered(&mut search), None);
        assert!(matches!(search.state(), SearchState::Failed(reason) if reason.contains("error of the program")));
    }

    #[test]
    fn a_new_question_cancels_the_one_before() {
        let mut search = Search::default();
        search.start(1, 2, &WakeUp::default(), |_, progress| {
            while !progress.is_cancelled() {
                std::thread::yield_now();
            }
            Err("it was given up".to_owned())
        });
        assert_eq!(search.state(), SearchState::Running(0.0));
        search.start(2, 2, &WakeUp::default(), |question, _| Ok(question));
        assert_eq!(answered(&mut search), Some(2));
    }
}
