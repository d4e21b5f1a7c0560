//! The plan: how rays are traced. It decides the speed and never the image.

use serde::{Deserialize, Serialize};

use crate::accel::Kernel;
use crate::limits;

/// How the wavefront engine works: in large renders found by measuring. Given back, it repeats a run
/// with the same work and the same counts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Most paths that a worker traces at once, where a pixel's are not more: 1 to 262 144.
    pub wave_size: u32,
    /// Of segments 1, 2, …; the last holds for all that follow.
    pub segments: Vec<SegmentPlan>,
}

/// How the rays of a segment are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentPlan {
    /// Whether rays that start near each other and go the same way are put together first. Camera
    /// rays are anyway.
    pub ordered: bool,
    /// Finds their closest hits.
    pub closest: Kernel,
    /// Finds whether the shadow rays from there are occluded.
    pub occluded: Kernel,
}

/// Where a plan is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planning {
    /// From the settings.
    Given,
    /// What is mostly best, in renders too small to measure anything.
    Usual,
    /// The fastest of some, by a measurement that may end otherwise another time.
    Measured,
}

impl Planning {
    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Usual => "usual",
            Self::Measured => "measured",
        }
    }
}

/// Paths of a wave: with fewer the last segments have too few, with more they leave the caches.
const USUAL_WAVE: u32 = 1 << 14;
/// Waves for each thread in small renders, so that threads end at about the same time.
const LEAST_WAVES: u64 = 4;

impl Plan {
    /// The plan of segment number `segment`, from 1.
    pub fn segment(&self, segment: u32) -> &SegmentPlan {
        let last = self.segments.len() - 1;
        &self.segments[last.min(segment as usize - 1)]
    }

    /// `Err` says which number is out of range.
    ///
    /// # Errors
    /// Where one is.
    pub fn check(&self) -> Result<(), String> {
        limits::check("wave_size", self.wave_size, limits::MAX_WAVE)?;
        limits::check("number of segments", self.segments.len() as u32, limits::MAX_DEPTH)
    }

    /// The best plan for most scenes with so many primitives, in a render of `paths` paths. A
    /// `wave_size` of 0 stands for the usual one.
    pub(super) fn usual(primitives: usize, paths: u64, threads: usize, wave_size: u32) -> Self {
        let share = (paths / (LEAST_WAVES * threads as u64)).max(1);
        let [first, later] = match primitives {
            0..20 => [Kernel::Flat, Kernel::Flat],
            20..0x4000 => [Kernel::Beam, Kernel::Packet],
            _ => [Kernel::Beam, Kernel::Single],
        };
        let ordered = later == Kernel::Packet;
        Self {
            wave_size: match wave_size {
                0 => share.min(USUAL_WAVE.into()) as u32,
                size => size,
            },
            segments: vec![
                SegmentPlan { ordered: false, closest: first, occluded: later },
                SegmentPlan { ordered, closest: later, occluded: later },
            ],
        }
    }
}

impl SegmentPlan {
    /// How its closest hits are found, in words.
    pub(crate) fn closest_by(&self) -> String {
        format!("{}{}", if self.ordered { "ordered " } else { "" }, self.closest.name())
    }
}
