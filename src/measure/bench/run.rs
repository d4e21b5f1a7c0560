//! A run: the results of one engine on one scene, block by block.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::accel::Counters;
use crate::engine::{ImageSettings, RayCounts};
use crate::measure::machine::Interference;
use crate::measure::statistics::{Estimate, middle, sorted};

/// Results of one engine on one scene with one number of threads.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Run {
    #[serde(flatten)]
    pub(crate) work: Workload,
    /// BLAKE3 hash of the linear image, which is the same in all blocks.
    pub(crate) hash: String,
    pub(crate) blocks: Vec<Block>,
    /// Millions of rays per second, traced for the closest hit or for occlusion.
    pub(crate) mrays_per_s: Estimate,
    /// Millions of camera paths per second.
    pub(crate) msamples_per_s: Estimate,
    /// Seconds that a render spends in each stage, summed over threads and averaged over all blocks.
    /// Zero for stages that the engine does not have.
    pub(crate) stages: BTreeMap<String, f64>,
    /// Counters of the counting render, which is not timed.
    pub(crate) counters: Counters,
    /// Lanes of the counting render, by segment and stage. For the stages extend and
    /// connect, these are the lanes of the traversal.
    #[serde(default)]
    pub(crate) lanes: Vec<BTreeMap<String, Lanes>>,
    /// Plan of the wavefront engine in the counting render. It stays raw JSON, so that a record can hold
    /// the plans of other versions.
    #[serde(default)]
    pub(crate) plan: Option<Value>,
    /// Plan of the wavefront engine in the timed renders.
    #[serde(default)]
    pub(crate) timed_plan: Option<Value>,
    pub(crate) peak_rss_bytes: u64,
}

/// A scene and how it is rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Workload {
    pub(crate) scene: String,
    /// Hash of the scene. Comparisons ignore it, since versions of ptfast may hash the same scene
    /// differently; the images show whether two runs rendered the same.
    #[serde(default)]
    pub(crate) scene_hash: String,
    pub(crate) engine: String,
    pub(crate) threads: usize,
    #[serde(flatten)]
    pub(crate) settings: ImageSettings,
}

impl Workload {
    /// Whether the speeds of two runs can be compared.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        Self { scene_hash: String::new(), ..self.clone() }
            == Self { scene_hash: String::new(), ..other.clone() }
    }
}

/// Measurements of one side in one block, in which it renders twice.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Block {
    /// Seconds per render: the mean of both.
    pub(crate) seconds: f64,
    /// Rays per render.
    pub(crate) rays: RayCounts,
    /// Mean clock of the cores over the block in GHz, the same for all sides; 0 if it is unknown.
    #[serde(default)]
    pub(crate) clock: f64,
    /// Share of all the machine's cores that other processes kept busy, 0 to 1; the same for all sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) load: Option<f64>,
    /// Interference by others during both renders; `None` for programs that do not report it.
    #[serde(default)]
    pub(crate) interference: Option<Interference>,
    /// Whether the interference was too strong.
    #[serde(default)]
    pub(crate) contaminated: bool,
}

/// Number of vector lanes that were active, and of all that were issued.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Lanes {
    pub(crate) active: u64,
    pub(crate) issued: u64,
}

/// Speed ratio of one side to another: the median over blocks. The ratio of a side to itself is the
/// control.
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
    /// Rays per second.
    pub(crate) fn rays_per_second(&self) -> f64 {
        self.rays.total() as f64 / self.seconds
    }

    /// Camera paths per second.
    pub(crate) fn paths_per_second(&self) -> f64 {
        self.rays.primary as f64 / self.seconds
    }
}

impl Run {
    /// Camera paths per second in each block.
    pub(crate) fn paths_per_second(&self) -> Vec<f64> {
        self.blocks.iter().map(Block::paths_per_second).collect()
    }

    /// Camera paths per clock cycle in each block; `None` if a clock is unknown.
    pub(crate) fn paths_per_cycle(&self) -> Option<Vec<f64>> {
        let of = |block: &Block| {
            (block.clock > 0.0).then(|| block.paths_per_second() / (block.clock * 1e9))
        };
        self.blocks.iter().map(of).collect()
    }

    /// Share of all cores that other processes kept busy: the median over blocks, or `None` if the load
    /// of a block is unknown.
    pub(crate) fn load(&self) -> Option<f64> {
        let loads: Option<Vec<f64>> = self.blocks.iter().map(|block| block.load).collect();
        Some(middle(&sorted(loads?)))
    }

    /// Number of contaminated blocks.
    pub(crate) fn contaminated(&self) -> usize {
        self.blocks.iter().filter(|block| block.contaminated).count()
    }

    /// Share of active lanes in the traversal; `None` if nothing was counted.
    pub(crate) fn occupancy(&self) -> Option<f64> {
        let Counters { lanes_active, lanes_issued, .. } = self.counters;
        (lanes_issued > 0).then(|| lanes_active as f64 / lanes_issued as f64)
    }
}
