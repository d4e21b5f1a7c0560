//! Units of work: what the renderer hands to an engine's workers, and what they return.

use glam::Vec3;

use super::plan::{Plan, Planning};
use super::stats::WaveStats;
use super::tally::Tally;
use super::timeline::Lap;
use crate::film::{Part, Plane, Unit};

/// What an engine does: its workers take units of work.
pub(super) trait UnitEngine: Send + Sync + std::fmt::Debug {
    /// What a thread works with, for units of at most so many paths.
    fn worker(&self, paths: u64) -> Box<dyn UnitWorker + '_>;

    /// Paths that it takes best at once.
    fn unit_paths(&self) -> u32;

    /// How it works, if it has a plan, where that is from, and the seconds that finding it took.
    fn plan(&self) -> Option<(&Plan, Planning, f64)> {
        None
    }
}

/// What a thread does.
pub(super) trait UnitWorker {
    /// Renders `task`; `None` where `abandon`, which is called now and then, returns true.
    fn take(&mut self, task: &Task, abandon: &dyn Fn() -> bool) -> Option<Taken>;
}

/// A unit of work, and what it adds to.
#[derive(Debug)]
pub(super) struct Task {
    pub(super) unit: Unit,
    /// [`Film::open_sums`](crate::film::Film::open_sums).
    pub(super) open: Plane,
}

impl Task {
    /// The sum that the samples of pixel number `pixel` of the unit are added to.
    #[inline]
    pub(super) fn open_sum(&self, pixel: u32) -> Vec3 {
        self.open.get(pixel as usize).map_or(Vec3::ZERO, |sum| Vec3::from(*sum))
    }
}

/// What came of a unit of work.
#[derive(Debug)]
pub(super) struct Taken {
    pub(super) part: Part,
    pub(super) tally: Tally,
    pub(super) waves: WaveStats,
    /// The stages one by one, if that was asked for.
    pub(super) laps: Vec<Lap>,
}
