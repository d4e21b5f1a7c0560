//! Records signals that end a run early, so that the run can stop cleanly.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1, SIGXFSZ};
use signal_hook::iterator::Signals as Received;
use signal_hook::{flag, low_level};

use crate::error::{Error, Result};

/// The signals received so far.
#[derive(Debug, Default)]
struct Signals {
    /// The last received signal that ends the run; 0 if there was none.
    last: Arc<AtomicUsize>,
    /// Whether such a signal ends the process at once, because there is no work to save.
    leaves: Arc<AtomicBool>,
    /// Whether SIGUSR1 was received.
    asked: Arc<AtomicBool>,
}

fn signals() -> &'static Signals {
    static SIGNALS: OnceLock<Signals> = OnceLock::new();
    SIGNALS.get_or_init(Signals::default)
}

/// Within this time, a second SIGINT is the same request as the first: some terminals, and `timeout`, send a signal
/// to a process and to its group.
const ONE_REQUEST: Duration = Duration::from_millis(500);

/// From now on, SIGINT, SIGTERM, SIGHUP and SIGUSR1 are recorded and do not end the process. A
/// second SIGINT, later than [`ONE_REQUEST`] after the first, still ends it. After `leave_at_once(true)`, every one of these signals except
/// SIGUSR1 ends it.
///
/// # Errors
/// [`Error::Resource`] if the operating system refuses.
pub(crate) fn watch() -> Result<()> {
    let Signals { last, leaves, asked } = signals();
    // Under nohup, SIGHUP stays ignored. Shells make background processes ignore SIGINT, but a
    // SIGINT that somebody sends to a background process is intended, so SIGINT is recorded.
    let hangups = (!is_ignored(SIGHUP)).then_some(SIGHUP);
    let register = || {
        let interrupts = Received::new([SIGINT])?;
        thread::Builder::new().name("interrupts".to_owned()).spawn(|| end_at_second(interrupts))?;
        for signal in [SIGINT, SIGTERM].into_iter().chain(hangups) {
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(leaves))?;
            flag::register_usize(signal, Arc::clone(last), signal as usize)?;
        }
        flag::register(SIGUSR1, Arc::clone(asked))
    };
    register().map(|_| ()).map_err(refused)
}

/// Ends the process at the second request to interrupt it.
fn end_at_second(mut interrupts: Received) {
    let mut first = None;
    for signal in interrupts.forever() {
        if first.get_or_insert_with(Instant::now).elapsed() > ONE_REQUEST {
            low_level::exit(128 + signal);
        }
    }
}

/// Whether the process ignores `signal`.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & 1 << (signal - 1) != 0)
}

/// From now on, a write beyond the limit on file sizes fails instead of ending the process.
///
/// # Errors
/// [`Error::Resource`] if the operating system refuses.
pub(crate) fn survive_large_files() -> Result<()> {
    let registered = flag::register(SIGXFSZ, Arc::default());
    registered.map(|_| ()).map_err(refused)
}

fn refused(error: std::io::Error) -> Error {
    Error::Resource(format!("cannot watch for signals: {error}"))
}

/// Sets whether signals end the process at once, because there is no work to save.
pub(crate) fn leave_at_once(leave: bool) {
    signals().leaves.store(leave, Ordering::Relaxed);
}

/// Number of the last received signal that ends the run, if any.
pub(crate) fn signal() -> Option<u8> {
    let last = signals().last.load(Ordering::Relaxed);
    (last != 0).then_some(last as u8)
}

/// Whether SIGUSR1 was received since the last call.
pub(crate) fn take_request() -> bool {
    signals().asked.swap(false, Ordering::Relaxed)
}

/// Whether SIGUSR1 was received.
pub(crate) fn is_requested() -> bool {
    signals().asked.load(Ordering::Relaxed)
}

/// Whether SIGINT was the last signal that ends the run.
pub(crate) fn is_interrupted() -> bool {
    signal() == Some(SIGINT as u8)
}

/// Fails if a signal that ends the run was received.
///
/// # Errors
/// [`Error::Interrupted`] if such a signal was received.
pub(crate) fn check() -> Result<()> {
    signal().map_or(Ok(()), |number| Err(Error::Interrupted(number)))
}
