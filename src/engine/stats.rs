//! Work and times of the wavefront engine's stages.

use std::time::Instant;

use super::{Activity, Endings, Lap, Stage};
use crate::accel::Counters;
use crate::simd::LANES;

/// The work and time of a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageWork {
    /// Number of paths or rays that the stage processed.
    pub active: u64,
    /// Number of vector lanes that the stage used, inactive lanes included.
    pub issued: u64,
    /// Seconds, summed over threads.
    pub seconds: f64,
    /// Work of the kernels. Only extend and connect have it, and only if the settings ask for
    /// counting.
    pub counters: Counters,
}

impl StageWork {
    /// The work on `items` paths or rays that are packed into vectors without gaps.
    pub(super) fn of(items: usize) -> Self {
        Self::in_lanes(items, items.next_multiple_of(LANES))
    }

    /// The work on `active` paths or rays in `issued` lanes.
    pub(super) fn in_lanes(active: usize, issued: usize) -> Self {
        Self { active: active as u64, issued: issued as u64, ..Self::default() }
    }

    /// The share of lanes that were active: in the traversal, if its work was counted, otherwise in
    /// the whole stage.
    pub fn occupancy(&self) -> f64 {
        let (active, issued) = match self.counters.lanes_issued {
            0 => (self.active, self.issued),
            issued => (self.counters.lanes_active, issued),
        };
        active as f64 / issued.max(1) as f64
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.active += other.active;
        self.issued += other.issued;
        self.seconds += other.seconds;
        self.counters += other.counters;
    }
}

/// The work of all stages for one segment of the paths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SegmentWork {
    /// Paths that ended on this segment. Together with the number of rays of the next segment, they
    /// give the number of rays of this segment.
    pub endings: Endings,
    works: [StageWork; Stage::ALL.len()],
}

impl SegmentWork {
    /// The work of `stage`.
    pub fn stage(&self, stage: Stage) -> &StageWork {
        &self.works[stage as usize]
    }

    fn add(&mut self, other: &Self) {
        self.endings.add(&other.endings);
        for (work, other) in self.works.iter_mut().zip(&other.works) {
            work.add(other);
        }
    }
}

/// The work of all stages, by segment of the paths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WaveStats {
    /// The work for segments 1, 2, …. Entry number [`WaveStats::SEGMENTS`] is the last and covers
    /// all later segments, too. Generate and accumulate belong to the first segment.
    pub segments: Vec<SegmentWork>,
}

impl WaveStats {
    /// Maximum number of segments that are counted separately.
    pub const SEGMENTS: usize = 16;

    /// The work of `stage` for all segments.
    pub fn stage(&self, stage: Stage) -> StageWork {
        self.segments.iter().fold(StageWork::default(), |mut sum, segment| {
            sum.add(segment.stage(stage));
            sum
        })
    }

    /// Seconds of all stages, summed over threads.
    pub fn seconds(&self) -> f64 {
        Stage::ALL.map(|stage| self.stage(stage).seconds).into_iter().sum()
    }

    /// Adds the work of `stage` for segment number `segment`.
    pub(super) fn note(&mut self, stage: Stage, segment: u32, work: &StageWork) {
        self.segment_mut(segment).works[stage as usize].add(work);
    }

    /// The entry for segment number `segment`, from 1. Adds entries as needed.
    fn segment_mut(&mut self, segment: u32) -> &mut SegmentWork {
        let index = (segment as usize).min(Self::SEGMENTS) - 1;
        if self.segments.len() <= index {
            self.segments.resize(index + 1, Default::default());
        }
        &mut self.segments[index]
    }

    pub(super) fn add(&mut self, other: &Self) {
        if self.segments.len() < other.segments.len() {
            self.segments.resize(other.segments.len(), Default::default());
        }
        for (segment, other) in self.segments.iter_mut().zip(&other.segments) {
            segment.add(other);
        }
    }
}

/// Measures the time of stages.
#[derive(Debug)]
pub(super) struct Stopwatch {
    stats: WaveStats,
    /// One lap per stage, if a timeline is recorded.
    laps: Option<Vec<Lap>>,
    last: Instant,
}

impl Stopwatch {
    /// Creates a stopwatch, which records laps if `timeline` is set.
    pub(super) fn new(timeline: bool) -> Self {
        let laps = timeline.then(Vec::new);
        Self { stats: WaveStats::default(), laps, last: Instant::now() }
    }

    /// Starts the first stage, and forgets those of a unit that was abandoned.
    pub(super) fn start(&mut self) {
        self.stats = WaveStats::default();
        self.laps.iter_mut().for_each(Vec::clear);
        self.last = Instant::now();
    }

    /// Ends `stage`, which did `work` for segment number `segment`, and starts the next stage.
    pub(super) fn lap(&mut self, stage: Stage, segment: u32, work: StageWork) {
        let now = Instant::now();
        let seconds = (now - self.last).as_secs_f64();
        if let Some(laps) = &mut self.laps {
            let activity = Activity::Stage { stage, segment, active: work.active };
            laps.push(Lap { start: self.last, end: now, activity });
        }
        self.last = now;
        self.stats.note(stage, segment, &StageWork { seconds, ..work });
    }

    /// Returns the work and laps since the last call.
    pub(super) fn take(&mut self) -> (WaveStats, Vec<Lap>) {
        let laps = self.laps.as_mut().map(std::mem::take);
        (std::mem::take(&mut self.stats), laps.unwrap_or_default())
    }

    /// Adds the paths that ended on segment number `segment`.
    pub(super) fn ended(&mut self, segment: u32, endings: &Endings) {
        self.stats.segment_mut(segment).endings.add(endings);
    }
}
