//! Frees memory on a thread of its own, so that the window does not wait for it. Memory that render threads have
//! allocated is in their heaps: freeing it waits for a lock that such a thread may hold while it has no core, and large
//! blocks are returned to the system page by page.

use bevy::prelude::*;
use crossbeam_channel::{Sender, unbounded};

/// A channel to the thread that drops the values sent to it.
#[derive(Resource, Clone)]
pub(crate) struct DeferredDrop {
    sender: Sender<Box<dyn Send>>,
}

impl Default for DeferredDrop {
    fn default() -> Self {
        let (sender, receiver) = unbounded::<Box<dyn Send>>();
        // Without the thread the channel is closed, and the sender drops its values itself.
        let _ = std::thread::Builder::new()
            .name("deferred drop".to_owned())
            .spawn(move || receiver.iter().for_each(drop));
        Self { sender }
    }
}

impl DeferredDrop {
    /// Drops `garbage` on the other thread.
    pub fn drop_later(&self, garbage: impl Send + 'static) {
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
        DeferredDrop::default().drop_later(Tells(sender));
        let thread = dropped.recv_timeout(Duration::from_secs(600)).expect("dropped");
        assert_ne!(thread, std::thread::current().id());
    }
}
