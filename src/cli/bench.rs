//! `ptfast bench`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::bench_args::BenchArgs;
use super::{advise_on_build, bench_options, bench_table, files, notice, printable};
use crate::bench::{
    Bench, CountChanges, Format, Options, Outcome, Record, Reference, check_export, check_machine,
    check_works, count_changes, doubtful, export, export_file, judge,
};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::isa::Isa;
use crate::machine::Machine;
use crate::output::{same_file, write_atomically};

/// Exit code where something regressed.
const REGRESSION: u8 = 3;

pub(super) fn run(args: &BenchArgs) -> Result<u8> {
    // Whatever can fail fails before the work is done.
    let ((options, read), exports) = (bench_options::options(args)?, bench_options::exports(args)?);
    let (blocks, threshold) = (bench_options::blocks(args), args.threshold / 100.0);
    check_files(args, &options, &read, &exports)?;
    let baseline = args.baseline.as_deref().map(read_baseline).transpose()?;
    if !args.quiet {
        advise_on_build(Isa::Avx512);
        notice(format_args!("everything is rendered once, counted and not timed"));
    }
    // So that what is begun is cleared away.
    interrupt::watch()?;
    let bench = Bench::new(&options, baseline.as_ref().map(|(record, _)| record))?;
    if let Some((baseline, file)) = &baseline {
        check_works(&bench, baseline, file)?;
        tell_other_build(&bench, baseline, args.quiet);
    }

    let mut progress = BlockReport::new(args.quiet);
    let mut tell = |done, of| progress.tell(done, of);
    let mut record = bench.record(&bench.measure(blocks, |_, _| true, &mut tell)?);
    write(args, &record)?;
    // What was measured is told, even where an export fails.
    let exported = exports.iter().try_for_each(|(format, folder)| export(&record, *format, folder));
    bench_table::print(&record)?;
    if args.json.is_some() && !args.quiet {
        tell_doubts(&record, threshold);
    }
    let reference = match &baseline {
        Some((baseline, _)) => Reference::Baseline(baseline),
        None if args.against.is_some() => Reference::Against,
        None => return exported.map(|()| 0),
    };
    bench_table::print_counts(&counts(&record, reference))?;
    // What decides alone is measured twice as long: a few busy moments must not hide a change.
    let again = args.gate.then_some(2 * blocks);
    let gate = judge(&bench, &record, reference, threshold, again, &mut tell)?;
    if !args.gate {
        // What is not measured again is no verdict.
        bench_table::print_gate(&record, &gate, false)?;
        return exported.map(|()| 0);
    }
    record.gate = Some(gate.clone());
    write(args, &record)?;
    bench_table::print_gate(&record, &gate, true)?;
    let regressed = gate.verdicts.iter().any(|verdict| verdict.outcome == Outcome::Regressed);
    exported.map(|()| if regressed { REGRESSION } else { 0 })
}

/// A baseline, and its name.
fn read_baseline(path: &Path) -> Result<(Record, String)> {
    let (record, file) = (Record::read(path)?, path.display().to_string());
    check_machine(&record, &file)?;
    Ok((record, file))
}

/// A line where the baseline was built otherwise: it may be that which is compared.
fn tell_other_build(bench: &Bench, baseline: &Record, quiet: bool) {
    let build =
        |machine: &Machine| format!("{} ({}), {}", machine.isa, machine.flags, machine.rustc);
    let (here, there) = (build(bench.machine(0)), build(&baseline.machine));
    if here != there && !quiet {
        let (here, there) = (printable(&here), printable(&there));
        notice(format_args!("the baseline was built for {there}, this for {here}"));
    }
}

/// A line where some runs of a record could not be compared with.
fn tell_doubts(record: &Record, threshold: f64) {
    let doubts: Vec<String> = doubtful(record, threshold)
        .into_iter()
        .map(|(work, doubt)| {
            format!("{} {} {} ({})", work.scene, work.engine, work.threads, doubt.reason())
        })
        .collect();
    if !doubts.is_empty() {
        let doubts = doubts.join(", ");
        notice(format_args!("as a baseline it would tell nothing of {}", printable(&doubts)));
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

/// No file that is written is one that is read, or written twice.
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
        // Its folder may not be there yet.
        let file = export_file(*format, folder);
        let place = |file: &Path| std::path::absolute(file).ok();
        let clash = |other: &Path| same_file(other, &file) || place(other) == place(&file);
        if read.iter().any(|(_, other)| other.exists() && clash(other))
            || written.iter().any(|other| clash(other))
        {
            let message = format!("{}: is needed for an export", file.display());
            return Err(Error::Usage(message));
        }
        written.push(file);
    }
    Ok(())
}

/// Tells how many blocks are done.
struct BlockReport {
    quiet: bool,
    start: Instant,
    told: Instant,
}

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(5);

impl BlockReport {
    fn new(quiet: bool) -> Self {
        let now = Instant::now();
        Self { quiet, start: now, told: now }
    }

    /// `done` of so many blocks are done; the first of a series begins anew.
    fn tell(&mut self, done: usize, of: usize) {
        if done == 0 {
            self.start = Instant::now();
        } else if !self.quiet && self.told.elapsed() >= INTERVAL {
            self.told = Instant::now();
            let left = self.start.elapsed().as_secs_f64() * (of - done) as f64 / done as f64;
            notice(format_args!("{done} of {of} blocks  ETA {left:.0} s"));
        }
    }
}
