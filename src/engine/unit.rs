//! Units of work that the renderer hands to an engine's workers, and their results.

use super::{Lap, Plan, Planning, Tally, WaveStats};
use crate::film::{Sums, Unit, UnitSums};

/// An engine, which creates workers that render units of work.
pub(super) trait UnitEngine: Send + Sync + std::fmt::Debug {
    /// Creates the worker of a thread, for units of at most `paths` paths.
    fn worker(&self, paths: u64) -> Box<dyn UnitWorker>;

    /// The number of paths of a unit that suits the engine best.
    fn unit_paths(&self) -> u32;

    /// The plan, its origin, and the seconds spent on finding it; `None` for engines without a
    /// plan.
    fn plan(&self) -> Option<(&Plan, Planning, f64)> {
        None
    }
}

/// Renders units of work on one thread.
pub(super) trait UnitWorker: Send + std::fmt::Debug {
    /// Renders `task`. Calls `abandon` now and then, and returns `None` if it returns true.
    fn take(&mut self, task: &Task, abandon: &dyn Fn() -> bool) -> Option<Taken>;
}

/// A unit of work, and the sums to which its samples are added.
#[derive(Debug)]
pub(super) struct Task {
    pub(super) unit: Unit,
    /// The unit's [`Film::open_sums`](crate::film::Film::open_sums).
    pub(super) open: Sums,
    /// Number of channels of a sample.
    pub(super) channels: usize,
}

impl Task {
    /// The sums to which the samples of the unit's pixels are added, one row per pixel.
    pub(super) fn open_sums(&self) -> Sums {
        match self.open.is_empty() {
            true => vec![0.0; self.unit.tile.pixels() as usize * self.channels],
            false => self.open.clone(),
        }
    }
}

/// The result of a unit of work.
#[derive(Debug)]
pub(super) struct Taken {
    pub(super) part: UnitSums,
    pub(super) tally: Tally,
    pub(super) waves: WaveStats,
    /// The times of the stages and of the unit, if a timeline is recorded.
    pub(super) laps: Vec<Lap>,
}
