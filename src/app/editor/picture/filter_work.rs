//! A running filter beside the window, on a thread of its own and those of the filter. During a quick filter the
//! tracing threads begin nothing new: beside them it would take about ten times as long.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crossbeam_channel::{Receiver, TryRecvError, bounded};

use crate::engine::{ClosedGate, Gate, WakeUp, yield_to_rendering};

/// Opens the gate at the end of the thread, even after a panic.
struct OpenAtEnd(Arc<ClosedGate>);

impl Drop for OpenAtEnd {
    fn drop(&mut self) {
        self.0.open();
    }
}

/// A filter that returns a `T`. Dropping this cancels it.
pub(super) struct FilterWork<T> {
    cancel: Arc<AtomicBool>,
    gate: Option<Arc<ClosedGate>>,
    result: Receiver<T>,
}

impl<T: Send + 'static> FilterWork<T> {
    /// Starts it on a thread of this name, behind the closed gate if there is one. The filter is given the flag by
    /// which it is cancelled.
    pub fn begin(
        name: &str,
        gate: Option<&Gate>,
        wake_up: &WakeUp,
        filter: impl FnOnce(&AtomicBool) -> T + Send + 'static,
    ) -> io::Result<Self> {
        let cancel = Arc::new(AtomicBool::new(false));
        let gate = gate.map(|gate| Arc::new(gate.close()));
        let (sender, result) = bounded(1);
        let (flag, wake_up) = (cancel.clone(), wake_up.clone());
        let until_end = gate.clone().map(OpenAtEnd);
        let work = move || {
            // A filter that was cancelled has the cores for some time yet, which the next picture needs.
            yield_to_rendering();
            let filtered = filter(&flag);
            drop(until_end);
            // The receiver is gone if the work was dropped.
            let _ = sender.send(filtered);
            drop(sender);
            if let Some(wake) = wake_up.0 {
                wake();
            }
        };
        std::thread::Builder::new().name(name.to_owned()).spawn(work)?;
        Ok(Self { cancel, gate, result })
    }
}

impl<T> FilterWork<T> {
    /// The result, if it has arrived.
    pub fn result(&self) -> Result<T, TryRecvError> {
        self.result.try_recv()
    }

    /// Whether the thread still runs. A result that has arrived is dropped.
    pub fn is_working(&self) -> bool {
        matches!(self.result(), Err(TryRecvError::Empty))
    }

    /// Opens the gate for the tracing threads, and cancels the filter.
    pub fn stop(&self) {
        self.cancel.store(true, Ordering::Relaxed);
        self.gate.iter().for_each(|gate| gate.open());
    }
}

impl<T> Drop for FilterWork<T> {
    fn drop(&mut self) {
        self.stop();
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_filter_gives_its_result_and_ends_when_it_is_stopped() {
        let (gate, wake_up) = (Gate::default(), WakeUp::default());
        let work = FilterWork::begin("filter", Some(&gate), &wake_up, |_| 7).expect("a thread");
        assert_eq!(work.result.recv_timeout(Duration::from_secs(600)), Ok(7));
        let until_cancelled = |cancel: &AtomicBool| {
            while !cancel.load(Ordering::Relaxed) {
                std::thread::yield_now();
            }
        };
        let work = FilterWork::begin("filter", Some(&gate), &wake_up, until_cancelled).expect("a thread");
        assert!(work.is_working());
        work.stop();
        assert_eq!(work.result.recv_timeout(Duration::from_secs(600)), Ok(()));
    }
}
