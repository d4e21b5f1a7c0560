//! Signals that end a run early: noted when they come, asked for where a run can end well.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1, SIGXFSZ};
use signal_hook::flag;

use crate::error::{Error, Result};

/// What has come.
#[derive(Debug, Default)]
struct Signals {
    /// The signal that came last and ends the run; 0 for none.
    last: Arc<AtomicUsize>,
    /// Whether the run ends at once when one comes: there is nothing to be kept.
    leaves: Arc<AtomicBool>,
    /// Whether it ends at once by SIGINT: one has come before.
    insists: Arc<AtomicBool>,
    /// Whether SIGUSR1 has come.
    asked: Arc<AtomicBool>,
}

fn signals() -> &'static Signals {
    static SIGNALS: OnceLock<Signals> = OnceLock::new();
    SIGNALS.get_or_init(Signals::default)
}

/// From now on SIGINT, SIGTERM and SIGHUP are noted instead of ending the process, which a second SIGINT does; and
/// SIGUSR1 is noted.
///
/// # Errors
/// [`Error::Internal`] where the operating system refuses.
pub(crate) fn watch() -> Result<()> {
    let Signals { last, leaves, insists, asked } = signals();
    // nohup has them ignored. (Shells ignore SIGINT for what runs in the background: who sends it there means it.)
    let hangups = (!is_ignored(SIGHUP)).then_some(SIGHUP);
    let register = || {
        // Before it is noted that one has come.
        flag::register_conditional_shutdown(SIGINT, 128 + SIGINT, Arc::clone(insists))?;
        flag::register(SIGINT, Arc::clone(insists))?;
        for signal in [SIGINT, SIGTERM].into_iter().chain(hangups) {
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(leaves))?;
            flag::register_usize(signal, Arc::clone(last), signal as usize)?;
        }
        flag::register(SIGUSR1, Arc::clone(asked))
    };
    register().map(|_| ()).map_err(refused)
}

/// Whether `signal` is to leave the process alone.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & 1 << (signal - 1) != 0)
}

/// From now on a write beyond the largest size that files may have fails, instead of ending the process.
///
/// # Errors
/// [`Error::Internal`] where the operating system refuses.
pub(crate) fn survive_large_files() -> Result<()> {
    let registered = flag::register(SIGXFSZ, Arc::default());
    registered.map(|_| ()).map_err(refused)
}

fn refused(error: std::io::Error) -> Error {
    Error::Internal(format!("cannot watch for signals: {error}"))
}

/// Whether signals end the process at once, because there is nothing to be kept.
pub(crate) fn leave_at_once(leave: bool) {
    signals().leaves.store(leave, Ordering::Relaxed);
}

/// The number of the signal that is to end the run, if one has come.
pub(crate) fn signal() -> Option<u8> {
    let last = signals().last.load(Ordering::Relaxed);
    (last != 0).then_some(last as u8)
}

/// Whether SIGUSR1 has come since this was asked last.
pub(crate) fn take_request() -> bool {
    signals().asked.swap(false, Ordering::Relaxed)
}

/// Whether SIGUSR1 has come.
pub(crate) fn is_requested() -> bool {
    signals().asked.load(Ordering::Relaxed)
}

/// # Errors
/// [`Error::Interrupted`] where a signal has come.
pub(crate) fn check() -> Result<()> {
    signal().map_or(Ok(()), |number| Err(Error::Interrupted(number)))
}
