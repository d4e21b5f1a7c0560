//! `ptfast bench`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::args::BenchArgs;
use super::{advise_on_build, bench_table, notice};
use crate::bench::{
    Bench, Format, Options, Outcome, Record, Reference, Verdict, counter_changes, export, judge,
};
use crate::engine::{Engine, RenderSettings};
use crate::error::{Error, Result, suggestion};
use crate::interrupt;
use crate::isa::Isa;
use crate::output::{check_folder, check_writable, same_file, write_atomically};
use crate::scene::{BUILTIN_NAMES, Scene};

/// Pixels of an image, about, and blocks: in 5 minutes the built-in scenes on two cores.
const USUAL: (u32, u32) = (640 * 360, 12);
/// In a minute.
const QUICK: (u32, u32) = (320 * 180, 6);
/// Exit code where something regressed.
const REGRESSION: u8 = 3;

pub(super) fn run(args: &BenchArgs) -> Result<u8> {
    // Whatever can fail fails before the work is done.
    let (options, blocks) = (options(args)?, blocks(args));
    let exports = exports(args)?;
    check_outputs(args, &exports)?;
    let baseline = args.baseline.as_deref().map(Record::read).transpose()?;
    if !args.quiet {
        advise_on_build(Isa::Avx512);
    }

    // So that what is begun is cleared away.
    interrupt::watch()?;
    if !args.quiet {
        notice(format_args!("everything is rendered once, counted and not timed"));
    }
    let bench = Bench::new(&options, baseline.as_ref())?;
    if let Some(scene) = bench.other_images().next().filter(|_| !args.quiet) {
        notice(format_args!("{scene}: the two programs give different images"));
    }
    let mut progress = Progress::new(args.quiet);
    let sample = bench.measure(blocks, |_, _| true, &mut |done, of| progress.tell(done, of))?;
    let mut record = bench.record(&sample);
    bench_table::print(&record)?;

    let baseline = baseline.as_ref().zip(args.baseline.as_deref());
    if let Some((old, _)) = baseline {
        bench_table::print_counters(&counter_changes(&record, old))?;
    }
    let name = args.baseline.as_ref().map(|file| file.display().to_string()).unwrap_or_default();
    let reference = match baseline {
        Some((old, _)) => Some(Reference::Baseline(old, &name)),
        None => args.against.as_ref().map(|_| Reference::Against),
    };
    if let Some(reference) = reference {
        // What decides alone is measured twice as long: a few busy moments must not hide a change.
        let again = args.gate.then_some(2 * blocks);
        let mut tell = |done, of| progress.tell(done, of);
        let threshold = args.threshold / 100.0;
        let verdicts = judge(&bench, &record, reference, threshold, again, &mut tell)?;
        bench_table::print_verdicts(&verdicts, args.gate.then_some(args.threshold))?;
        // What is not measured again is no verdict.
        record.verdicts = if args.gate { verdicts } else { Vec::new() };
    }
    if let Some(path) = &args.json {
        let json = serde_json::to_string_pretty(&record);
        let json = json.map_err(|error| Error::Internal(error.to_string()))?;
        write_atomically(path, |file| writeln!(file, "{json}"))?;
    }
    let mut failed = None;
    for (format, folder) in exports {
        match export(&record, format, &folder) {
            Ok(file) if !args.quiet => notice(format_args!("{} written", file.display())),
            Ok(_) => {}
            // The others are written all the same.
            Err(error) => failed = failed.or(Some(error)),
        }
    }
    if let Some(error) = failed {
        return Err(error);
    }
    let regressed = |verdict: &Verdict| verdict.outcome == Outcome::Regressed;
    Ok(if args.gate && record.verdicts.iter().any(regressed) { REGRESSION } else { 0 })
}

fn blocks(args: &BenchArgs) -> usize {
    let (_, usual) = if args.quick { QUICK } else { USUAL };
    args.blocks.unwrap_or(usual) as usize
}

fn options(args: &BenchArgs) -> Result<Options> {
    if args.gate && args.baseline.is_none() && args.against.is_none() {
        return Err(Error::Usage(
            "--gate needs --baseline or --against to compare with".to_owned(),
        ));
    }
    if !(args.threshold > 0.0 && args.threshold < 100.0) {
        let message = format!("--threshold must be between 0 and 100, not {}", args.threshold);
        return Err(Error::Usage(message));
    }
    let scenes: Vec<String> = match &args.scenes[..] {
        [] => BUILTIN_NAMES.map(str::to_owned).to_vec(),
        some => without_repeats(some),
    };
    let with_size = |name: String| {
        let defaults = RenderSettings::of(&Scene::load(&name)?);
        Ok((name, size(args, (defaults.width, defaults.height))))
    };
    let engines = match &args.engines[..] {
        // The slow one first: it is what others are compared with.
        [] => vec![Engine::Scalar, Engine::Wavefront],
        some => without_repeats(some),
    };
    let threads = match &args.threads[..] {
        [] => {
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            without_repeats(&[1, cores])
        }
        some => without_repeats(some).into_iter().map(|threads| threads as usize).collect(),
    };
    let this = || std::env::current_exe().map_err(Error::io(Path::new("ptfast"), "find"));
    Ok(Options {
        program: args.program.clone().map_or_else(this, Ok)?,
        against: args.against.clone(),
        scenes: scenes.into_iter().map(with_size).collect::<Result<_>>()?,
        engines,
        threads,
        spp: args.spp,
        seed: args.seed,
    })
}

/// In a scene's proportion: of the width that is asked for, or of about as many pixels as usual.
fn size(args: &BenchArgs, (width, height): (u32, u32)) -> (u32, u32) {
    let (pixels, _) = if args.quick { QUICK } else { USUAL };
    let proportion = f64::from(height) / f64::from(width);
    let usual = (f64::from(pixels) / proportion).sqrt().round().max(1.0) as u32;
    let width = args.width.unwrap_or(usual);
    (width, (f64::from(width) * proportion).round().max(1.0) as u32)
}

fn without_repeats<T: Clone + PartialEq>(values: &[T]) -> Vec<T> {
    let mut unique = Vec::new();
    for value in values {
        if !unique.contains(value) {
            unique.push(value.clone());
        }
    }
    unique
}

/// Formats and folders.
fn exports(args: &BenchArgs) -> Result<Vec<(Format, PathBuf)>> {
    let pair = |pair: &[String]| {
        let format = Format::ALL.into_iter().find(|format| format.name() == pair[0]);
        let format = format.ok_or_else(|| {
            let hint = suggestion(&pair[0], Format::ALL.map(Format::name));
            Error::Usage(format!("--export: no format is named `{}`{hint}", pair[0]))
        })?;
        Ok((format, PathBuf::from(&pair[1])))
    };
    args.export.chunks_exact(2).map(pair).collect()
}

fn check_outputs(args: &BenchArgs, exports: &[(Format, PathBuf)]) -> Result<()> {
    if let Some(path) = &args.json {
        check_writable(path)?;
        if args.baseline.as_ref().is_some_and(|baseline| same_file(baseline, path)) {
            let message = format!("{}: the record would replace the baseline", path.display());
            return Err(Error::Usage(message));
        }
    }
    exports.iter().try_for_each(|(_, folder)| check_folder(folder))
}

/// Tells how many blocks are done.
struct Progress {
    quiet: bool,
    start: Instant,
    told: Option<Instant>,
}

/// Seconds between two lines.
const INTERVAL: f64 = 5.0;

impl Progress {
    fn new(quiet: bool) -> Self {
        Self { quiet, start: Instant::now(), told: None }
    }

    /// `done` of so many blocks are done; the first of a series begins anew.
    fn tell(&mut self, done: usize, of: usize) {
        if done == 0 {
            self.start = Instant::now();
        }
        let due = self.told.is_none_or(|told| told.elapsed().as_secs_f64() >= INTERVAL);
        if self.quiet || done == 0 || !due {
            return;
        }
        self.told = Some(Instant::now());
        let left = self.start.elapsed().as_secs_f64() / done as f64 * (of - done) as f64;
        notice(format_args!("{done} of {of} blocks  ETA {left:.0} s"));
    }
}
