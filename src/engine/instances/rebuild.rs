//! A hierarchy that is built anew on another thread while the edited one is in use.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

use crossbeam_channel::{Receiver, bounded};

use crate::accel::Tlas;
use crate::engine::blas_cache::{BlasCache, BuildPolicy};

/// A hierarchy that is being built anew.
pub(in crate::engine) struct Rebuild {
    old: Arc<Tlas>,
    anew: Receiver<std::thread::Result<Tlas>>,
}

impl Rebuild {
    /// Begins to build a hierarchy anew; None without threads.
    pub fn begin(old: &Arc<Tlas>, cache: &mut BlasCache, policy: &BuildPolicy) -> Option<Self> {
        let pool = cache.pool(policy.threads).ok()?;
        let (sender, anew) = bounded(1);
        let (before, method) = (old.clone(), policy.method);
        pool.spawn(move || {
            let anew = catch_unwind(AssertUnwindSafe(|| before.rebuilt(method)));
            // The receiver is gone if all has been packed again.
            let _ = sender.send(anew);
        });
        let old = old.clone();
        Some(Self { old, anew })
    }

    pub fn is_done(&self) -> bool {
        !self.anew.is_empty()
    }

    /// The new hierarchy, once it is done, after the edits that lead to `now`.
    pub fn finish(self, now: &Tlas) -> Option<Tlas> {
        let anew = self.anew.try_recv().ok()?;
        let anew = anew.unwrap_or_else(|panic| resume_unwind(panic));
        anew.after_edits(&self.old, now)
    }
}
