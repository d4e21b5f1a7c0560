//! The threads of a render, which may be pinned to cores.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use core_affinity::CoreId;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{Error, Result};

/// Whether each thread is pinned to a core.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pin {
    /// Threads are pinned. If that fails, nothing is rendered.
    On,
    /// Threads are not pinned: the operating system may move them.
    #[default]
    Off,
    /// Threads are pinned if there is one for each core that the process may use: otherwise, two
    /// processes with fewer threads could end up on the same cores.
    Auto,
}

names! { pub Pin: On = "on", Off = "off", Auto = "auto" }

impl Pin {
    /// Whether to try to pin `threads` threads if the process may use `cores` cores, 0 if their
    /// number is unknown.
    fn tries(self, threads: usize, cores: usize) -> bool {
        match self {
            Self::On => true,
            Self::Off => false,
            Self::Auto => threads == cores || cores == 0,
        }
    }
}

/// The outcome of pinning threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pinned {
    /// Each thread is pinned to a core.
    Yes,
    /// Pinning was not tried.
    No,
    /// Pinning failed for at least one thread.
    Failed,
}

names! { pub Pinned: Yes = "yes", No = "no", Failed = "failed" }

/// The cores that the process may use, determined before any thread is pinned.
fn cores() -> &'static [CoreId] {
    static CORES: OnceLock<Vec<CoreId>> = OnceLock::new();
    CORES.get_or_init(|| core_affinity::get_core_ids().unwrap_or_default())
}

/// The number of threads for the setting `threads`, where 0 means as many as the process may use.
pub(crate) fn threads_for(threads: u32) -> usize {
    match threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads as usize,
    }
}

/// The threads that a renderer works on.
#[derive(Debug)]
pub(crate) enum Pool {
    /// The renderer's own threads.
    Own(ThreadPool, Pinned),
    /// The rayon pool from which the renderer is called, or otherwise rayon's global pool.
    Caller,
}

impl Pool {
    /// Starts `threads` threads, or for 0 as many as the process may use.
    ///
    /// # Errors
    /// If the threads cannot be started, or cannot be pinned with [`Pin::On`], returns
    /// [`Error::Resource`].
    pub(crate) fn start(threads: u32, pin: Pin) -> Result<Self> {
        let threads = threads_for(threads);
        let cores = cores();
        let tried = pin.tries(threads, cores.len());
        let failed = Arc::new(AtomicBool::new(cores.is_empty()));
        let fails = Arc::clone(&failed);
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .start_handler(move |thread| {
                if tried && !cores.is_empty() {
                    let core = cores[thread % cores.len()];
                    if !core_affinity::set_for_current(core) {
                        fails.store(true, Ordering::Relaxed);
                    }
                }
            })
            .build()
            .map_err(|error| {
                Error::Resource(format!(
                    "cannot start {threads} threads ({error}): use fewer threads"
                ))
            })?;
        // Once every thread has answered, all start handlers have run.
        pool.broadcast(|_| ());
        let pinned = match (tried, failed.load(Ordering::Relaxed)) {
            (false, _) => Pinned::No,
            (true, false) => Pinned::Yes,
            (true, true) if pin == Pin::On => {
                let message = "threads cannot be pinned to cores here; pin auto continues without";
                return Err(Error::Resource(message.to_owned()));
            }
            (true, true) => Pinned::Failed,
        };
        Ok(Self::Own(pool, pinned))
    }

    /// Calls `work` once for each thread, with the thread's number. In the caller's pool, threads
    /// that are busy with other work do not take part, and other threads make their calls.
    pub(super) fn broadcast<T: Send>(&self, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
        match self {
            Self::Own(pool, _) => pool.broadcast(|thread| work(thread.index())),
            // rayon's `broadcast` would wait for all threads, including busy ones.
            Self::Caller => {
                (0..self.threads()).into_par_iter().with_max_len(1).map(&work).collect()
            }
        }
    }

    /// Runs `work` in the pool.
    pub(crate) fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match self {
            Self::Own(pool, _) => pool.install(work),
            Self::Caller => work(),
        }
    }

    /// Number of threads.
    pub(super) fn threads(&self) -> usize {
        match self {
            Self::Own(pool, _) => pool.current_num_threads(),
            Self::Caller => rayon::current_num_threads(),
        }
    }

    /// Whether the threads are pinned to cores.
    pub(super) fn pinned(&self) -> Pinned {
        match self {
            Self::Own(_, pinned) => *pinned,
            Self::Caller => Pinned::No,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_pinned_where_they_fill_the_cores() {
        assert!(Pin::Auto.tries(4, 4) && !Pin::Auto.tries(3, 4) && !Pin::Auto.tries(5, 4));
        // With unknown cores, pinning is tried, and its failure is reported.
        assert!(Pin::Auto.tries(4, 0));
        for (threads, cores) in [(1, 4), (4, 4), (9, 4), (1, 0)] {
            assert!(Pin::On.tries(threads, cores) && !Pin::Off.tries(threads, cores));
        }
        let pool = Pool::start(3, Pin::Off).unwrap();
        assert_eq!((pool.threads(), pool.pinned()), (3, Pinned::No));
        // If there are more threads than cores, threads share cores.
        let cores_known = !cores().is_empty();
        let pinned = Pool::start(cores().len() as u32 + 1, Pin::On).ok().map(|pool| pool.pinned());
        assert_eq!(pinned, cores_known.then_some(Pinned::Yes));
    }
}
