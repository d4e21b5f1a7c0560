//! Where connections meet the renderer.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::client::Client;

/// The pages that have come and are not served yet.
#[derive(Debug, Default)]
pub(super) struct Hub {
    joined: Mutex<Vec<Arc<Client>>>,
    woken: Condvar,
}

impl Hub {
    fn joined(&self) -> MutexGuard<'_, Vec<Arc<Client>>> {
        self.joined.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a page.
    pub(super) fn join(&self, client: &Arc<Client>) {
        self.joined().push(Arc::clone(client));
        self.wake();
    }

    /// The pages that came since the last call.
    pub(super) fn take_joined(&self) -> Vec<Arc<Client>> {
        self.joined().drain(..).collect()
    }

    /// Ends [`wait`](Self::wait).
    pub(super) fn wake(&self) {
        self.woken.notify_all();
    }

    /// Waits until something is asked, or for a moment.
    pub(super) fn wait(&self) {
        let _ = self.woken.wait_timeout(self.joined(), Duration::from_millis(20));
    }
}
