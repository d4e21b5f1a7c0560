//! Timeline of a render: the activities of each worker and their times, recorded on request.

use std::time::Instant;

use super::Stage;
use crate::film::Unit;

/// An activity of a worker, with its time.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Number of the worker, from 0.
    pub worker: usize,
    /// Seconds from the start of the render.
    pub start: f64,
    /// Duration in seconds.
    pub seconds: f64,
    /// The activity.
    pub activity: Activity,
}

/// An activity of a worker.
#[derive(Clone, Copy, Debug)]
pub enum Activity {
    /// A unit of work.
    Unit(Unit),
    /// A stage of a wave.
    Stage {
        /// The stage.
        stage: Stage,
        /// The segment of the paths, from 1.
        segment: u32,
        /// Number of paths or rays that the stage processed.
        active: u64,
    },
}

/// An activity with absolute times, from which [`Lap::event`] makes an [`Event`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Lap {
    pub(super) start: Instant,
    pub(super) end: Instant,
    pub(super) activity: Activity,
}

impl Lap {
    /// The event of worker number `worker`, with times relative to `origin`.
    pub(super) fn event(&self, origin: Instant, worker: usize) -> Event {
        Event {
            worker,
            start: self.start.saturating_duration_since(origin).as_secs_f64(),
            seconds: (self.end - self.start).as_secs_f64(),
            activity: self.activity,
        }
    }
}
