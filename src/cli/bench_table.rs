//! What `ptfast bench` prints.

use super::{printable, say};
use crate::bench::{Estimate, Ratio, Record, Run, Verdict};
use crate::engine::{Engine, Stage};
use crate::error::Result;

/// The machine, then a line a run.
pub(super) fn print(record: &Record) -> Result<()> {
    let machine = &record.machine;
    say(format_args!(
        "machine {}, {} cores, {} ({} lanes), {}",
        machine.cpu, machine.cores, machine.isa, machine.lanes, machine.os
    ))?;
    say(format_args!("build   {}, {}, commit {}", machine.rustc, machine.flags, machine.commit))?;
    say(format_args!(
        "\nscene       threads  engine     Mrays/s         Msamples/s  x scalar              lanes  stages"
    ))?;
    for run in &record.runs {
        let named = |of: &str, to: &str| find(record, run, of, to);
        let speedup = named(&run.engine, Engine::Scalar.name())
            .filter(|ratio| ratio.of != ratio.to)
            .map_or_else(String::new, |ratio| interval(&ratio.speed));
        let line = format!(
            "{:<12}{:<9}{:<11}{:>7.2} {:<7} {:>10.2}  {speedup:<22}{:>4}  {}",
            printable(&run.scene),
            run.threads,
            run.engine,
            run.mrays_per_s.median,
            error(&run.mrays_per_s),
            run.msamples_per_s.median,
            lanes(run),
            stages(run),
        );
        say(format_args!("{}", line.trim_end()))?;
    }
    noise(record)
}

/// The ratio of a run's group that has these names.
fn find<'a>(record: &'a Record, run: &Run, of: &str, to: &str) -> Option<&'a Ratio> {
    record.ratios.iter().find(|ratio| {
        ratio.scene == run.scene && ratio.threads == run.threads && ratio.of == of && ratio.to == to
    })
}

/// Shares of the stages, the largest first.
fn stages(run: &Run) -> String {
    let all: f64 = run.stages.values().sum();
    let mut stages: Vec<(&str, f64)> = Stage::ALL
        .into_iter()
        .filter_map(|stage| Some((stage.name(), run.stages.get(stage.name())? / all)))
        .collect();
    stages.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let told = |(name, share): &(&str, f64)| format!("{name} {:.0}%", share * 100.0);
    stages.iter().map(told).collect::<Vec<_>>().join(" ")
}

/// The share of lanes in use, of engines that have some.
fn lanes(run: &Run) -> String {
    let vectors = run.engine != Engine::Scalar.name();
    let share = run.occupancy().filter(|_| vectors);
    share.map_or_else(String::new, |share| format!("{:.0}%", share * 100.0))
}

fn interval(estimate: &Estimate) -> String {
    let Estimate { median, lo, hi } = estimate;
    format!("{median:.2} ({lo:.2} to {hi:.2})")
}

fn error(estimate: &Estimate) -> String {
    format!("±{:.1}%", estimate.relative_error() * 100.0)
}

/// How far the control is from 1, and how many blocks were disturbed.
fn noise(record: &Record) -> Result<()> {
    let controls = record.ratios.iter().filter(|ratio| ratio.of == ratio.to);
    let controls: Vec<String> = controls
        .map(|ratio| {
            format!(
                "{} {} {:.3} ({:.3} to {:.3})",
                printable(&ratio.scene),
                ratio.threads,
                ratio.speed.median,
                ratio.speed.lo,
                ratio.speed.hi
            )
        })
        .collect();
    say(format_args!("\ncontrol, the same against the same: {}", controls.join(", ")))?;
    let disturbed: usize = record.runs.iter().map(Run::contaminated).sum();
    let blocks: usize = record.runs.iter().map(|run| run.blocks.len()).sum();
    say(format_args!(
        "{disturbed} of {blocks} blocks contaminated: others took 5% of the cores or more, or threads had to leave them often"
    ))
}

/// Exact counts that are not what they were.
pub(super) fn print_counters(changes: &[String]) -> Result<()> {
    match changes {
        [] => say(format_args!("\ncounters are those of the baseline, where plan and lanes are")),
        changes => changes.iter().try_for_each(|line| say(format_args!("counter {line}"))),
    }
}

/// What became of each run, with a gate at so many percent if there is one.
pub(super) fn print_verdicts(verdicts: &[Verdict], gate: Option<f64>) -> Result<()> {
    let gated = gate.map_or_else(String::new, |percent| {
        format!("{:<29}by more than {percent}%", "measured again")
    });
    say(format_args!(
        "\n{:<12}{:<9}{:<11}{:<29}{gated}",
        "scene", "threads", "engine", "times as fast as the other"
    ))?;
    for verdict in verdicts {
        let change = |estimate: &Estimate| {
            let Estimate { median, lo, hi } = estimate;
            format!("{median:.4} ({lo:.4} to {hi:.4})")
        };
        let again = verdict.again.as_ref().map_or_else(String::new, change);
        let outcome = if gate.is_some() { verdict.outcome.name() } else { "" };
        let line = format!(
            "{:<12}{:<9}{:<11}{:<29}{again:<29}{outcome}",
            printable(&verdict.scene),
            verdict.threads,
            verdict.engine,
            change(&verdict.change),
        );
        say(format_args!("{}", line.trim_end()))?;
    }
    Ok(())
}
