//! The worker threads, and the job that they work on.

use bevy::prelude::*;
use rayon::ThreadPool;

use super::job::Job;
use super::priority;

/// The worker threads and their job.
#[derive(Resource, Default)]
pub(super) struct Renderer {
    pub pool: Option<ThreadPool>,
    pub job: Option<Job>,
    /// The reason why there are no threads.
    pub failure: Option<String>,
    /// Whether rendering waits for meshes or their acceleration structures.
    pub waiting: bool,
}

impl Renderer {
    pub fn job(&self) -> Option<&Job> {
        self.job.as_ref()
    }

    pub fn job_mut(&mut self) -> Option<&mut Job> {
        self.job.as_mut()
    }

    /// Prepares a pool of this many threads, in place of one with another number. They are `yielding` to the window if there is one.
    pub fn prepare_pool(&mut self, threads: usize, yielding: bool) {
        if self
            .pool
            .as_ref()
            .is_some_and(|pool| pool.current_num_threads() == threads)
        {
            return;
        }
        if let Some(job) = &mut self.job {
            job.pause();
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("render {index}"))
            .start_handler(move |_| {
                if yielding {
                    priority::yield_to_window();
                }
            })
            .build();
        match pool {
            Ok(pool) => (self.pool, self.failure) = (Some(pool), None),
            Err(error) => self.failure = Some(format!("{threads} render threads cannot be started: {error}")),
        }
    }
}
