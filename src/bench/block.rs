//! A block: each side renders forth and back, and the clock is told in between.

use std::collections::BTreeMap;

use super::clock::gigahertz;
use super::program::{Program, Rendered};
use super::record::Block;
use super::{Group, Side};
use crate::engine::RayCounts;
use crate::error::{Error, Result};
use crate::machine::Interference;

/// Share of the cores' time that a hypervisor and other processes may take of a block.
const MOST_LOST: f64 = 0.05;
/// Times a second that a thread may have to leave its core: caches cold for some 100 µs each
/// are 3%.
const MOST_SWITCHES: f64 = 250.0;

/// What blocks have told of a side.
#[derive(Clone, Debug, Default)]
pub(super) struct Series {
    pub(super) blocks: Vec<Block>,
    /// Seconds by stage, all renders.
    pub(super) stages: BTreeMap<String, f64>,
    pub(super) renders: usize,
    pub(super) peak_rss_bytes: u64,
}

/// Measures one block of `group`: backwards first where it is `reversed`, so that no side is always
/// the first. Adds to `series`, in the order of the group's turns.
pub(super) fn measure(
    programs: &[Program],
    group: &Group,
    reversed: bool,
    series: &mut [Series],
) -> Result<()> {
    let sides: Vec<&Side> = group.turns().collect();
    let mut order: Vec<usize> = (0..sides.len()).collect();
    if reversed {
        order.reverse();
    }
    order.extend_from_within(..);
    let half = order.len() / 2;
    order[half..].reverse();

    let mut rendered: Vec<Vec<Rendered>> = sides.iter().map(|_| Vec::new()).collect();
    let mut clocks = vec![gigahertz(group.task.threads)];
    for turn in order {
        let side = sides[turn];
        let program = &programs[side.program];
        let render = program.render(&group.task, side.engine, side.plan.as_ref(), false)?;
        check_hash(group, side, &render)?;
        rendered[turn].push(render);
        clocks.push(gigahertz(group.task.threads));
    }
    let clock = mean(clocks.into_iter());
    for (series, renders) in series.iter_mut().zip(&rendered) {
        series.add(renders, group.task.threads, clock);
    }
    Ok(())
}

/// A wrong answer is never a fast one.
fn check_hash(group: &Group, side: &Side, rendered: &Rendered) -> Result<()> {
    let (want, found) = (&side.counted.hash, &rendered.hash);
    if found == want {
        return Ok(());
    }
    let (scene, engine) = (&group.task.scene, side.engine.name());
    Err(Error::Internal(format!(
        "{scene}: the {engine} engine gave the image {want}, then {found}"
    )))
}

impl Series {
    fn add(&mut self, renders: &[Rendered], threads: usize, clock: f64) {
        let taken = renders.iter().map(|render| render.interference);
        let interference = taken.reduce(|a, b| Some(a? + b?)).flatten();
        let seconds = mean(renders.iter().map(|render| render.seconds.render));
        let core_seconds = seconds * (renders.len() * threads) as f64;
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
            clock,
            interference,
            contaminated: interference.is_some_and(|taken| is_contaminated(&taken, core_seconds)),
        });
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// Whether others took too much while threads worked for so many seconds.
fn is_contaminated(interference: &Interference, core_seconds: f64) -> bool {
    let Interference { stolen, waited, switches } = *interference;
    stolen + waited > MOST_LOST * core_seconds || switches as f64 > MOST_SWITCHES * core_seconds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contamination_is_a_share_or_a_rate() {
        let quiet = Interference { stolen: 0.0, waited: 0.02, switches: 100 };
        assert!(!is_contaminated(&quiet, 0.41));
        assert!(is_contaminated(&quiet, 0.39));
        assert!(is_contaminated(&Interference { stolen: 0.04, ..quiet }, 1.0));
        assert!(is_contaminated(&Interference { switches: 251, ..quiet }, 1.0));
    }
}
