//! Signals that end a run early: noted when they come, asked for where a run can end well.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::error::{Error, Result};

/// The signal that came last; 0 for none.
fn signal() -> &'static Arc<AtomicUsize> {
    static SIGNAL: OnceLock<Arc<AtomicUsize>> = OnceLock::new();
    SIGNAL.get_or_init(Arc::default)
}

/// From now on SIGINT and SIGTERM are noted instead of ending the process. The second one ends it at once.
///
/// # Errors
/// [`Error::Internal`] where the operating system refuses.
pub fn watch() -> Result<()> {
    let register = |number: i32| {
        let again = Arc::new(AtomicBool::new(false));
        // In this order: the first signal is not the second.
        flag::register_conditional_shutdown(number, 128 + number, Arc::clone(&again))?;
        flag::register(number, again)?;
        flag::register_usize(number, Arc::clone(signal()), number as usize)
    };
    [SIGINT, SIGTERM].into_iter().try_for_each(|number| register(number).map(drop)).map_err(
        |error: std::io::Error| Error::Internal(format!("cannot watch for signals: {error}")),
    )
}

/// # Errors
/// [`Error::Interrupted`] where a signal has come.
pub fn check() -> Result<()> {
    match signal().load(Ordering::Relaxed) {
        0 => Ok(()),
        number => Err(Error::Interrupted(number as u8)),
    }
}
