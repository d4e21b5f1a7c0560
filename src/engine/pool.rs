//! The threads of a render, which may be pinned to cores.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use core_affinity::CoreId;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{Error, Result};

/// Whether threads stay on one core each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pin {
    /// They do, or nothing is rendered.
    On,
    /// The operating system moves them.
    #[default]
    Off,
    /// They do where there is one for each core that the process may use: two processes of fewer
    /// threads could else end up on the same cores.
    Auto,
}

impl Pin {
    /// All ways.
    pub const ALL: [Self; 3] = [Self::On, Self::Off, Self::Auto];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::On => "on",
            Self::Off => "off",
            Self::Auto => "auto",
        }
    }

    /// Whether so many threads are to be pinned where the process may use so many cores, 0 if that
    /// is not known.
    fn tries(self, threads: usize, cores: usize) -> bool {
        match self {
            Self::On => true,
            Self::Off => false,
            Self::Auto => threads == cores || cores == 0,
        }
    }
}

/// What has come of pinning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pinned {
    /// Each thread is on a core.
    Yes,
    /// It was not tried.
    No,
    /// It was tried, and some thread is not.
    Failed,
}

impl Pinned {
    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Yes => "yes",
            Self::No => "no",
            Self::Failed => "failed",
        }
    }
}

/// The cores that the process may use, as they were before any thread was pinned.
fn cores() -> &'static [CoreId] {
    static CORES: OnceLock<Vec<CoreId>> = OnceLock::new();
    CORES.get_or_init(|| core_affinity::get_core_ids().unwrap_or_default())
}

/// The number of threads that the setting `threads` stands for: 0 is as many as the process may use.
pub(super) fn threads(threads: u32) -> usize {
    match threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads as usize,
    }
}

/// The threads that a renderer works on.
#[derive(Debug)]
pub(super) enum Pool {
    /// Threads of its own.
    Own(ThreadPool, Pinned),
    /// The rayon pool that it is called from, or else rayon's global one.
    Caller,
}

impl Pool {
    /// Starts threads: 0 for as many as the process may use.
    ///
    /// # Errors
    /// [`Error::Internal`] if they cannot be started, or not be pinned with [`Pin::On`].
    pub(super) fn start(threads: u32, pin: Pin) -> Result<Self> {
        let threads = self::threads(threads);
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
            .map_err(|error| Error::Internal(format!("cannot start the threads: {error}")))?;
        // Every thread has begun when all have answered.
        pool.broadcast(|_| ());
        let pinned = match (tried, failed.load(Ordering::Relaxed)) {
            (false, _) => Pinned::No,
            (true, false) => Pinned::Yes,
            (true, true) if pin == Pin::On => {
                let message = "threads cannot be pinned to cores here: pin auto goes on without";
                return Err(Error::Internal(message.to_owned()));
            }
            (true, true) => Pinned::Failed,
        };
        Ok(Self::Own(pool, pinned))
    }

    /// Calls `work` once for each thread, with its number. Threads of the caller's pool that are busy
    /// with other things do not take part: others do their share.
    pub(super) fn broadcast<T: Send>(&self, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
        match self {
            Self::Own(pool, _) => pool.broadcast(|thread| work(thread.index())),
            // rayon's broadcast would wait for all threads.
            Self::Caller => {
                (0..self.threads()).into_par_iter().with_max_len(1).map(&work).collect()
            }
        }
    }

    /// Number of threads.
    pub(super) fn threads(&self) -> usize {
        match self {
            Self::Own(pool, _) => pool.current_num_threads(),
            Self::Caller => rayon::current_num_threads(),
        }
    }

    /// Whether they are pinned to cores.
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
        // Unknown cores: it is tried, fails, and is told.
        assert!(Pin::Auto.tries(4, 0));
        for (threads, cores) in [(1, 4), (4, 4), (9, 4), (1, 0)] {
            assert!(Pin::On.tries(threads, cores) && !Pin::Off.tries(threads, cores));
        }
        let pool = Pool::start(3, Pin::Off).unwrap();
        assert_eq!((pool.threads(), pool.pinned()), (3, Pinned::No));
        // More threads than cores share them.
        let cores_known = !cores().is_empty();
        let pinned = Pool::start(cores().len() as u32 + 1, Pin::On).ok().map(|pool| pool.pinned());
        assert_eq!(pinned, cores_known.then_some(Pinned::Yes));
    }
}
