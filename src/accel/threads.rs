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

/// Does the same as [`for_each`], and returns the results in the order of the tasks.
pub(super) fn map<T: Send, R: Send>(
    threads: usize,
    tasks: Vec<T>,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let results: Vec<_> = tasks.iter().map(|_| Mutex::new(None)).collect();
    for_each(threads, tasks.into_iter().zip(&results).collect(), |(task, result)| {
        *result.lock().expect("no thread panicked") = Some(work(task));
    });
    let result = |slot: Mutex<Option<R>>| slot.into_inner().expect("no thread panicked");
    results.into_iter().map(|slot| result(slot).expect("every task is done")).collect()
}
