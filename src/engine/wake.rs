//! Waking an event loop that sleeps, from the worker threads and not too often.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::control::WakeUp;

/// Between two calls for results that are nothing special.
const INTERVAL: Duration = Duration::from_millis(50);

pub(super) struct Waker {
    hook: Option<Arc<dyn Fn() + Send + Sync>>,
    last: Mutex<Instant>,
}

impl Waker {
    pub fn new(wake_up: &WakeUp) -> Self {
        Self {
            hook: wake_up.0.clone(),
            last: Mutex::new(Instant::now()),
        }
    }

    /// Calls the hook, unless that was done a moment ago.
    pub fn wake_sometimes(&self) {
        let Some(hook) = &self.hook else {
            return;
        };
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() >= INTERVAL {
            *last = Instant::now();
            hook();
        }
    }

    pub fn wake_now(&self) {
        if let Some(hook) = &self.hook {
            hook();
        }
    }
}
