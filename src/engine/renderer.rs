//! The back end and its current job.

use bevy::prelude::*;

use super::backend::Backend;
use super::job::Job;

/// The back end and its job.
#[derive(Resource, Default)]
pub(super) struct Renderer {
    pub backend: Option<Backend>,
    pub job: Option<Job>,
    /// The reason why there is no back end.
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

    /// Prepares a back end of this many threads, which replaces one with another number. They are `yielding` to the
    /// window if there is one.
    pub fn prepare_backend(&mut self, threads: usize, yielding: bool) {
        if self
            .backend
            .as_ref()
            .is_some_and(|backend| backend.workers() == threads)
        {
            return;
        }
        if let Some(job) = &mut self.job {
            job.pause();
        }
        match Backend::cpu(threads, yielding) {
            Ok(backend) => (self.backend, self.failure) = (Some(backend), None),
            Err(error) => self.failure = Some(format!("{threads} render threads cannot be started: {error}")),
        }
    }
}
