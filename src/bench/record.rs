//! The record of a bench, as scripts read it: field names are fixed, more may be added.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::run::{Ratio, Run};
use super::verdict::Gate;
use crate::machine::Machine;

/// The one version of the format.
pub(crate) const SCHEMA: u32 = 1;

/// What was measured in one bench.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Version of the format.
    pub(crate) schema: u32,
    /// When it began, in UTC (RFC 3339).
    #[serde(default)]
    pub(crate) time: String,
    /// Where it ran, and the build that was measured.
    pub(crate) machine: Machine,
    /// One for each scene, number of threads and engine.
    pub(crate) runs: Vec<Run>,
    /// What was measured block by block beside each other.
    pub(crate) ratios: Vec<Ratio>,
    /// The other program, where there was one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) against: Option<Against>,
    /// What came of a comparison with a baseline or another program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) gate: Option<Gate>,
}

/// Another program's part.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Against {
    /// Its build.
    pub(crate) machine: Machine,
    /// As those of this one.
    pub(crate) runs: Vec<Run>,
}

impl Record {
    /// The plan by which the work of an engine was counted.
    pub(super) fn plan(&self, scene: &str, threads: usize, engine: &str) -> Option<Value> {
        let same = |run: &&Run| {
            (&*run.work.engine, &*run.work.scene, run.work.threads) == (engine, scene, threads)
        };
        self.runs.iter().find(same)?.plan.clone()
    }

    /// How many times as fast `run` was as the side of its group that is named `to`.
    pub(crate) fn ratio(&self, run: &Run, to: &str) -> Option<&Ratio> {
        self.ratios.iter().find(|ratio| {
            (&ratio.scene, ratio.threads, &*ratio.of)
                == (&run.work.scene, run.work.threads, &run.work.engine)
                && ratio.to == to
        })
    }

    /// The control of a run's group: how many times as fast as itself a side was.
    pub(crate) fn control(&self, run: &Run) -> Option<&Ratio> {
        self.ratios.iter().find(|ratio| {
            (&ratio.scene, ratio.threads) == (&run.work.scene, run.work.threads)
                && ratio.of == ratio.to
        })
    }
}
