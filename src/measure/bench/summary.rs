//! Summarizes measurements as records.

use super::block::Series;
use super::record::{Against, SCHEMA};
use super::run::Block;
use super::{Bench, Contest, Measurement, Ratio, Record, Run, Side};
use crate::engine::{Engine, Stage};
use crate::measure::statistics::Estimate;

impl Bench {
    /// Summarizes `measurement` as a record.
    pub(crate) fn record(&self, measurement: &Measurement) -> Record {
        let measured = || {
            let contests = self.contests.iter().zip(&measurement.0);
            contests.filter_map(|(contest, series)| Some((contest, series.as_ref()?)))
        };
        let runs = |program| {
            let of = |(contest, series): (&Contest, &Vec<Series>)| -> Vec<Run> {
                let sides = contest.sides.iter().zip(series);
                let sides = sides.filter(|(side, _)| side.program == program);
                sides.map(|(side, series)| run(contest, side, series)).collect()
            };
            measured().flat_map(of).collect()
        };
        let against = (self.programs.len() > 1)
            .then(|| Against { machine: self.machine(1).clone(), runs: runs(1) });
        let other = against.as_ref().map_or("", |against| &against.machine.commit);
        Record {
            schema: SCHEMA,
            time: self.time.clone(),
            machine: self.machine(0).clone(),
            runs: runs(0),
            ratios: measured()
                .flat_map(|(contest, series)| ratios(contest, series, other))
                .collect(),
            against,
            gate: None,
        }
    }
}

fn run(contest: &Contest, side: &Side, series: &Series) -> Run {
    let counted = &side.counted;
    let over_blocks =
        |of: fn(&Block) -> f64| Estimate::of(series.blocks.iter().map(|block| of(block) * 1e-6));
    let mean = |stage: Stage| {
        let seconds = series.stages.get(stage.name()).copied().unwrap_or(0.0);
        (stage.name().to_owned(), seconds / series.renders as f64)
    };
    Run {
        work: side.work(&contest.task),
        hash: counted.hash.clone(),
        blocks: series.blocks.clone(),
        mrays_per_s: over_blocks(Block::rays_per_second),
        msamples_per_s: over_blocks(Block::paths_per_second),
        stages: Stage::ALL.map(mean).into(),
        counters: counted.counters(),
        lanes: counted.lanes(),
        plan: counted.plan.clone(),
        timed_plan: side.plan.clone(),
        peak_rss_bytes: series.peak_rss_bytes,
    }
}

/// Speed ratios of the pairs of sides worth reporting: wavefront to scalar, the control, and each
/// engine to the same engine of the other program, whose commit is `other`.
fn ratios(contest: &Contest, series: &[Series], other: &str) -> Vec<Ratio> {
    let find = |program, engine| {
        let is = |side: &Side| side.program == program && side.engine == engine;
        contest.sides.iter().position(is)
    };
    let name = |side: usize| contest.sides[side].engine.name().to_owned();
    // Series are in the order of turns: one for each side, then the control.
    let ratio = |of: usize, to: usize, to_name: String| Ratio {
        scene: contest.task.scene.clone(),
        threads: contest.task.threads,
        of: name(of),
        to: to_name,
        speed: speed_ratio(&series[of].blocks, &series[to].blocks),
    };
    let mut ratios = Vec::new();
    if let (Some(of), Some(to)) = (find(0, Engine::Wavefront), find(0, Engine::Scalar)) {
        ratios.push(ratio(of, to, name(to)));
    }
    let control = contest.control();
    ratios.push(ratio(control, contest.sides.len(), name(control)));
    for engine in Engine::ALL {
        if let (Some(of), Some(to)) = (find(0, engine), find(1, engine)) {
            ratios.push(ratio(of, to, format!("{}@{other}", name(to))));
        }
    }
    ratios
}

/// Speed ratio of `of` to `to`, computed block by block.
fn speed_ratio(of: &[Block], to: &[Block]) -> Estimate {
    Estimate::of_positive(of.iter().zip(to).map(|(of, to)| to.seconds / of.seconds))
}
