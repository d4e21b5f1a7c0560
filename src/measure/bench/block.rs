//! Measures one block: the sides render in order and then in reverse.
//!
//! The clock of the cores is measured before the first render and after each one.

use std::collections::BTreeMap;
use std::time::Instant;

use super::clock::gigahertz;
use super::program::{Program, Rendered};
use super::run::Block;
use super::{Contest, Side};
use crate::engine::RayCounts;
use crate::error::{Error, Result};
use crate::measure::machine::{Interference, busy_seconds_of_others};

/// Largest share of the renders' core time that a hypervisor and other processes may take in a block.
const MOST_LOST: f64 = 0.05;
/// Maximum number of involuntary context switches per second of core time. With cold caches for about
/// 100 µs after each, they cost 3%.
const MOST_SWITCHES: f64 = 250.0;

/// Measurements of a side, collected over its blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct Series {
    pub(super) blocks: Vec<Block>,
    /// Seconds by stage, summed over all renders.
    pub(super) stages: BTreeMap<String, f64>,
    pub(super) renders: usize,
    pub(super) peak_rss_bytes: u64,
}

/// Measures one block of `contest` and adds the results to `series`, which has the order of the contest's
/// turns. If `reversed`, the last side renders first, so that no side always starts.
pub(super) fn measure(
    programs: &[Program],
    contest: &Contest,
    reversed: bool,
    series: &mut [Series],
) -> Result<()> {
    let sides: Vec<&Side> = contest.turns().collect();
    let mut order: Vec<usize> = (0..sides.len()).collect();
    if reversed {
        order.reverse();
    }
    order.extend_from_within(..);
    let half = order.len() / 2;
    order[half..].reverse();

    let mut rendered: Vec<Vec<Rendered>> = sides.iter().map(|_| Vec::new()).collect();
    let (start, busy) = (Instant::now(), busy_seconds_of_others());
    let mut clocks = vec![gigahertz(contest.task.threads)];
    for turn in order {
        let side = sides[turn];
        let program = &programs[side.program];
        let render = program.render(&contest.task, side.engine, side.plan.as_ref(), false)?;
        check_hash(contest, side, &render)?;
        rendered[turn].push(render);
        clocks.push(gigahertz(contest.task.threads));
    }
    let common = Common {
        threads: contest.task.threads,
        clock: mean(clocks.into_iter()),
        seconds: start.elapsed().as_secs_f64(),
        others: busy
            .zip(busy_seconds_of_others())
            .map(|((before, cores), (after, _))| (after - before, cores)),
    };
    for (series, renders) in series.iter_mut().zip(&rendered) {
        series.add(renders, &common);
    }
    Ok(())
}

/// Fails if the image differs from that of the counting render, because
/// the speed of a wrong render means nothing.
fn check_hash(contest: &Contest, side: &Side, rendered: &Rendered) -> Result<()> {
    let (want, found) = (&side.counted.hash, &rendered.hash);
    if found == want {
        return Ok(());
    }
    let (scene, engine) = (&contest.task.scene, side.engine.name());
    Err(Error::Internal(format!(
        "{scene}: the {engine} engine rendered an image with the hash {want}, then one with {found}"
    )))
}

impl Series {
    fn add(&mut self, renders: &[Rendered], common: &Common) {
        let taken = renders.iter().map(|render| render.interference);
        let interference = taken.reduce(|a, b| Some(a? + b?)).flatten();
        let seconds = mean(renders.iter().map(|render| render.seconds.render));
        let seconds_of_renders = seconds * renders.len() as f64;
        for render in renders {
            for (stage, seconds) in &render.stages {
                *self.stages.entry(stage.clone()).or_default() += seconds;
            }
            self.renders += 1;
            self.peak_rss_bytes = self.peak_rss_bytes.max(render.peak_rss_bytes.unwrap_or(0));
        }
        self.blocks.push(Block {
            seconds,
            rays: renders.first().map_or(RayCounts::default(), |render| render.rays),
            clock: common.clock,
            load: common.load(),
            interference,
            contaminated: interference
                .is_some_and(|taken| common.is_contaminated(&taken, seconds_of_renders)),
        });
    }
}

/// Measurements that all sides of a block share.
struct Common {
    threads: usize,
    /// Mean clock of the cores in GHz.
    clock: f64,
    /// Duration of the block.
    seconds: f64,
    /// Seconds that other processes kept cores busy, summed over cores, and the number of cores.
    others: Option<(f64, usize)>,
}

impl Common {
    fn load(&self) -> Option<f64> {
        let (busy, cores) = self.others?;
        Some((busy / (self.seconds * cores as f64)).clamp(0.0, 1.0))
    }

    /// Whether other processes or a hypervisor took too much core time from renders that lasted
    /// `seconds` in total. Stolen time is only known for all cores together, so it is divided
    /// evenly among the busy cores, ours and those of other processes.
    fn is_contaminated(&self, interference: &Interference, seconds: f64) -> bool {
        let Interference { stolen, waited, switches } = *interference;
        let core_seconds = seconds * self.threads as f64;
        let others = self.others.map_or(0.0, |(busy, _)| (busy / self.seconds).max(0.0));
        let stolen = stolen * self.threads as f64 / (self.threads as f64 + others);
        stolen + waited > MOST_LOST * core_seconds || switches as f64 > MOST_SWITCHES * core_seconds
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contamination_is_a_share_or_a_rate() {
        let block = Common { threads: 1, clock: 3.0, seconds: 2.0, others: None };
        let quiet = Interference { stolen: 0.0, waited: 0.02, switches: 100 };
        assert!(!block.is_contaminated(&quiet, 0.41));
        assert!(block.is_contaminated(&quiet, 0.39));
        assert!(block.is_contaminated(&Interference { switches: 251, ..quiet }, 1.0));
        let stolen = Interference { stolen: 0.04, ..quiet };
        assert!(block.is_contaminated(&stolen, 1.0));
        // Half of the stolen time is attributed to another process, which kept a core busy.
        assert!(!Common { others: Some((2.0, 2)), ..block }.is_contaminated(&stolen, 1.0));
        assert!(Common { others: Some((0.0, 64)), ..block }.is_contaminated(&stolen, 1.0));
    }

    #[test]
    fn load_is_a_share_of_all_cores() {
        let block = Common { threads: 1, clock: 3.0, seconds: 2.0, others: Some((1.0, 4)) };
        assert_eq!(block.load(), Some(0.125));
        assert_eq!(Common { others: Some((-0.01, 4)), ..block }.load(), Some(0.0));
        assert_eq!(Common { others: None, ..block }.load(), None);
    }
}
