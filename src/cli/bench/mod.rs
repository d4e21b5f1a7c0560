//! `ptfast bench`.

pub(super) mod args;
mod options;
mod table;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use self::args::BenchArgs;
use super::console::{advise_on_build, notice, suppress_notices};
use super::files;
use super::progress::duration;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::isa::Isa;
use crate::measure::bench::{
    Bench, CountChanges, Format, Options, Outcome, Record, Reference, check_export, check_machine,
    check_works, count_changes, doubtful, export, export_file, judge,
};
use crate::measure::machine::Machine;
use crate::output::{same_file, write_atomically};

/// Exit code for a regression.
const REGRESSION: u8 = 3;

pub(crate) fn run(args: &BenchArgs) -> Result<u8> {
    if args.quiet {
        suppress_notices();
    }
    // Check everything that can be checked before the work begins.
    let ((options, read), exports) = (options::options(args)?, options::exports(args)?);
    let (blocks, threshold) = (options::blocks(args), args.threshold / 100.0);
    check_files(args, &options, &read, &exports)?;
    let baseline = args.baseline.as_deref().map(read_baseline).transpose()?;
    advise_on_build(Isa::Avx512);
    notice(format_args!("rendering everything once to count the work"));
    // After a signal, the bench removes its temporary files before it ends.
    interrupt::watch()?;
    let bench = Bench::new(&options, baseline.as_ref().map(|(record, _)| record))?;
    if let Some((baseline, file)) = &baseline {
        check_works(&bench, baseline, file)?;
        report_other_build(&bench, baseline);
    }

    let mut progress = BlockReport::new();
    let mut show = |done, of| progress.show(done, of);
    let mut record = bench.record(&bench.measure(blocks, |_, _| true, &mut show)?);
    write(args, &record)?;
    // The results are printed even if an export fails.
    let exported = exports.iter().try_for_each(|(format, folder)| export(&record, *format, folder));
    table::print(&record)?;
    if args.json.is_some() {
        report_doubts(&record, threshold);
    }
    let reference = match &baseline {
        Some((baseline, _)) => Reference::Baseline(baseline),
        None if args.against.is_some() => Reference::Against,
        None => return exported.map(|()| 0),
    };
    table::print_counts(&counts(&record, reference))?;
    // Measurements are not pooled: each further one is judged on its own. It has twice as many
    // blocks, so that a few disturbed blocks do not hide a change.
    let again = args.gate.then_some(2 * blocks);
    let gate = judge(&bench, &record, reference, threshold, again, &mut show)?;
    if !args.gate {
        // Without `--gate` nothing is measured again, so the changes are printed without a verdict.
        table::print_gate(&record, &gate, false)?;
        return exported.map(|()| 0);
    }
    record.gate = Some(gate.clone());
    write(args, &record)?;
    table::print_gate(&record, &gate, true)?;
    let regressed = gate.verdicts.iter().any(|verdict| verdict.outcome == Outcome::Regressed);
    exported.map(|()| if regressed { REGRESSION } else { 0 })
}

/// A baseline, and the name of its file.
fn read_baseline(path: &Path) -> Result<(Record, String)> {
    let (record, file) = (Record::read(path)?, path.display().to_string());
    check_machine(&record, &file)?;
    Ok((record, file))
}

/// Prints a notice if the program of the baseline was built in another way, which may explain a
/// change of speed.
fn report_other_build(bench: &Bench, baseline: &Record) {
    let build =
        |machine: &Machine| format!("{} ({}), {}", machine.isa, machine.flags, machine.rustc);
    let (here, there) = (build(bench.machine(0)), build(&baseline.machine));
    if here != there {
        notice(format_args!("the baseline's program was built for {there}, this one for {here}"));
    }
}

/// Prints a notice if some runs of a record are too noisy to serve as a baseline.
fn report_doubts(record: &Record, threshold: f64) {
    let doubts: Vec<String> = doubtful(record, threshold)
        .into_iter()
        .map(|(work, doubt)| {
            format!("{} {} {} ({})", work.scene, work.engine, work.threads, doubt.reason())
        })
        .collect();
    if !doubts.is_empty() {
        let doubts = doubts.join(", ");
        notice(format_args!("this record is not usable as a baseline for {doubts}"));
    }
}

fn counts(record: &Record, reference: Reference<'_>) -> CountChanges {
    match (reference, &record.against) {
        (Reference::Baseline(old), _) => count_changes(record, &old.runs, old.machine.lanes),
        (Reference::Against, Some(other)) => {
            count_changes(record, &other.runs, other.machine.lanes)
        }
        (Reference::Against, None) => CountChanges::default(),
    }
}

fn write(args: &BenchArgs, record: &Record) -> Result<()> {
    let Some(path) = &args.json else { return Ok(()) };
    let json = serde_json::to_string_pretty(record);
    let json = json.map_err(|error| Error::Internal(error.to_string()))?;
    write_atomically(path, |file| writeln!(file, "{json}"))
}

/// Checks that output files differ from each other and from input files.
fn check_files(
    args: &BenchArgs,
    options: &Options,
    of_scenes: &[PathBuf],
    exports: &[(Format, PathBuf)],
) -> Result<()> {
    let scenes = of_scenes.iter().map(|file| ("a part of the scene", file.as_path()));
    let named = [
        ("the baseline", &args.baseline),
        ("the program", &args.program),
        ("the other program", &args.against),
    ];
    let named = named.into_iter().filter_map(|(name, file)| Some((name, file.as_deref()?)));
    let read: Vec<files::Named<'_>> = scenes.chain(named).collect();
    let record = args.json.as_deref().map(|file| ("the record", file));
    files::check(&read, record.as_slice())?;

    let runs = options.runs();
    let mut written: Vec<PathBuf> = args.json.clone().into_iter().collect();
    for (format, folder) in exports {
        check_export(&runs, *format, folder)?;
        // The folder of an export may not exist yet, so paths are compared, too.
        let file = export_file(*format, folder);
        let place = |file: &Path| std::path::absolute(file).ok();
        let clash = |other: &Path| same_file(other, &file) || place(other) == place(&file);
        if read.iter().any(|(_, other)| other.exists() && clash(other))
            || written.iter().any(|other| clash(other))
        {
            let message = format!("{}: an export would overwrite this file", file.display());
            return Err(Error::Usage(message));
        }
        written.push(file);
    }
    Ok(())
}

/// Shows how many blocks are done.
struct BlockReport {
    start: Instant,
    shown: Instant,
}

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(5);

impl BlockReport {
    fn new() -> Self {
        let now = Instant::now();
        Self { start: now, shown: now }
    }

    /// Shows that `done` of `of` blocks are done. A `done` of 0 restarts the time for the ETA.
    fn show(&mut self, done: usize, of: usize) {
        if done == 0 {
            self.start = Instant::now();
        } else if self.shown.elapsed() >= INTERVAL {
            self.shown = Instant::now();
            let left = self.start.elapsed().as_secs_f64() * (of - done) as f64 / done as f64;
            notice(format_args!("{done} of {of} blocks  ETA {}", duration(left)));
        }
    }
}
