//! When a render under way is to be kept, or to end.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::keep_args::Keeping;
use super::progress::ProgressReport;
use crate::engine::{Observer, Progress, Stop};
use crate::interrupt;

/// How long workers may take to finish what they are at, once a render is to be stopped.
const PATIENCE: Duration = Duration::from_millis(500);

/// Watches a render, and stops it where something is to be done.
pub(super) struct Watch<'a> {
    keeping: &'a Keeping,
    progress: &'a ProgressReport,
    /// When it began, and how long it goes on at least before it is kept.
    start: Instant,
    gap: Duration,
    /// Whether something was done since: a limit of time that was over before would end every run at nothing.
    advanced: AtomicBool,
    /// When it was first noticed that the render is to end.
    noticed: OnceLock<Instant>,
}

impl<'a> Watch<'a> {
    pub(super) fn new(keeping: &'a Keeping, progress: &'a ProgressReport, gap: Duration) -> Self {
        let (start, advanced) = (Instant::now(), AtomicBool::new(false));
        Self { keeping, progress, start, gap, advanced, noticed: OnceLock::new() }
    }

    /// Whether the render is to end, and since when that is known.
    pub(super) fn ends(&self) -> Option<Instant> {
        let is_over = |limit: Duration| self.keeping.start.elapsed() >= limit;
        let ends = interrupt::signal().is_some()
            || self.keeping.time_limit.is_some_and(is_over)
                && self.advanced.load(Ordering::Relaxed);
        ends.then(|| *self.noticed.get_or_init(Instant::now))
    }

    fn is_to_be_kept(&self) -> bool {
        let since = self.start.elapsed();
        let due = self.keeping.every.is_some_and(|every| since >= every);
        let advanced = self.advanced.load(Ordering::Relaxed);
        due && since >= self.gap || interrupt::is_requested() && advanced
    }
}

impl Observer for Watch<'_> {
    fn progressed(&self, progress: Progress) {
        self.advanced.store(true, Ordering::Relaxed);
        self.progress.progressed(progress);
    }

    fn stop(&self) -> Stop {
        match self.ends() {
            Some(noticed) if noticed.elapsed() > PATIENCE => Stop::Now,
            Some(_) => Stop::Soon,
            None if self.is_to_be_kept() => Stop::Soon,
            None => Stop::No,
        }
    }
}
