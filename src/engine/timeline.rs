//! What each worker did when, for those who ask.

use std::time::Instant;

use super::stage::Stage;
use crate::film::Unit;

/// Something that took a worker's time.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Number of the worker, from 0.
    pub worker: usize,
    /// Seconds from the start of the render.
    pub start: f64,
    /// Seconds that it took.
    pub seconds: f64,
    /// What.
    pub activity: Activity,
}

/// What a worker did.
#[derive(Clone, Copy, Debug)]
pub enum Activity {
    /// A unit of work.
    Unit(Unit),
    /// A stage of a wave.
    Stage {
        /// Which one.
        stage: Stage,
        /// The segment that the paths were on, from 1.
        segment: u32,
        /// Paths, or rays, that it worked on.
        active: u64,
    },
}

/// An [`Event`] before it is known when the render began, and whose it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lap {
    pub(super) start: Instant,
    pub(super) end: Instant,
    pub(super) activity: Activity,
}

impl Lap {
    /// Of worker number `worker` in a render that began at `origin`.
    pub(super) fn event(&self, origin: Instant, worker: usize) -> Event {
        Event {
            worker,
            start: self.start.saturating_duration_since(origin).as_secs_f64(),
            seconds: (self.end - self.start).as_secs_f64(),
            activity: self.activity,
        }
    }
}
