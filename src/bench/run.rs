//! A run: what one engine did on one scene, block by block.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::accel::Counters;
use crate::engine::RayCounts;
use crate::machine::Interference;
use crate::statistics::{Estimate, middle, sorted};

/// One engine on one scene with so many threads.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Run {
    #[serde(flatten)]
    pub(crate) work: Workload,
    /// BLAKE3 of the linear image, the same in all blocks.
    pub(crate) hash: String,
    pub(crate) blocks: Vec<Block>,
    /// Segments traced for closest hit or occlusion.
    pub(crate) mrays_per_s: Estimate,
    /// Camera paths.
    pub(crate) msamples_per_s: Estimate,
    /// Seconds of a render, summed over threads: means over all blocks. Zeros where an engine has no
    /// such stage.
    pub(crate) stages: BTreeMap<String, f64>,
    /// From a render that was not timed.
    pub(crate) counters: Counters,
    /// From there too: lanes by segment and stage, of extend and connect those of the traversal.
    #[serde(default)]
    pub(crate) lanes: Vec<BTreeMap<String, Lanes>>,
    /// The plan by which the wavefront engine worked there. As it was written: what other versions can
    /// plan is no concern of the record.
    #[serde(default)]
    pub(crate) plan: Option<Value>,
    /// The plan by which it worked when it was timed.
    #[serde(default)]
    pub(crate) timed_plan: Option<Value>,
    pub(crate) peak_rss_bytes: u64,
}

/// What is rendered, and how: runs of the same work can be compared.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Workload {
    pub(crate) scene: String,
    /// Versions of ptfast may hash the same scene differently: whether two runs rendered the same is
    /// seen from their images, and this is no part of the comparison.
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
    /// Nothing where the program knew of no choice.
    #[serde(default)]
    pub(crate) sampler: String,
    pub(crate) seed: u64,
}

impl PartialEq for Workload {
    fn eq(&self, other: &Self) -> bool {
        let numbers =
            |work: &Self| (work.threads, work.width, work.height, work.spp, work.depth, work.seed);
        let names = |work: &Self| {
            let Self { scene, engine, sampling, sampler, .. } = work;
            [scene, engine, sampling, sampler].map(String::clone)
        };
        numbers(self) == numbers(other) && names(self) == names(other)
    }
}

impl Eq for Workload {}

/// One side in one block: two renders.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Block {
    /// Of a render, the mean of both.
    pub(crate) seconds: f64,
    /// Of a render.
    pub(crate) rays: RayCounts,
    /// Clock of the cores in GHz: the mean over the block, the same for all sides.
    #[serde(default)]
    pub(crate) clock: f64,
    /// Share of all the machine's cores that other processes kept busy, 0 to 1: the same for all sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) load: Option<f64>,
    /// What others took from both renders; unknown of programs that do not tell.
    #[serde(default)]
    pub(crate) interference: Option<Interference>,
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

/// How many times as fast one side was as another: the median over blocks. A side against itself is
/// the control.
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

impl Block {
    /// Rays a second.
    pub(crate) fn rays_per_second(&self) -> f64 {
        self.rays.total() as f64 / self.seconds
    }

    /// Camera paths a second.
    pub(crate) fn paths_per_second(&self) -> f64 {
        self.rays.primary as f64 / self.seconds
    }
}

impl Run {
    /// Of each block.
    pub(crate) fn paths_per_second(&self) -> Vec<f64> {
        self.blocks.iter().map(Block::paths_per_second).collect()
    }

    /// Camera paths a cycle of the clock, of each block; `None` where clocks are not known.
    pub(crate) fn paths_per_cycle(&self) -> Option<Vec<f64>> {
        let of = |block: &Block| {
            (block.clock > 0.0).then(|| block.paths_per_second() / (block.clock * 1e9))
        };
        self.blocks.iter().map(of).collect()
    }

    /// Share of all cores that other processes kept busy: the median over blocks, where it is known.
    pub(crate) fn load(&self) -> Option<f64> {
        let loads: Option<Vec<f64>> = self.blocks.iter().map(|block| block.load).collect();
        Some(middle(&sorted(loads?)))
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
