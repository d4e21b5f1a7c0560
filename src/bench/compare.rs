//! Faster, slower or the same? Asked of each run, beside a baseline or another program.

use serde::{Deserialize, Serialize};

use super::record::{Record, Run};
use super::statistics::Estimate;
use super::{Bench, Progress};
use crate::accel::Counters;
use crate::error::{Error, Result};

/// What a run is compared with.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Reference<'a> {
    /// A record of another time, and its file. Clocks are different then: rays a cycle count.
    Baseline(&'a Record, &'a str),
    /// The other program of the same run, block by block.
    Against,
}

/// Of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Verdict {
    pub(crate) scene: String,
    pub(crate) engine: String,
    pub(crate) threads: usize,
    /// How many times as fast it is.
    pub(crate) change: Estimate,
    /// The same, measured once more, where the first was a reason to.
    pub(crate) again: Option<Estimate>,
    pub(crate) outcome: Outcome,
}

/// What came of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Outcome {
    /// Faster by more than the threshold, twice.
    Improved,
    /// Neither is shown.
    Same,
    /// Slower by more than the threshold, twice.
    Regressed,
    /// The machine was too busy: the control is not what it must be, or most blocks are contaminated.
    Unclear,
}

impl Outcome {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Improved => "improved",
            Self::Same => "same",
            Self::Regressed => "REGRESSED",
            Self::Unclear => "unclear",
        }
    }
}

/// Compares every run of `record`, which `bench` has measured, with its like; those that have changed
/// by more than `threshold` (0.01 for 1%) are measured `again` with so many blocks, if any.
///
/// # Errors
/// Where a program fails, or nothing can be compared.
pub(crate) fn judge(
    bench: &Bench,
    record: &Record,
    reference: Reference<'_>,
    threshold: f64,
    again: Option<usize>,
    progress: Progress<'_>,
) -> Result<Vec<Verdict>> {
    if let Reference::Baseline(baseline, file) = reference {
        check_machine(record, baseline, file)?;
    }
    let mut verdicts: Vec<Verdict> =
        record.runs.iter().filter_map(|run| first(run, record, reference, threshold)).collect();
    if let (true, Reference::Baseline(_, file)) = (verdicts.is_empty(), reference) {
        let message = "holds no run of what was measured: scene, size, samples, seed, engine and threads must be the same";
        return Err(Error::input(file, "runs", message));
    }
    let changed =
        |verdict: &Verdict| matches!(verdict.outcome, Outcome::Improved | Outcome::Regressed);
    let doubtful: Vec<(String, usize)> = verdicts
        .iter()
        .filter(|verdict| changed(verdict))
        .map(|verdict| (verdict.scene.clone(), verdict.threads))
        .collect();
    let Some(blocks) = again.filter(|_| !doubtful.is_empty()) else { return Ok(verdicts) };
    let wanted =
        |scene: &str, threads| doubtful.iter().any(|(of, with)| of == scene && *with == threads);
    let again = bench.record(&bench.measure(blocks, wanted, progress)?);
    for verdict in verdicts.iter_mut().filter(|verdict| changed(verdict)) {
        let run = again.runs.iter().find(|run| verdict.is_of(run));
        let second = run.and_then(|run| first(run, &again, reference, threshold));
        verdict.confirm(second);
    }
    Ok(verdicts)
}

/// What one sample says of a run; `None` where it has no like.
fn first(run: &Run, record: &Record, reference: Reference<'_>, threshold: f64) -> Option<Verdict> {
    let change = match reference {
        Reference::Baseline(baseline, _) => {
            change(run, baseline.runs.iter().find(|old| old.is_same_work(run))?)
        }
        Reference::Against => {
            let to = format!("{}@", run.engine);
            let is = |of: &str| of == run.engine;
            let mut ratios = record.ratios.iter().filter(|ratio| {
                ratio.scene == run.scene && ratio.threads == run.threads && is(&ratio.of)
            });
            ratios.find(|ratio| ratio.to.starts_with(&to))?.speed
        }
    };
    let outcome = if is_clear(run, record, threshold) {
        decide(&change, threshold)
    } else {
        Outcome::Unclear
    };
    Some(Verdict {
        scene: run.scene.clone(),
        engine: run.engine.clone(),
        threads: run.threads,
        change,
        again: None,
        outcome,
    })
}

/// How many times as fast `new` is as `old`, measured at another time: a cycle, where both clocks
/// are known.
fn change(new: &Run, old: &Run) -> Estimate {
    let cycles = |run: &Run| -> Option<Vec<f64>> {
        run.blocks.iter().map(|block| block.rays_per_cycle(run.threads)).collect()
    };
    let seconds = |run: &Run| -> Vec<f64> { run.blocks.iter().map(|b| b.speed()).collect() };
    match (cycles(new), cycles(old)) {
        (Some(new), Some(old)) => Estimate::of_ratio(&new, &old),
        _ => Estimate::of_ratio(&seconds(new), &seconds(old)),
    }
}

/// Improved or regressed only where the whole interval is beyond the threshold.
pub(crate) fn decide(change: &Estimate, threshold: f64) -> Outcome {
    if change.lo > 1.0 + threshold {
        Outcome::Improved
    } else if change.hi < 1.0 / (1.0 + threshold) {
        Outcome::Regressed
    } else {
        Outcome::Same
    }
}

/// Whether the machine was quiet enough: what is measured against itself is the same, and no more than
/// half of the blocks are contaminated.
fn is_clear(run: &Run, record: &Record, threshold: f64) -> bool {
    let control = record.control(&run.scene, run.threads);
    control.is_some_and(|control| decide(&control.speed, threshold) == Outcome::Same)
        && run.contaminated() * 2 <= run.blocks.len()
}

impl Verdict {
    fn is_of(&self, run: &Run) -> bool {
        self.scene == run.scene && self.engine == run.engine && self.threads == run.threads
    }

    /// What was measured again must say the same.
    fn confirm(&mut self, second: Option<Self>) {
        self.again = second.as_ref().map(|second| second.change);
        self.outcome = match second.map(|second| second.outcome) {
            Some(second) if second == self.outcome => second,
            Some(Outcome::Unclear) => Outcome::Unclear,
            _ => Outcome::Same,
        };
    }
}

/// Speeds of two machines say nothing of two programs.
fn check_machine(record: &Record, baseline: &Record, file: &str) -> Result<()> {
    let (here, there) = (&record.machine, &baseline.machine);
    if (&here.cpu, here.cores) == (&there.cpu, there.cores) {
        return Ok(());
    }
    let message = format!(
        "measured on {} cores of `{}`, here are {} of `{}`: speeds cannot be compared",
        there.cores, there.cpu, here.cores, here.cpu
    );
    Err(Error::input(file, "machine", message))
}

/// A line for each exact count that is not what it was, where seed, plan and lanes are the same.
pub(crate) fn counter_changes(record: &Record, baseline: &Record) -> Vec<String> {
    let mut lines = Vec::new();
    for run in &record.runs {
        let Some(old) = baseline.runs.iter().find(|old| old.is_same_work(run)) else { continue };
        let same_plan = old.plan == run.plan && record.machine.lanes == baseline.machine.lanes;
        if !same_plan || old.counters == Counters::default() {
            continue;
        }
        for (name, new, old) in differences(&run.counters, &old.counters) {
            let ratio = new as f64 / old as f64;
            let Run { scene, engine, threads, .. } = run;
            lines.push(format!(
                "{scene} {engine} {threads}: {name} {old} -> {new} ({ratio:.4} times as many)"
            ));
        }
    }
    lines
}

/// Counts that are not equal: name, new and old.
fn differences(new: &Counters, old: &Counters) -> impl Iterator<Item = (&'static str, u64, u64)> {
    [
        ("node visits", new.node_visits, old.node_visits),
        ("leaf tests", new.leaf_tests, old.leaf_tests),
        ("lanes issued", new.lanes_issued, old.lanes_issued),
        ("lanes active", new.lanes_active, old.lanes_active),
        ("rays left to scalar", new.scalar_rays, old.scalar_rays),
    ]
    .into_iter()
    .filter(|(_, new, old)| new != old)
}
