//! Rebuilds a hierarchy on another thread while the edited one is in use.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

use crossbeam_channel::{Receiver, bounded};

use crate::accel::Tlas;
use crate::engine::blas_cache::{BlasCache, BuildPolicy};

/// A running rebuild of a hierarchy.
pub(in crate::engine) struct Rebuild {
    old: Arc<Tlas>,
    anew: Receiver<std::thread::Result<Tlas>>,
}

impl Rebuild {
    /// Starts to rebuild a hierarchy; None if there are no threads.
    pub fn begin(old: &Arc<Tlas>, cache: &mut BlasCache, policy: &BuildPolicy) -> Option<Self> {
        let pool = cache.pool(policy.threads).ok()?;
        let (sender, anew) = bounded(1);
        let (before, method) = (old.clone(), policy.method);
        pool.spawn(move || {
            let anew = catch_unwind(AssertUnwindSafe(|| before.rebuilt(method)));
            // The receiver is gone if all shapes have been packed again.
            let _ = sender.send(anew);
        });
        let old = old.clone();
        Some(Self { old, anew })
    }

    pub fn is_done(&self) -> bool {
        !self.anew.is_empty()
    }

    /// The rebuilt hierarchy, once it is done, with the edits that lead to `now`.
    pub fn finish(self, now: &Tlas) -> Option<Tlas> {
        let anew = self.anew.try_recv().ok()?;
        let anew = anew.unwrap_or_else(|panic| resume_unwind(panic));
        anew.after_edits(&self.old, now)
    }
}
