//! Which kernel is fastest on a scene's rays, found by trying.

use std::ops::Range;
use std::time::Instant;

use super::accelerator::Accelerator;
use super::batch::{HitBatch, RayBatch};
use super::kernel::Kernel;

/// Runs of rays that every kernel is tried on, their length, and how often.
const TRIAL_RUNS: usize = 8;
const TRIAL_RUN: usize = 4096;
const TRIALS: usize = 3;

/// Above this, single rays and beams were faster than packets on every set.
const MOST_IN_PACKET_TREE: usize = 1 << 14;
/// Above this, some tree was faster than none on every set; with 256 spheres none is, on bounces.
const MOST_WITHOUT_TREE: usize = 512;

impl Accelerator {
    /// The kernel that is fastest on runs of rays from all over `rays`, found by trying.
    pub fn choose(&self, any: bool, rays: &RayBatch) -> Kernel {
        if rays.is_empty() {
            return Kernel::Single;
        }
        let apart = rays.len().div_ceil(TRIAL_RUNS).max(TRIAL_RUN);
        let runs = (0..rays.len()).step_by(apart);
        let runs: Vec<Range<usize>> =
            runs.map(|first| first..rays.len().min(first + TRIAL_RUN)).collect();
        let kernels: Vec<Kernel> = Kernel::ALL.into_iter().filter(|&k| self.may_win(k)).collect();
        for &kernel in &kernels {
            self.prepare(kernel);
        }
        let mut hits = HitBatch::misses(rays.len());
        // The least seconds of each run, so that an interruption does not count.
        let mut seconds = vec![vec![f64::INFINITY; runs.len()]; kernels.len()];
        for _ in 0..TRIALS {
            for (&kernel, seconds) in kernels.iter().zip(&mut seconds) {
                for (run, least) in runs.iter().zip(seconds) {
                    let start = Instant::now();
                    if any {
                        self.occluded(kernel, rays, run.clone(), &mut hits);
                    } else {
                        self.closest(kernel, rays, run.clone(), &mut hits);
                    }
                    *least = least.min(start.elapsed().as_secs_f64());
                }
            }
        }
        let total = |i: &usize| seconds[*i].iter().sum::<f64>();
        let fastest = (0..kernels.len()).min_by(|i, j| total(i).total_cmp(&total(j)));
        kernels[fastest.expect("some kernels always may win")]
    }

    /// Whether `kernel` is worth trying on so many primitives.
    pub fn may_win(&self, kernel: Kernel) -> bool {
        match kernel {
            Kernel::Packet => self.geometry.len() <= MOST_IN_PACKET_TREE,
            Kernel::Flat => self.geometry.len() <= MOST_WITHOUT_TREE,
            Kernel::Beam | Kernel::Single => true,
            Kernel::Scalar => false,
        }
    }
}
