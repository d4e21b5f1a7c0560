//! Parallel work while trees are built.
//!
//! It uses threads of its own. A thread of a rayon pool that waits for its tasks may start another
//! one, which could need the same tree and wait for it forever.

use std::sync::{Mutex, PoisonError};
use std::thread;

/// Calls `work` with each of `tasks`, the first ones first, on up to `threads` threads. If threads
/// cannot be started, fewer do the work.
pub(super) fn for_each<T: Send>(threads: usize, tasks: Vec<T>, work: impl Fn(T) + Sync) {
    let threads = threads.min(tasks.len());
    let tasks = Mutex::new(tasks.into_iter());
    let next = || tasks.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        while let Some(task) = next() {
            work(task);
        }
    };
    thread::scope(|scope| {
        let start = |_| thread::Builder::new().spawn_scoped(scope, work).is_ok();
        (1..threads).all(start);
        work();
    });
}
