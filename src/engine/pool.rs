//! The threads of a render, pinned to cores.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use core_affinity::CoreId;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{Error, Result};

/// Whether threads stay on one core each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pin {
    /// They do.
    On,
    /// The operating system moves them.
    Off,
    /// They do where there is one for each core that the process may use: two processes of fewer
    /// threads could else end up on the same cores.
    #[default]
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

/// The cores that the process may use, as they were before any thread was pinned.
fn cores() -> &'static [CoreId] {
    static CORES: OnceLock<Vec<CoreId>> = OnceLock::new();
    CORES.get_or_init(|| core_affinity::get_core_ids().unwrap_or_default())
}

/// So many threads, 0 for as many as the process may use.
///
/// # Errors
/// [`Error::Internal`] where they cannot be started.
pub(super) fn start(threads: u32, pin: Pin) -> Result<(ThreadPool, Pinned)> {
    let threads = match threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads as usize,
    };
    let cores = cores();
    let tried = match pin {
        Pin::On => true,
        Pin::Off => false,
        Pin::Auto => threads == cores.len(),
    };
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
        (true, true) => Pinned::Failed,
    };
    Ok((pool, pinned))
}
