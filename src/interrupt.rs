//! Signals that end a run early: noted when they come, asked for where a run can end well.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM};

use crate::error::{Error, Result};

/// The signal that came last; 0 for none.
fn signal() -> &'static Arc<AtomicUsize> {
    static SIGNAL: OnceLock<Arc<AtomicUsize>> = OnceLock::new();
    SIGNAL.get_or_init(Arc::default)
}

/// From now on SIGINT and SIGTERM are noted instead of ending the process.
///
/// # Errors
/// [`Error::Internal`] where the operating system refuses.
pub fn watch() -> Result<()> {
    for number in [SIGINT, SIGTERM] {
        signal_hook::flag::register_usize(number, Arc::clone(signal()), number as usize)
            .map_err(|error| Error::Internal(format!("cannot watch for signals: {error}")))?;
    }
    Ok(())
}

/// # Errors
/// [`Error::Interrupted`] where a signal has come.
pub fn check() -> Result<()> {
    match signal().load(Ordering::Relaxed) {
        0 => Ok(()),
        number => Err(Error::Interrupted(number as u8)),
    }
}
