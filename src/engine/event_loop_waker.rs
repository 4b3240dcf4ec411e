//! Wakes a sleeping event loop from the worker threads, at a limited rate.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::control::WakeUp;

/// The least time between two calls of [`EventLoopWaker::wake_throttled`] that have an effect.
const INTERVAL: Duration = Duration::from_millis(50);

pub(super) struct EventLoopWaker {
    hook: Option<Arc<dyn Fn() + Send + Sync>>,
    last: Mutex<Instant>,
}

impl EventLoopWaker {
    pub fn new(wake_up: &WakeUp) -> Self {
        Self {
            hook: wake_up.0.clone(),
            last: Mutex::new(Instant::now()),
        }
    }

    /// Calls the hook, unless this function did so less than [`INTERVAL`] ago.
    pub fn wake_throttled(&self) {
        let Some(hook) = &self.hook else {
            return;
        };
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() >= INTERVAL {
            *last = Instant::now();
            hook();
        }
    }

    /// Calls the hook.
    pub fn wake_now(&self) {
        if let Some(hook) = &self.hook {
            hook();
        }
    }
}
