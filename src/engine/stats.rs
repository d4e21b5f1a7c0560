//! What the stages of the wavefront engine did, and the seconds it took them.

use std::time::Instant;

use super::stage::Stage;
use super::tally::Endings;
use super::timeline::{Activity, Lap};
use crate::accel::Counters;
use crate::simd::LANES;

/// What a stage did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageWork {
    /// Paths, or rays, that it worked on.
    pub active: u64,
    /// Lanes of the vectors that it took for them.
    pub issued: u64,
    /// Summed over threads.
    pub seconds: f64,
    /// Of extend and connect, where it is asked for.
    pub counters: Counters,
}

impl StageWork {
    /// Of so many paths or rays, side by side in vectors.
    pub(super) fn of(items: usize) -> Self {
        Self::in_lanes(items, items.next_multiple_of(LANES))
    }

    /// Of so many in more lanes.
    pub(super) fn in_lanes(active: usize, issued: usize) -> Self {
        Self { active: active as u64, issued: issued as u64, ..Self::default() }
    }

    /// The share of its lanes that did any of the work: in the traversal, where that is counted.
    pub fn occupancy(&self) -> f64 {
        let (active, issued) = match self.counters.lanes_issued {
            0 => (self.active, self.issued),
            issued => (self.counters.lanes_active, issued),
        };
        active as f64 / issued.max(1) as f64
    }

    fn add(&mut self, other: &Self) {
        self.active += other.active;
        self.issued += other.issued;
        self.seconds += other.seconds;
        self.counters += other.counters;
    }
}

/// What the stages did for paths on one of their segments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SegmentWork {
    /// Paths that ended on it: rays are endings and rays of the next segment.
    pub endings: Endings,
    works: [StageWork; Stage::ALL.len()],
}

impl SegmentWork {
    /// What `stage` did.
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

/// What the stages did, by segment of the paths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WaveStats {
    /// Of segments 1, 2, … and, in the last, of all from [`WaveStats::SEGMENTS`] on. Generate and
    /// accumulate count for the first.
    pub segments: Vec<SegmentWork>,
}

impl WaveStats {
    /// Segments that are told apart.
    pub const SEGMENTS: usize = 16;

    /// What `stage` did for all segments.
    pub fn stage(&self, stage: Stage) -> StageWork {
        self.segments.iter().fold(StageWork::default(), |mut sum, segment| {
            sum.add(segment.stage(stage));
            sum
        })
    }

    /// All that was done took so long, summed over threads.
    pub fn seconds(&self) -> f64 {
        Stage::ALL.map(|stage| self.stage(stage).seconds).into_iter().sum()
    }

    /// Notes what `stage` did for paths on their segment `segment`.
    pub(super) fn note(&mut self, stage: Stage, segment: u32, work: &StageWork) {
        self.segment_mut(segment).works[stage as usize].add(work);
    }

    /// Where work for paths on their segment `segment` is noted.
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

/// Takes the time of stages.
#[derive(Debug)]
pub(super) struct Stopwatch {
    stats: WaveStats,
    /// The stages one by one, where that is asked for.
    laps: Option<Vec<Lap>>,
    last: Instant,
}

impl Stopwatch {
    /// Keeps the stages one by one where that is asked for.
    pub(super) fn new(timeline: bool) -> Self {
        let laps = timeline.then(Vec::new);
        Self { stats: WaveStats::default(), laps, last: Instant::now() }
    }

    /// The next stage begins.
    pub(super) fn start(&mut self) {
        self.last = Instant::now();
    }

    /// A stage that did `work` for paths on their segment `segment` has ended, the next begins.
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

    /// What was noted since the last time.
    pub(super) fn take(&mut self) -> (WaveStats, Vec<Lap>) {
        let laps = self.laps.as_mut().map(std::mem::take);
        (std::mem::take(&mut self.stats), laps.unwrap_or_default())
    }

    /// So many paths ended on their segment `segment`.
    pub(super) fn ended(&mut self, segment: u32, endings: &Endings) {
        self.stats.segment_mut(segment).endings.add(endings);
    }
}
