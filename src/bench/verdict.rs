//! What is said of runs that are compared.

use serde::{Deserialize, Serialize};

use super::record::{Ratio, Run};
use super::statistics::Estimate;

/// What came of a comparison.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Gate {
    /// The change that counts: 0.01 for 1%.
    pub(crate) threshold: f64,
    /// Commit of what was compared with.
    pub(crate) commit: String,
    pub(crate) verdicts: Vec<Verdict>,
    /// What was measured again, since something seemed to have changed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) again: Option<Again>,
}

/// A second sample.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Again {
    pub(crate) runs: Vec<Run>,
    pub(crate) ratios: Vec<Ratio>,
    /// Of the other program.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) against: Vec<Run>,
}

/// Of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Verdict {
    pub(crate) scene: String,
    pub(crate) engine: String,
    pub(crate) threads: usize,
    /// How many times as fast it is.
    pub(crate) change: Estimate,
    /// The same of the second sample, where there was a reason for one.
    pub(crate) again: Option<Estimate>,
    pub(crate) outcome: Outcome,
    /// Why it is unclear, or still the same.
    #[serde(default)]
    pub(crate) reason: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Outcome {
    /// Faster by more than the threshold, twice.
    Improved,
    /// Neither is shown.
    Same,
    /// Slower by more than the threshold, twice.
    Regressed,
    /// Nothing can be said, for a reason that is told.
    Unclear,
}

impl Outcome {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Improved => "improved",
            Self::Same => "same",
            Self::Regressed => "REGRESSED",
            Self::Unclear => "unclear",
        }
    }

    pub(super) fn is_change(self) -> bool {
        matches!(self, Self::Improved | Self::Regressed)
    }
}

/// Improved or regressed only where the whole interval is beyond the threshold.
pub(crate) fn decide(change: &Estimate, threshold: f64) -> Outcome {
    if change.lo > 1.0 + threshold {
        Outcome::Improved
    } else if change.hi < 1.0 / (1.0 + threshold) {
        Outcome::Regressed
    } else {
        Outcome::Same
    }
}

impl Verdict {
    pub(super) fn is_like(&self, other: &Self) -> bool {
        (&self.scene, &self.engine, self.threads) == (&other.scene, &other.engine, other.threads)
    }

    /// The second sample must say the same.
    pub(super) fn confirm(&mut self, second: Option<&Self>) {
        self.again = second.map(|second| second.change);
        match second {
            Some(second) if second.outcome == self.outcome => {}
            Some(second) if second.outcome == Outcome::Unclear => {
                (self.outcome, self.reason) = (Outcome::Unclear, second.reason.clone());
            }
            _ => (self.outcome, self.reason) = (Outcome::Same, "not confirmed".to_owned()),
        }
    }
}
