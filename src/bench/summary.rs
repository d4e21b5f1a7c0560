//! From samples to records.

use super::block::Series;
use super::record::{Against, Block, Ratio, Record, Run, SCHEMA};
use super::statistics::Estimate;
use super::{Bench, Group, Sample, Side};
use crate::engine::{Engine, Plan};
use crate::machine::Machine;

impl Bench {
    /// What `sample` tells.
    pub(crate) fn record(&self, sample: &Sample) -> Record {
        let machine = |program| {
            let mut sides = self.groups.iter().flat_map(|group| &group.sides);
            let side = sides.find(|side| side.program == program);
            side.map_or_else(Machine::this, |side| side.counted.machine.clone())
        };
        let measured = || {
            let groups = self.groups.iter().zip(&sample.0);
            groups.filter_map(|(group, series)| Some((group, series.as_ref()?)))
        };
        let runs = |program| {
            let of = |(group, series): (&Group, &Vec<Series>)| -> Vec<Run> {
                let sides = group.sides.iter().zip(series);
                let sides = sides.filter(|(side, _)| side.program == program);
                sides.map(|(side, series)| run(group, side, series)).collect()
            };
            measured().flat_map(of).collect()
        };
        let against = self.programs.get(1).map(|program| Against {
            program: program.path().display().to_string(),
            machine: machine(1),
            runs: runs(1),
        });
        let other = against.as_ref().map_or("", |against| &against.machine.commit);
        Record {
            schema: SCHEMA,
            time: self.time.clone(),
            machine: machine(0),
            runs: runs(0),
            ratios: measured().flat_map(|(group, series)| ratios(group, series, other)).collect(),
            against,
            verdicts: Vec::new(),
        }
    }
}

fn run(group: &Group, side: &Side, series: &Series) -> Run {
    let (task, counted) = (&group.task, &side.counted);
    let over_blocks = |of: &dyn Fn(&Block) -> f64| Estimate::of(series.blocks.iter().map(of));
    let paths = counted.rays.primary as f64;
    let cycles: Option<Vec<f64>> =
        series.blocks.iter().map(|block| block.rays_per_cycle(task.threads)).collect();
    let stages = series.stages.iter();
    let stages = stages.map(|(stage, seconds)| (stage.clone(), seconds / series.renders as f64));
    Run {
        scene: task.scene.clone(),
        scene_hash: counted.scene_hash.clone(),
        engine: side.engine.name().to_owned(),
        threads: task.threads,
        width: task.width,
        height: task.height,
        spp: task.spp,
        depth: counted.depth,
        sampling: counted.sampling.clone(),
        seed: task.seed,
        hash: counted.hash.clone(),
        blocks: series.blocks.clone(),
        mrays_per_s: over_blocks(&|block| block.speed() * 1e-6),
        msamples_per_s: over_blocks(&|block| paths / block.seconds * 1e-6),
        rays_per_cycle: cycles.map(Estimate::of),
        stages: stages.filter(|(_, seconds)| *seconds > 0.0).collect(),
        counters: counted.counters(),
        lanes: counted.lanes(),
        plan: counted.plan.clone(),
        timed_plan: side.plan.clone(),
        peak_rss_bytes: series.peak_rss_bytes,
    }
}

/// Of each pair of sides that is worth telling; `other` is the commit of the other program.
fn ratios(group: &Group, series: &[Series], other: &str) -> Vec<Ratio> {
    let find = |program, engine| {
        let is = |side: &Side| side.program == program && side.engine == engine;
        group.sides.iter().position(is)
    };
    let name = |place: usize| group.side(place).engine.name().to_owned();
    let ratio = |of: usize, to: usize, to_name: String| Ratio {
        scene: group.task.scene.clone(),
        threads: group.task.threads,
        of: name(of),
        to: to_name,
        speed: speed_ratio(&series[of].blocks, &series[to].blocks, group.task.threads),
    };
    let mut ratios = Vec::new();
    if let (Some(of), Some(to)) = (find(0, Engine::Wavefront), find(0, Engine::Scalar)) {
        ratios.push(ratio(of, to, name(to)));
    }
    let control = group.sides.len();
    ratios.push(ratio(group.control(), control, name(control)));
    for engine in Engine::ALL {
        if let (Some(of), Some(to)) = (find(0, engine), find(1, engine)) {
            ratios.push(ratio(of, to, format!("{}@{other}", name(to))));
        }
    }
    ratios
}

/// How many times as fast `of` was as `to`, block by block.
fn speed_ratio(of: &[Block], to: &[Block], threads: usize) -> Estimate {
    let ratio = |(of, to): (&Block, &Block)| to.given(threads) / of.given(threads);
    Estimate::of_positive(of.iter().zip(to).map(ratio))
}

impl Record {
    /// The plan by which the work of `engine` on such a task was counted.
    pub(super) fn plan(&self, task: &super::Task, engine: Engine) -> Option<Plan> {
        let same = |run: &&Run| {
            run.scene == task.scene && run.threads == task.threads && run.engine == engine.name()
        };
        self.runs.iter().find(same)?.plan.clone()
    }

    /// The control of a group: how many times as fast as itself its side was.
    pub(crate) fn control(&self, scene: &str, threads: usize) -> Option<&Ratio> {
        let of = |ratio: &&Ratio| {
            ratio.scene == scene && ratio.threads == threads && ratio.of == ratio.to
        };
        self.ratios.iter().find(of)
    }
}
