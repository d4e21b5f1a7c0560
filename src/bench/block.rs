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
/// the first. Adds to `series`, in the order of the group's places.
pub(super) fn measure(
    programs: &[Program],
    group: &Group,
    reversed: bool,
    series: &mut [Series],
) -> Result<()> {
    let mut order = group.places();
    if reversed {
        order.reverse();
    }
    order.extend_from_within(..);
    let half = order.len() / 2;
    order[half..].reverse();

    let mut turns: Vec<Vec<Rendered>> = group.places().iter().map(|_| Vec::new()).collect();
    let mut clocks = vec![gigahertz(group.task.threads)];
    for place in order {
        let side = group.side(place);
        let program = &programs[side.program];
        let rendered = program.render(&group.task, side.engine, side.plan.as_ref(), false)?;
        check_hash(group, side, &rendered)?;
        turns[place].push(rendered);
        clocks.push(gigahertz(group.task.threads));
    }
    let clock = mean(clocks.into_iter());
    for (series, turns) in series.iter_mut().zip(&turns) {
        series.add(turns, group.task.threads, clock);
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
    fn add(&mut self, turns: &[Rendered], threads: usize, clock: f64) {
        let taken = turns.iter().map(|turn| turn.interference);
        let interference = taken.reduce(|a, b| Some(a? + b?)).flatten();
        let seconds = mean(turns.iter().map(|turn| turn.seconds.render));
        let core_seconds = seconds * (turns.len() * threads) as f64;
        for turn in turns {
            for (stage, seconds) in &turn.stages {
                *self.stages.entry(stage.clone()).or_default() += seconds;
            }
            self.renders += 1;
            self.peak_rss_bytes = self.peak_rss_bytes.max(turn.peak_rss_bytes.unwrap_or(0));
        }
        self.blocks.push(Block {
            seconds,
            rays: turns.first().map_or(RayCounts::default(), |turn| turn.rays),
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
