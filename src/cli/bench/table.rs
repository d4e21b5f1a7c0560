//! What `ptfast bench` prints.

use crate::cli::console::say;
use crate::engine::{Engine, Stage};
use crate::error::Result;
use crate::measure::bench::{CountChanges, Gate, Outcome, Ratio, Record, Run, Verdict, Workload};
use crate::measure::settings;
use crate::measure::statistics::Estimate;

/// Prints the machine, then a line per run.
pub(crate) fn print(record: &Record) -> Result<()> {
    let machine = &record.machine;
    say(format_args!(
        "machine {}, {} cores, {} ({} lanes), {}",
        &machine.cpu, machine.cores, &machine.isa, machine.lanes, &machine.os
    ))?;
    let build = format!("{}, {}, commit {}", machine.rustc, machine.flags, machine.commit);
    say(format_args!("build   {}", &build))?;
    if let Some(run) = record.runs.first() {
        let settings = settings::describe(&run.work.settings);
        let blocks = run.blocks.len();
        say(format_args!("blocks  {blocks}, each renders everything twice, at about {settings}"))?;
    }
    say(format_args!(""))?;
    say(format_args!(
        "{}{:>8}  {:<7}{:>11}  {:<22}{:>6}  most time in",
        who(record, "scene", "threads", "engine"),
        "Mrays/s",
        "",
        "Msamples/s",
        "x scalar",
        "lanes"
    ))?;
    for run in &record.runs {
        let to_scalar = record.ratio(run, Engine::Scalar.name()).filter(|r| r.of != r.to);
        let speedup = to_scalar.map_or_else(String::new, |ratio| interval(&ratio.speed));
        line(record, run, &run.work.engine, &speedup)?;
    }
    if let Some(other) = &record.against {
        for run in &other.runs {
            line(record, run, &format!("{}@", run.work.engine), "")?;
        }
        say(format_args!("@: commit {}", &other.machine.commit))?;
    }
    noise(record)
}

/// The first columns, wide enough for the longest name in the record.
fn who(record: &Record, scene: &str, threads: &str, engine: &str) -> String {
    let names = record.runs.iter().map(|run| run.work.scene.chars().count());
    let width = names.max().unwrap_or(0).max("spacetime".len()) + 2;
    format!("{scene:<width$}{threads:<9}{engine:<12}")
}

fn line(record: &Record, run: &Run, engine: &str, speedup: &str) -> Result<()> {
    let busy = match run.contaminated() {
        0 => String::new(),
        blocks => format!("  {blocks} blocks contaminated"),
    };
    let line = format!(
        "{}{:>8.2}  {:<7}{:>11.2}  {speedup:<22}{:>6}  {}{busy}",
        who(record, &run.work.scene, &run.work.threads.to_string(), engine),
        run.mrays_per_s.median,
        error(&run.mrays_per_s),
        run.msamples_per_s.median,
        lanes(run),
        stages(run),
    );
    say(format_args!("{}", line.trim_end()))
}

/// The three stages with the largest shares of the time.
fn stages(run: &Run) -> String {
    let all: f64 = run.stages.values().sum();
    let mut stages: Vec<(&str, f64)> = Stage::ALL
        .into_iter()
        .filter_map(|stage| Some((stage.name(), run.stages.get(stage.name())? / all)))
        .collect();
    stages.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let describe = |(name, share): &(&str, f64)| format!("{name} {:.0}%", share * 100.0);
    stages
        .iter()
        .filter(|(_, share)| *share > 0.0)
        .take(3)
        .map(describe)
        .collect::<Vec<_>>()
        .join(" ")
}

/// The share of active lanes; empty for the scalar engine.
fn lanes(run: &Run) -> String {
    let vectors = run.work.engine != Engine::Scalar.name();
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

/// Prints the controls, which should be 1, and how many blocks other processes disturbed.
fn noise(record: &Record) -> Result<()> {
    let controls = record.ratios.iter().filter(|ratio| ratio.of == ratio.to);
    let controls: Vec<String> = controls
        .map(|Ratio { scene, threads, speed: Estimate { median, lo, hi }, .. }| {
            format!("{} {threads} {median:.3} ({lo:.3} to {hi:.3})", scene)
        })
        .collect();
    say(format_args!(""))?;
    say(format_args!("control, a build against itself: {}", controls.join(", ")))?;
    let others = record.against.iter().flat_map(|against| &against.runs);
    let runs: Vec<&Run> = record.runs.iter().chain(others).collect();
    let disturbed: usize = runs.iter().map(|run| run.contaminated()).sum();
    let blocks: usize = runs.iter().map(|run| run.blocks.len()).sum();
    say(format_args!(
        "contaminated blocks, in which other processes or a hypervisor took more than 5% of the \
         core time, or threads were preempted often: {disturbed} of {blocks}"
    ))
}

/// Prints the exact counts that changed.
pub(crate) fn print_counts(changes: &CountChanges) -> Result<()> {
    let CountChanges { compared, others, lines } = changes;
    let others = match others {
        0 => String::new(),
        _ => format!("; {others} differ in work, plan or lanes and cannot be compared"),
    };
    let result = if lines.is_empty() { "no change" } else { "changed" };
    say(format_args!(""))?;
    say(format_args!("exact counts of {compared} runs compared: {result}{others}"))?;
    lines.iter().try_for_each(|line| say(format_args!("counter {}", line)))
}

/// Prints the change of each run of `record`, and the outcomes if they were `judged`.
pub(crate) fn print_gate(record: &Record, gate: &Gate, judged: bool) -> Result<()> {
    let gated = if judged {
        format!("{:<29}by more than {}%", "measured again", gate.threshold * 100.0)
    } else {
        String::new()
    };
    let times = format!("times {} ", &gate.commit);
    say(format_args!(""))?;
    say(format_args!("{}{times:<29}{gated}", who(record, "scene", "threads", "engine")))?;
    for run in &record.runs {
        let change = match gate.verdicts.iter().find(|verdict| verdict.is_of(&run.work)) {
            None => "not in the baseline".to_owned(),
            Some(verdict) => describe(verdict, gate.threshold, judged),
        };
        let Workload { scene, threads, engine, .. } = &run.work;
        let who = who(record, scene, &threads.to_string(), engine);
        say(format_args!("{}", format!("{who}{change}").trim_end()))?;
    }
    if !judged {
        return Ok(());
    }
    let count = |outcome| gate.verdicts.iter().filter(|v| v.outcome == outcome).count();
    say(format_args!(
        "gate: {} regressed, {} improved, {} the same, {} unclear, {} not compared",
        count(Outcome::Regressed),
        count(Outcome::Improved),
        count(Outcome::Same),
        count(Outcome::Unclear),
        record.runs.len() - gate.verdicts.len()
    ))
}

/// The measurements that decided the verdict, or else the last one, and the outcome.
fn describe(verdict: &Verdict, threshold: f64, judged: bool) -> String {
    let change = |estimate: &Estimate| {
        let Estimate { median, lo, hi } = estimate;
        format!("{median:.4} ({lo:.4} to {hi:.4})")
    };
    let mut counted = verdict.counted(threshold).map(change);
    let last = verdict.findings.last();
    let or_last = || last.map(|finding| change(&finding.change));
    let (first, again) = (counted.next().or_else(or_last), counted.next());
    let (first, again) = (first.unwrap_or_default(), again.unwrap_or_default());
    if !judged {
        let doubt = last.and_then(|finding| finding.doubt);
        return format!("{first:<29}{}", doubt.map_or("", |doubt| doubt.reason()));
    }
    let measurements = verdict.findings.len();
    let discarded = measurements - verdict.counted(threshold).count();
    let discarded =
        (discarded > 0).then(|| format!("{discarded} of {measurements} measurements discarded"));
    let reason = Some(verdict.reason.clone()).filter(|reason| !reason.is_empty());
    let why: Vec<String> = reason.into_iter().chain(discarded).collect();
    let why = if why.is_empty() { String::new() } else { format!(" ({})", why.join(", ")) };
    format!("{first:<29}{again:<29}{}{why}", verdict.outcome.name())
}
