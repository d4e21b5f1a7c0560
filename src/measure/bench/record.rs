//! The record of a bench. Scripts read it, so its field names are fixed; fields may be added.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Gate, Ratio, Run};
use crate::measure::machine::Machine;

/// The only supported version of the format.
pub(crate) const SCHEMA: u32 = 1;

/// Results of one bench.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Version of the format.
    pub(crate) schema: u32,
    /// Start of the bench in UTC (RFC 3339).
    #[serde(default)]
    pub(crate) time: String,
    /// The machine, and the build that was measured.
    pub(crate) machine: Machine,
    /// One run for each scene, number of threads and engine.
    pub(crate) runs: Vec<Run>,
    /// Speed ratios of sides that were measured in the same blocks.
    pub(crate) ratios: Vec<Ratio>,
    /// Results of the other program, if there was one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) against: Option<Against>,
    /// Result of a comparison with a baseline or another program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) gate: Option<Gate>,
}

/// Results of the other program of a bench.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Against {
    /// The machine, and the build of the other program.
    pub(crate) machine: Machine,
    /// Its runs, in the form of [`Record::runs`].
    pub(crate) runs: Vec<Run>,
}

impl Record {
    /// The plan with which the work of an engine was counted.
    pub(super) fn plan(&self, scene: &str, threads: usize, engine: &str) -> Option<Value> {
        let same = |run: &&Run| {
            (&*run.work.engine, &*run.work.scene, run.work.threads) == (engine, scene, threads)
        };
        self.runs.iter().find(same)?.plan.clone()
    }

    /// Speed ratio of `run` to the side named `to`, for the same scene and number of threads.
    pub(crate) fn ratio(&self, run: &Run, to: &str) -> Option<&Ratio> {
        self.ratios.iter().find(|ratio| {
            (&ratio.scene, ratio.threads, &*ratio.of)
                == (&run.work.scene, run.work.threads, &run.work.engine)
                && ratio.to == to
        })
    }

    /// The control of a run's contest: the speed ratio of a side to itself.
    pub(crate) fn control(&self, run: &Run) -> Option<&Ratio> {
        self.ratios.iter().find(|ratio| {
            (&ratio.scene, ratio.threads) == (&run.work.scene, run.work.threads)
                && ratio.of == ratio.to
        })
    }
}
