//! When a render writes a checkpoint, and when it ends.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::cli::progress::ProgressReport;
use crate::engine::{Observer, Progress, Stop};
use crate::interrupt;

/// Time that workers have to finish their work once the render must end. Work that is unfinished
/// after this time is lost.
const PATIENCE: Duration = Duration::from_millis(500);

/// When a render writes checkpoints, and how long it may take.
pub(crate) struct Schedule {
    /// Time between checkpoints.
    pub(crate) every: Duration,
    pub(crate) time_limit: Option<Duration>,
    /// When the program started, from which the time limit counts.
    pub(crate) start: Instant,
}

/// The last checkpoint, or the begin of the render.
pub(crate) struct Saving {
    pub(crate) end: Instant,
    /// Minimum time until the next checkpoint.
    pub(crate) gap: Duration,
}

/// Reports the progress of a render, and stops it for the next checkpoint or for good.
pub(crate) struct Watch<'a> {
    schedule: &'a Schedule,
    progress: &'a ProgressReport,
    last: &'a Saving,
    /// Whether any work was finished since the watch began. The time limit applies only once this is true.
    /// Otherwise a limit that has already passed would end each run before it makes progress.
    advanced: AtomicBool,
    /// When it was first noticed that the render must end.
    noticed: OnceLock<Instant>,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(
        schedule: &'a Schedule,
        progress: &'a ProgressReport,
        last: &'a Saving,
    ) -> Self {
        let advanced = AtomicBool::new(false);
        Self { schedule, progress, last, advanced, noticed: OnceLock::new() }
    }

    /// When it was first noticed that the render must end; `None` if it continues.
    pub(crate) fn ends(&self) -> Option<Instant> {
        let is_over = |limit: Duration| self.schedule.start.elapsed() >= limit;
        let ends = interrupt::signal().is_some()
            || self.schedule.time_limit.is_some_and(is_over)
                && self.advanced.load(Ordering::Relaxed);
        ends.then(|| {
            *self.noticed.get_or_init(|| {
                if interrupt::is_interrupted() {
                    self.progress.say_that_it_stops();
                }
                Instant::now()
            })
        })
    }

    fn checkpoint_is_due(&self) -> bool {
        let due = self.last.end.elapsed() >= self.schedule.every.max(self.last.gap);
        due || interrupt::is_requested() && self.advanced.load(Ordering::Relaxed)
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
            None if self.checkpoint_is_due() => Stop::Soon,
            None => Stop::No,
        }
    }
}
