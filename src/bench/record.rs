//! The record of a bench, as scripts read it: field names are fixed, more may be added.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::compare::Verdict;
use super::statistics::Estimate;
use crate::accel::Counters;
use crate::engine::{Plan, RayCounts};
use crate::error::{Error, Result};
use crate::input::read_json;
use crate::machine::{Interference, Machine};

/// The one version of the format.
pub(crate) const SCHEMA: u32 = 1;

/// What was measured in one run.
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
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) verdicts: Vec<Verdict>,
}

/// Another program's part.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Against {
    /// Its path.
    pub(crate) program: String,
    /// Its build.
    pub(crate) machine: Machine,
    /// As those of this one.
    pub(crate) runs: Vec<Run>,
}

/// One engine on one scene with so many threads.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Run {
    pub(crate) scene: String,
    #[serde(default)]
    pub(crate) scene_hash: String,
    pub(crate) engine: String,
    pub(crate) threads: usize,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) spp: u32,
    #[serde(default)]
    pub(crate) depth: u32,
    #[serde(default)]
    pub(crate) sampling: String,
    pub(crate) seed: u64,
    /// BLAKE3 of the linear image, the same in all blocks.
    pub(crate) hash: String,
    pub(crate) blocks: Vec<Block>,
    /// Segments traced for closest hit or occlusion.
    pub(crate) mrays_per_s: Estimate,
    /// Camera paths.
    pub(crate) msamples_per_s: Estimate,
    /// Rays a cycle that the threads were given.
    #[serde(default)]
    pub(crate) rays_per_cycle: Option<Estimate>,
    /// Seconds of a render, summed over threads: means over all blocks. Empty for engines that have
    /// no stages.
    pub(crate) stages: BTreeMap<String, f64>,
    /// From a render that was not timed.
    pub(crate) counters: Counters,
    /// From there too: lanes by segment and stage, of extend and connect those of the traversal.
    #[serde(default)]
    pub(crate) lanes: Vec<BTreeMap<String, Lanes>>,
    /// How the wavefront engine worked there.
    #[serde(default)]
    pub(crate) plan: Option<Plan>,
    /// How it worked when it was timed.
    #[serde(default)]
    pub(crate) timed_plan: Option<Plan>,
    pub(crate) peak_rss_bytes: u64,
}

/// One render after the other, forth and back, took so long for one side.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Block {
    /// Of a render, the mean of two.
    pub(crate) seconds: f64,
    /// Of a render.
    pub(crate) rays: RayCounts,
    /// Clock of the cores in GHz: the mean over the block, the same for all sides.
    #[serde(default)]
    pub(crate) clock: f64,
    /// What others took from both.
    #[serde(default)]
    pub(crate) interference: Interference,
    /// Whether that was too much.
    #[serde(default)]
    pub(crate) contaminated: bool,
}

/// Lanes of vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Lanes {
    pub(crate) active: u64,
    pub(crate) issued: u64,
}

/// How many times as fast one side was as another, in the time that each was given: the median over
/// blocks. A side against itself is the control.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Ratio {
    pub(crate) scene: String,
    #[serde(default)]
    pub(crate) threads: usize,
    pub(crate) of: String,
    pub(crate) to: String,
    #[serde(flatten)]
    pub(crate) speed: Estimate,
}

impl Record {
    /// From a file.
    ///
    /// # Errors
    /// Where it cannot be read, or is no record of a bench.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let record: Self = read_json(path, "the record of a bench")?;
        record
            .check()
            .map_err(|(place, message)| Error::input(path.display().to_string(), place, message))?;
        Ok(record)
    }

    /// `Err` says which place is wrong, and what would be right.
    fn check(&self) -> Result<(), (String, String)> {
        if self.schema != SCHEMA {
            let message = format!("version {} is not known, {SCHEMA} is", self.schema);
            return Err(("schema".to_owned(), message));
        }
        for (number, run) in self.runs.iter().enumerate() {
            let place = format!("runs[{number}].blocks");
            let can_be = |block: &Block| {
                block.seconds > 0.0 && block.seconds.is_finite() && block.rays.total() > 0
            };
            if run.blocks.is_empty() {
                return Err((place, "there must be one at least".to_owned()));
            }
            if let Some(block) = run.blocks.iter().position(|block| !can_be(block)) {
                let message = "seconds and rays must be more than 0".to_owned();
                return Err((format!("{place}[{block}]"), message));
            }
        }
        Ok(())
    }
}

impl Block {
    /// Rays a second.
    pub(crate) fn speed(&self) -> f64 {
        self.rays.total() as f64 / self.seconds
    }

    /// Seconds of a render that its threads had cores for: less what others took.
    pub(crate) fn given(&self, threads: usize) -> f64 {
        let Interference { stolen, waited, .. } = self.interference;
        // That is of two renders and all threads.
        (self.seconds - 0.5 * (stolen + waited) / threads as f64).max(0.1 * self.seconds)
    }

    /// Rays a cycle that so many threads were given; `None` where the clock is not known.
    pub(crate) fn rays_per_cycle(&self, threads: usize) -> Option<f64> {
        let cycles = self.clock * 1e9 * self.given(threads) * threads as f64;
        (cycles > 0.0).then(|| self.rays.total() as f64 / cycles)
    }
}

impl Run {
    /// Whether `other` is the same work.
    pub(crate) fn is_same_work(&self, other: &Self) -> bool {
        let work = |run: &Self| {
            let size = (run.width, run.height, run.spp, run.depth, run.seed);
            (run.scene_hash.clone(), run.sampling.clone(), size, run.threads, run.engine.clone())
        };
        self.scene == other.scene && work(self) == work(other)
    }

    /// Blocks that others disturbed.
    pub(crate) fn contaminated(&self) -> usize {
        self.blocks.iter().filter(|block| block.contaminated).count()
    }

    /// The share of lanes that were of use in the traversal; `None` where nothing was counted.
    pub(crate) fn occupancy(&self) -> Option<f64> {
        let Counters { lanes_active, lanes_issued, .. } = self.counters;
        (lanes_issued > 0).then(|| lanes_active as f64 / lanes_issued as f64)
    }
}
