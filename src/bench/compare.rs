//! Faster, slower or the same? Asked of each run, beside a baseline or another program.

use super::record::{Ratio, Record, Run};
use super::statistics::Estimate;
use super::verdict::{Again, Gate, Outcome, Verdict, decide};
use super::{Bench, Progress};
use crate::error::{Error, Result};

/// What runs are compared with.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Reference<'a> {
    /// A record of another time. Clocks were different then: paths a cycle count.
    Baseline(&'a Record),
    /// The other program of the same bench, block by block.
    Against,
}

/// Whether what `bench` will measure can be compared with `baseline`, a record from `file`.
///
/// # Errors
/// Where it was measured on another machine, or holds nothing of the same work.
pub(crate) fn check_baseline(bench: &Bench, baseline: &Record, file: &str) -> Result<()> {
    let (here, there) = (bench.machine(0), &baseline.machine);
    if (&here.cpu, here.cores) != (&there.cpu, there.cores) {
        let message = format!(
            "measured on {} cores of `{}`, here are {} of `{}`: speeds cannot be compared",
            there.cores, there.cpu, here.cores, here.cpu
        );
        return Err(Error::input(file, "machine", message));
    }
    let works = bench.works();
    if !baseline.runs.iter().any(|run| works.contains(&run.work())) {
        let message = "holds nothing of what is to be measured: scene and its hash, size, samples, depth, \
                       sampling, seed, engine and threads must be the same";
        return Err(Error::input(file, "runs", message));
    }
    Ok(())
}

/// Compares every run of `record`, which `bench` has measured, with its like, if it has one. Where some
/// have changed by more than `threshold`, their groups are measured `again` with so many blocks, if
/// any: what is said of them then needs both samples.
///
/// # Errors
/// Where a program fails.
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
    let verdicts = verdicts(record, reference, threshold);
    let mut gate = Gate { threshold, commit: commit.clone(), verdicts, again: None };
    let doubtful = |scene: &str, threads: usize| {
        let of = |verdict: &&Verdict| verdict.scene == scene && verdict.threads == threads;
        gate.verdicts.iter().filter(of).any(|verdict| verdict.outcome.is_change())
    };
    let any = gate.verdicts.iter().any(|verdict| verdict.outcome.is_change());
    let Some(blocks) = again.filter(|_| any) else { return Ok(gate) };
    let second = bench.record(&bench.measure(blocks, doubtful, progress)?);
    let confirming = self::verdicts(&second, reference, threshold);
    for verdict in gate.verdicts.iter_mut().filter(|verdict| verdict.outcome.is_change()) {
        verdict.confirm(confirming.iter().find(|second| second.is_like(verdict)));
    }
    gate.again = Some(Again {
        runs: second.runs,
        ratios: second.ratios,
        against: second.against.map_or_else(Vec::new, |against| against.runs),
    });
    Ok(gate)
}

/// What one sample says of each run that has a like.
fn verdicts(record: &Record, reference: Reference<'_>, threshold: f64) -> Vec<Verdict> {
    let verdict = |run: &Run| -> Option<Verdict> {
        let (change, old_run, old_record) = match reference {
            Reference::Baseline(baseline) => {
                let old = baseline.runs.iter().find(|old| old.work() == run.work())?;
                (change(run, old), old, baseline)
            }
            Reference::Against => {
                let against = record.against.as_ref()?;
                let old = against.runs.iter().find(|old| old.work() == run.work())?;
                let to = format!("{}@{}", run.engine, against.machine.commit);
                (record.ratio(run, &to)?.speed, old, record)
            }
        };
        let doubt = (run.hash != old_run.hash)
            .then_some("another image")
            .or_else(|| doubt(run, record, threshold))
            .or_else(|| doubt(old_run, old_record, threshold).map(|_| "the other was disturbed"));
        Some(Verdict {
            scene: run.scene.clone(),
            engine: run.engine.clone(),
            threads: run.threads,
            change,
            again: None,
            outcome: doubt.map_or_else(|| decide(&change, threshold), |_| Outcome::Unclear),
            reason: doubt.unwrap_or_default().to_owned(),
        })
    };
    record.runs.iter().filter_map(verdict).collect()
}

/// How many times as fast `new` is as `old`, measured at another time: a cycle, where both clocks
/// are known.
fn change(new: &Run, old: &Run) -> Estimate {
    match (new.paths_per_cycle(), old.paths_per_cycle()) {
        (Some(new), Some(old)) => Estimate::of_ratio(&new, &old),
        _ => Estimate::of_ratio(&new.paths_per_second(), &old.paths_per_second()),
    }
}

/// Why nothing can be said of a run of `record`: its control is off 1 by more than the threshold, or by
/// half of it for certain; or most of its blocks are contaminated.
fn doubt(run: &Run, record: &Record, threshold: f64) -> Option<&'static str> {
    if run.contaminated() * 2 > run.blocks.len() {
        return Some("most blocks are contaminated");
    }
    let Some(Ratio { speed, .. }) = record.control(run) else { return Some("there is no control") };
    let off = |speed: f64| speed.max(1.0 / speed) - 1.0;
    let surely = speed.lo > 1.0 + 0.5 * threshold || 1.0 / speed.hi > 1.0 + 0.5 * threshold;
    (off(speed.median) > threshold || surely).then_some("the control is not 1")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const THRESHOLD: f64 = 0.01;

    /// A record of one run: seconds of its blocks at such a clock, so many of them contaminated, and
    /// a control.
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
                "seed": 1, "hash": "h", "blocks": (0..12).map(block).collect::<Vec<_>>(),
                "mrays_per_s": estimate, "msamples_per_s": estimate, "stages": {}, "counters": {},
                "peak_rss_bytes": 0,
            }],
            "ratios": [{ "scene": "s", "threads": 1, "of": "wavefront", "to": "wavefront",
                         "median": median, "lo": lo, "hi": hi }],
        });
        serde_json::from_value(record).unwrap()
    }

    const CLEAN: [f64; 3] = [0.998, 1.001, 1.004];

    fn verdict(new: &Record, old: &Record) -> Verdict {
        verdicts(new, Reference::Baseline(old), THRESHOLD).remove(0)
    }

    #[test]
    fn verdicts_follow_the_clock() {
        let old = record(1.0, 4.0, 0, CLEAN);
        let outcome = |seconds, clock| verdict(&record(seconds, clock, 0, CLEAN), &old).outcome;
        assert_eq!(outcome(1.0, 4.0), Outcome::Same);
        assert_eq!(outcome(1.03, 4.0), Outcome::Regressed);
        assert_eq!(outcome(0.97, 4.0), Outcome::Improved);
        assert_eq!(outcome(1.009, 4.0), Outcome::Same, "within the threshold");
        // A clock of four fifths: a quarter longer is the same.
        assert_eq!(outcome(1.25, 3.2), Outcome::Same);
        assert_eq!(outcome(1.0, 3.2), Outcome::Improved);
        // Without one, seconds are all there is.
        assert_eq!(outcome(1.25, 0.0), Outcome::Regressed);
    }

    #[test]
    fn nothing_is_said_where_there_is_doubt() {
        let (old, slow) = (record(1.0, 4.0, 0, CLEAN), record(1.05, 4.0, 0, CLEAN));
        assert_eq!(verdict(&slow, &old).outcome, Outcome::Regressed);
        let reason = |new: &Record, old: &Record| {
            let Verdict { outcome, reason, .. } = verdict(new, old);
            assert_eq!(outcome, Outcome::Unclear);
            reason
        };
        assert_eq!(verdict(&record(1.05, 4.0, 6, CLEAN), &old).outcome, Outcome::Regressed);
        assert!(reason(&record(1.05, 4.0, 7, CLEAN), &old).contains("contaminated"));
        assert!(reason(&slow, &record(1.0, 4.0, 7, CLEAN)).contains("the other"));
        for dirty in
            [[0.9, 1.02, 1.3], [1.006, 1.008, 1.009], [0.97, 0.98, 0.99], [0.9, 0.985, 1.1]]
        {
            assert!(reason(&record(1.05, 4.0, 0, dirty), &old).contains("control"), "{dirty:?}");
        }
        let mut other = slow.clone();
        other.runs[0].hash = "another".to_owned();
        assert_eq!(reason(&other, &old), "another image");
        other.ratios.clear();
        other.runs[0].hash = "h".to_owned();
        assert!(reason(&other, &old).contains("no control"));
    }

    #[test]
    fn other_work_is_not_compared() {
        let old = record(1.0, 4.0, 0, CLEAN);
        let mut new = old.clone();
        new.runs[0].spp = 2;
        assert!(verdicts(&new, Reference::Baseline(&old), THRESHOLD).is_empty());
    }

    #[test]
    fn a_second_sample_must_say_the_same() {
        let old = record(1.0, 4.0, 0, CLEAN);
        let of = |seconds| verdict(&record(seconds, 4.0, 0, CLEAN), &old);
        let confirmed = |second: Option<&Verdict>| {
            let mut first = of(1.05);
            first.confirm(second);
            (first.outcome, first.reason)
        };
        assert_eq!(confirmed(Some(&of(1.04))), (Outcome::Regressed, String::new()));
        for second in [of(1.0), of(0.95)] {
            let (outcome, reason) = confirmed(Some(&second));
            assert_eq!((outcome, &*reason), (Outcome::Same, "not confirmed"));
        }
        assert_eq!(confirmed(None).0, Outcome::Same);
        let unclear = verdict(&record(1.05, 4.0, 12, CLEAN), &old);
        assert_eq!(confirmed(Some(&unclear)).0, Outcome::Unclear);
    }
}
