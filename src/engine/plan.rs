//! The plan of the wavefront engine: how rays are traced. It affects the speed but never the image.

use serde::{Deserialize, Serialize};

use crate::accel::Kernel;
use crate::limits;

/// How the wavefront engine traces rays. In large renders, the engine measures which plan is
/// fastest. A later render with this plan repeats the work and the counts of the first one exactly.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Maximum number of paths of a wave, which a worker traces at once, 1 to 262 144. A wave is
    /// larger only if a single pixel has more paths.
    pub wave_size: u32,
    /// The plans of segments 1, 2, …; the last one also applies to all later segments.
    pub segments: Vec<SegmentPlan>,
}

/// How the rays of a segment are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentPlan {
    /// Whether rays are sorted first, so that neighbours start near each other and have similar
    /// directions. Camera rays are coherent without sorting.
    pub ordered: bool,
    /// The kernel that finds the closest hits.
    pub closest: Kernel,
    /// The kernel that tests whether the shadow rays from these hits are occluded.
    pub occluded: Kernel,
    /// Whether these shadow rays are sorted, too. Otherwise they are in the order of the hits.
    #[serde(default)]
    pub shadows_ordered: bool,
}

/// Who chooses the plan of the wavefront engine.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum PlanChoice {
    /// In large renders, a measurement, which takes a few percent of the time; else as `Usual`.
    #[default]
    Measured,
    /// The plan that is best for most scenes.
    Usual,
    /// This plan, including its wave size.
    Given(Plan),
}

impl From<Option<Plan>> for PlanChoice {
    /// This plan, or else a measurement.
    fn from(plan: Option<Plan>) -> Self {
        plan.map_or(Self::Measured, Self::Given)
    }
}

impl PlanChoice {
    /// The given plan, if there is one.
    pub(crate) fn given(&self) -> Option<&Plan> {
        match self {
            Self::Given(plan) => Some(plan),
            Self::Measured | Self::Usual => None,
        }
    }
}

/// The origin of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planning {
    /// The settings contain the plan.
    Given,
    /// The plan that is best for most scenes, on request or in renders too small for measurements.
    Usual,
    /// The fastest plan of several in a measurement, whose outcome may vary from run to run.
    Measured,
}

names! { pub Planning: Given = "given", Usual = "usual", Measured = "measured" }

impl Plan {
    /// The plan of segment number `segment`, from 1.
    pub fn segment(&self, segment: u32) -> &SegmentPlan {
        let last = self.segments.len() - 1;
        &self.segments[last.min(segment as usize - 1)]
    }

    /// Checks that all numbers are in range.
    ///
    /// # Errors
    /// If a number is out of range, returns a message that names it.
    pub fn check(&self) -> Result<(), String> {
        limits::check("wave_size", self.wave_size, limits::MAX_WAVE)?;
        limits::check("number of segments", self.segments.len() as u32, limits::MAX_DEPTH)
    }
}

impl SegmentPlan {
    /// Describes how closest hits are found, for example `ordered packet`.
    pub(crate) fn closest_by(&self) -> String {
        named(self.ordered, self.closest)
    }

    /// Describes how shadow rays are tested.
    pub(crate) fn occluded_by(&self) -> String {
        named(self.shadows_ordered, self.occluded)
    }
}

fn named(ordered: bool, kernel: Kernel) -> String {
    format!("{}{}", if ordered { "ordered " } else { "" }, kernel.name())
}
