//! Compares each run with a baseline or another program: is it faster, slower or the same?

use super::record::Record;
use super::run::{Ratio, Run, Workload};
use super::verdict::{Again, Doubt, Finding, Gate, Verdict};
use super::{Bench, Progress};
use crate::engine::ImageSettings;
use crate::error::{Error, Result};
use crate::measure::machine::Machine;
use crate::measure::statistics::Estimate;

/// The reference that runs are compared with.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Reference<'a> {
    /// A record from another time. Clocks may have been different then, so paths per cycle are
    /// compared.
    Baseline(&'a Record),
    /// The other program of the same bench, compared block by block.
    Against,
}

/// Checks that speeds in `baseline`, a record from `file`, can be compared with those of this
/// machine.
///
/// # Errors
/// If the baseline was measured on another machine.
pub(crate) fn check_machine(baseline: &Record, file: &str) -> Result<()> {
    let (here, there) = (&Machine::this(), &baseline.machine);
    let models = [&here.cpu_model, &there.cpu_model];
    // Old records have no CPU model.
    let same_model = models[0] == models[1] || models.iter().any(|model| model.is_empty());
    if (&here.cpu, here.cores) == (&there.cpu, there.cores) && same_model {
        return Ok(());
    }
    let told = |machine: &Machine| {
        format!("{} cores of `{}` ({})", machine.cores, machine.cpu, machine.cpu_model)
    };
    let (here, there) = (told(here), told(there));
    let message =
        format!("measured on {there}, this machine has {here}: speeds cannot be compared");
    Err(Error::input(file, "machine", message))
}

/// Checks that `baseline`, a record from `file`, has a run with the same workload as a run that
/// `bench` will measure.
///
/// # Errors
/// If `baseline` has no such run.
pub(crate) fn check_works(bench: &Bench, baseline: &Record, file: &str) -> Result<()> {
    let works = bench.works();
    if !baseline.runs.iter().any(|run| works.iter().any(|work| work.is_like(&run.work))) {
        let settings = ImageSettings::names().collect::<Vec<_>>().join(", ");
        let message = format!(
            "no run matches this bench: scene, engine, threads, {settings} must be the same"
        );
        return Err(Error::input(file, "runs", message));
    }
    Ok(())
}

/// Largest difference in load between a run and its baseline, as a share of all cores. Load is the
/// share of the cores that other processes keep busy.
const MOST_LOAD_CHANGE: f64 = 0.1;

/// Maximum number of measurements of a run.
const MOST_MEASUREMENTS: usize = 4;

/// Compares every run of `record`, which `bench` has measured, with the matching run of
/// `reference`, if there is one.
///
/// If `again` is given, it is a number of blocks. Groups with a run that seems to have changed by
/// more than `threshold`, or that was too disturbed to decide, are then measured again with this
/// number of blocks, until they have at most [`MOST_MEASUREMENTS`] measurements in total.
///
/// # Errors
/// If a program fails.
pub(crate) fn judge(
    bench: &Bench,
    record: &Record,
    reference: Reference<'_>,
    threshold: f64,
    again: Option<usize>,
    progress: Progress<'_>,
) -> Result<Gate> {
    let commit = match reference {
        Reference::Baseline(baseline) => &baseline.machine.commit,
        Reference::Against => &bench.machine(1).commit,
    };
    let first = findings(record, reference, threshold).into_iter().map(|(work, finding)| {
        let mut verdict = Verdict::new(work);
        verdict.add(finding, threshold);
        verdict
    });
    let (commit, verdicts) = (commit.clone(), first.collect());
    let mut gate = Gate { threshold, commit, verdicts, again: Vec::new() };
    let Some(blocks) = again else { return Ok(gate) };
    while gate.again.len() + 1 < MOST_MEASUREMENTS
        && gate.verdicts.iter().any(|v| v.is_open(threshold))
    {
        let open = |scene: &str, threads: usize| {
            let mut open = gate.verdicts.iter().filter(|verdict| verdict.is_open(threshold));
            open.any(|verdict| verdict.scene == scene && verdict.threads == threads)
        };
        let next = bench.record(&bench.measure(blocks, open, progress)?);
        for (work, finding) in findings(&next, reference, threshold) {
            let mut open = gate.verdicts.iter_mut().filter(|verdict| verdict.is_open(threshold));
            if let Some(verdict) = open.find(|verdict| verdict.is_of(work)) {
                verdict.add(finding, threshold);
            }
        }
        let against = next.against.map_or_else(Vec::new, |against| against.runs);
        gate.again.push(Again { runs: next.runs, ratios: next.ratios, against });
    }
    Ok(gate)
}

/// Findings of one measurement, for each run with a matching run in the reference.
fn findings<'a>(
    record: &'a Record,
    reference: Reference<'_>,
    threshold: f64,
) -> Vec<(&'a Workload, Finding)> {
    let of = |run: &'a Run| Some((&run.work, finding(run, record, reference, threshold)?));
    record.runs.iter().filter_map(of).collect()
}

fn finding(
    run: &Run,
    record: &Record,
    reference: Reference<'_>,
    threshold: f64,
) -> Option<Finding> {
    let like = |old: &&Run| old.work.is_like(&run.work);
    let (change, old, of_old) = match reference {
        Reference::Baseline(baseline) => {
            let old = baseline.runs.iter().find(like)?;
            let disturbed = doubt(old, baseline, threshold).map(|_| Doubt::Baseline);
            (speed_up(run, old), old, disturbed.or(other_load(run, old)))
        }
        Reference::Against => {
            let against = record.against.as_ref()?;
            let old = against.runs.iter().find(like)?;
            let to = format!("{}@{}", run.work.engine, against.machine.commit);
            (record.ratio(run, &to)?.speed, old, doubt(old, record, threshold))
        }
    };
    let image = (run.hash != old.hash).then_some(Doubt::Image);
    Some(Finding { change, doubt: image.or(of_old).or(doubt(run, record, threshold)) })
}

/// How many times as fast `new` is as `old`, which was measured at another time. Compares paths per
/// cycle if both clocks are known, and paths per second otherwise.
fn speed_up(new: &Run, old: &Run) -> Estimate {
    match (new.paths_per_cycle(), old.paths_per_cycle()) {
        (Some(new), Some(old)) => Estimate::of_ratio(&new, &old),
        _ => Estimate::of_ratio(&new.paths_per_second(), &old.paths_per_second()),
    }
}

/// Returns a doubt if other processes kept more or fewer cores busy during `new` than during `old`.
/// These processes also use memory and caches. The control cannot reveal this, because it suffers
/// equally.
fn other_load(new: &Run, old: &Run) -> Option<Doubt> {
    let (new, old) = new.load().zip(old.load())?;
    ((new - old).abs() > MOST_LOAD_CHANGE).then_some(Doubt::Load)
}

/// Why a run of `record` does not count: most of its blocks are contaminated, it has no control, or
/// its control differs too much from 1. The control's median may differ from 1 by at most the
/// threshold, and its interval must not lie entirely beyond half the threshold.
fn doubt(run: &Run, record: &Record, threshold: f64) -> Option<Doubt> {
    if run.contaminated() * 2 > run.blocks.len() {
        return Some(Doubt::Contaminated);
    }
    let Some(Ratio { speed, .. }) = record.control(run) else { return Some(Doubt::Uncontrolled) };
    let off = |speed: f64| speed.max(1.0 / speed) - 1.0;
    let surely = speed.lo > 1.0 + 0.5 * threshold || 1.0 / speed.hi > 1.0 + 0.5 * threshold;
    (off(speed.median) > threshold || surely).then_some(Doubt::Control)
}

/// Runs of `record` that are too disturbed to serve as a baseline, and why.
pub(crate) fn doubtful(record: &Record, threshold: f64) -> Vec<(&Workload, Doubt)> {
    let of = |run: &'_ Run| doubt(run, record, threshold);
    record.runs.iter().filter_map(|run| Some((&run.work, of(run)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const THRESHOLD: f64 = 0.01;

    #[test]
    fn busier_machines_are_not_compared() {
        let loaded = |load: f64| {
            let mut record = record(1.0, 4.0, 0, CLEAN);
            record.runs[0].blocks.iter_mut().for_each(|block| block.load = Some(load));
            record
        };
        assert_eq!(found(&loaded(0.1), &loaded(0.15)).doubt, None);
        assert_eq!(found(&loaded(0.1), &loaded(0.6)).doubt, Some(Doubt::Load));
        assert_eq!(found(&loaded(0.6), &loaded(0.1)).doubt, Some(Doubt::Load));
        assert_eq!(found(&loaded(0.6), &record(1.0, 4.0, 0, CLEAN)).doubt, None, "unknown load");
    }

    /// A record of one run with a control. Each of its 12 blocks takes about `seconds` at `clock`,
    /// and the first `contaminated` of them are contaminated.
    fn record(seconds: f64, clock: f64, contaminated: usize, control: [f64; 3]) -> Record {
        let block = |number: usize| {
            json!({
                "seconds": seconds * (1.0 + 0.0002 * (number % 3) as f64),
                "rays": { "primary": 1000, "bounce": 1000, "shadow": 0 },
                "clock": clock, "contaminated": number < contaminated,
            })
        };
        let estimate = json!({ "median": 1.0, "lo": 1.0, "hi": 1.0 });
        let [lo, median, hi] = control;
        let record = json!({
            "schema": 1,
            "machine": { "cpu": "a", "cores": 2, "isa": "avx2", "lanes": 8, "os": "", "rustc": "",
                         "flags": "", "commit": "c" },
            "runs": [{
                "scene": "s", "engine": "wavefront", "threads": 1, "width": 1, "height": 1, "spp": 1,
                "depth": 50, "sampling": "bsdf", "seed": 1, "hash": "h", "blocks": (0..12).map(block).collect::<Vec<_>>(),
                "mrays_per_s": estimate, "msamples_per_s": estimate, "stages": {}, "counters": {},
                "peak_rss_bytes": 0,
            }],
            "ratios": [{ "scene": "s", "threads": 1, "of": "wavefront", "to": "wavefront",
                         "median": median, "lo": lo, "hi": hi }],
        });
        serde_json::from_value(record).unwrap()
    }

    const CLEAN: [f64; 3] = [0.998, 1.001, 1.004];

    fn found(new: &Record, old: &Record) -> Finding {
        findings(new, Reference::Baseline(old), THRESHOLD).remove(0).1
    }

    #[test]
    fn changes_follow_the_clock() {
        let old = record(1.0, 4.0, 0, CLEAN);
        let change = |seconds, clock| found(&record(seconds, clock, 0, CLEAN), &old).change;
        let near = |found: Estimate, want: f64| {
            assert!(found.lo <= found.median && found.median <= found.hi, "{found:?}");
            assert!(
                (found.lo - want).abs() < 0.001 && (found.hi - want).abs() < 0.001,
                "{found:?}"
            );
        };
        near(change(1.0, 4.0), 1.0);
        near(change(1.03, 4.0), 1.0 / 1.03);
        // With 4/5 of the clock and 5/4 of the time, the speed per cycle is the same.
        near(change(1.25, 3.2), 1.0);
        near(change(1.0, 3.2), 1.25);
        // Without a known clock, seconds are compared.
        near(change(1.25, 0.0), 0.8);
    }

    #[test]
    fn disturbed_and_different_runs_raise_a_doubt() {
        let (old, slow) = (record(1.0, 4.0, 0, CLEAN), record(1.05, 4.0, 0, CLEAN));
        let doubt = |new: &Record, old: &Record| found(new, old).doubt;
        assert_eq!(doubt(&slow, &old), None);
        assert_eq!(doubt(&record(1.05, 4.0, 6, CLEAN), &old), None);
        assert_eq!(doubt(&record(1.05, 4.0, 7, CLEAN), &old), Some(Doubt::Contaminated));
        assert_eq!(doubt(&slow, &record(1.0, 4.0, 7, CLEAN)), Some(Doubt::Baseline));
        for dirty in
            [[0.9, 1.02, 1.3], [1.006, 1.008, 1.009], [0.97, 0.98, 0.99], [0.9, 0.985, 1.1]]
        {
            let dirty = record(1.05, 4.0, 0, dirty);
            assert_eq!(doubt(&dirty, &old), Some(Doubt::Control), "{dirty:?}");
        }
        let mut other = slow.clone();
        other.ratios.clear();
        assert_eq!(doubt(&other, &old), Some(Doubt::Uncontrolled));
        other.runs[0].hash = "another".to_owned();
        assert_eq!(doubt(&other, &old), Some(Doubt::Image));
    }

    #[test]
    fn other_work_is_not_compared() {
        let old = record(1.0, 4.0, 0, CLEAN);
        let mut new = old.clone();
        new.runs[0].work.threads = 2;
        assert!(findings(&new, Reference::Baseline(&old), THRESHOLD).is_empty());
    }
}
