//! Gives memory back on a thread of its own. What tracing threads have allocated lies in their heaps: whoever frees it waits until none
//! of them is just allocating, and they may have to wait for a core; large pieces go back to the system page by page. The window must
//! not wait for either.

use bevy::prelude::*;
use crossbeam_channel::{Sender, unbounded};

#[derive(Resource, Clone)]
pub(super) struct Discard {
    sender: Sender<Box<dyn Send>>,
}

impl Default for Discard {
    fn default() -> Self {
        let (sender, receiver) = unbounded::<Box<dyn Send>>();
        // Without the thread the channel is closed, and what is sent is dropped by the sender.
        let _ = std::thread::Builder::new()
            .name("discard".to_owned())
            .spawn(move || receiver.iter().for_each(drop));
        Self { sender }
    }
}

impl Discard {
    /// Drops it soon.
    pub fn discard(&self, garbage: impl Send + 'static) {
        let _ = self.sender.send(Box::new(garbage));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};
    use std::thread::ThreadId;
    use std::time::Duration;

    use super::*;

    struct Tells(Sender<ThreadId>);

    impl Drop for Tells {
        fn drop(&mut self) {
            let _ = self.0.send(std::thread::current().id());
        }
    }

    #[test]
    fn it_is_dropped_elsewhere() {
        let (sender, dropped) = channel();
        Discard::default().discard(Tells(sender));
        let thread = dropped.recv_timeout(Duration::from_secs(600)).expect("dropped");
        assert_ne!(thread, std::thread::current().id());
    }
}
