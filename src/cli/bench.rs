//! `ptfast bench`.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::bench_args::BenchArgs;
use super::progress::BlockReport;
use super::{advise_on_build, bench_table, files, notice};
use crate::bench::{
    Bench, CountChanges, Format, Gate, Options, Outcome, Record, Reference, check_baseline,
    check_export, count_changes, export, export_file, judge,
};
use crate::engine::{Engine, RenderSettings};
use crate::error::{Error, Result, suggestion};
use crate::interrupt;
use crate::isa::Isa;
use crate::machine::Machine;
use crate::output::{same_file, write_atomically};
use crate::scene::{BUILTIN_NAMES, Scene};

/// How much is measured where nothing is said.
struct Usual {
    /// Of an image, about.
    pixels: u32,
    blocks: u32,
}
const USUAL: Usual = Usual { pixels: 640 * 360, blocks: 12 };
const QUICK: Usual = Usual { pixels: 320 * 180, blocks: 6 };
/// Exit code where something regressed.
const REGRESSION: u8 = 3;

pub(super) fn run(args: &BenchArgs) -> Result<u8> {
    // Whatever can fail fails before the work is done.
    let (options, exports) = (options(args)?, exports(args)?);
    let blocks = args.blocks.unwrap_or(usual(args).blocks) as usize;
    check_files(args, &options, &exports)?;
    let baseline = args.baseline.as_deref().map(Record::read).transpose()?;
    if !args.quiet {
        advise_on_build(Isa::Avx512);
        notice(format_args!("everything is rendered once, counted and not timed"));
    }
    // So that what is begun is cleared away.
    interrupt::watch()?;
    let bench = Bench::new(&options, baseline.as_ref())?;
    if let Some((baseline, file)) = baseline.as_ref().zip(args.baseline.as_ref()) {
        check_baseline(&bench, baseline, &file.display().to_string())?;
        tell_other_build(&bench, baseline, args.quiet);
    }
    for (format, folder) in &exports {
        check_export(&bench.works(), *format, folder)?;
    }

    let mut progress = BlockReport::new(args.quiet);
    let mut tell = |done, of| progress.tell(done, of);
    let mut record = bench.record(&bench.measure(blocks, |_, _| true, &mut tell)?);
    write(args, &record)?;
    bench_table::print(&record)?;
    let reference = match &baseline {
        Some(baseline) => Some(Reference::Baseline(baseline)),
        None => args.against.as_ref().map(|_| Reference::Against),
    };
    if let Some(reference) = reference {
        bench_table::print_counts(&counts(&record, reference))?;
        // What decides alone is measured twice as long: a few busy moments must not hide a change.
        let again = args.gate.then_some(2 * blocks);
        let gate = judge(&bench, &record, reference, args.threshold / 100.0, again, &mut tell)?;
        bench_table::print_gate(&record, &gate, args.gate)?;
        let unclear = gate.verdicts.iter().filter(|v| v.outcome == Outcome::Unclear).count();
        if args.gate && unclear > 0 && !args.quiet {
            notice(format_args!(
                "{unclear} of {} rows are unclear: nothing is said of them",
                record.runs.len()
            ));
        }
        // What is not measured again is no verdict.
        record.gate = Some(gate).filter(|_| args.gate);
        write(args, &record)?;
    }
    for (format, folder) in &exports {
        export(&record, *format, folder)?;
    }
    let regressed =
        |gate: &Gate| gate.verdicts.iter().any(|verdict| verdict.outcome == Outcome::Regressed);
    Ok(if record.gate.as_ref().is_some_and(regressed) { REGRESSION } else { 0 })
}

/// A line where the baseline was built otherwise: it may be that which is compared.
fn tell_other_build(bench: &Bench, baseline: &Record, quiet: bool) {
    let build =
        |machine: &Machine| format!("{} ({}), {}", machine.isa, machine.flags, machine.rustc);
    let (here, there) = (build(bench.machine(0)), build(&baseline.machine));
    if here != there && !quiet {
        notice(format_args!("the baseline was built for {there}, this for {here}"));
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

fn usual(args: &BenchArgs) -> Usual {
    if args.quick { QUICK } else { USUAL }
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
        let proportion = f64::from(defaults.width) / f64::from(defaults.height);
        let usual = (f64::from(usual(args).pixels) * proportion).sqrt().round().max(1.0) as u32;
        let settings = defaults.with_size(args.width.or(Some(usual)), None);
        let settings = RenderSettings { spp: args.spp, ..settings };
        settings.check()?;
        Ok((name, (settings.width, settings.height)))
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

/// No file that is written is one that is read, or written twice.
fn check_files(args: &BenchArgs, options: &Options, exports: &[(Format, PathBuf)]) -> Result<()> {
    let scenes = options.scenes.iter().map(|(scene, _)| ("the scene", Path::new(scene)));
    let named = [
        ("the baseline", &args.baseline),
        ("the program", &args.program),
        ("the other program", &args.against),
    ];
    let named = named.into_iter().filter_map(|(name, file)| Some((name, file.as_deref()?)));
    let read: Vec<files::Named<'_>> = scenes.chain(named).collect();
    let record = args.json.as_deref().map(|file| ("the record", file));
    files::check(&read, record.as_slice())?;
    // Their folders may not be there yet.
    let clash = exports.iter().map(|(format, folder)| export_file(*format, folder)).find(|file| {
        read.iter().chain(&record).any(|(_, other)| file.is_file() && same_file(other, file))
    });
    match clash {
        None => Ok(()),
        Some(file) => Err(Error::Usage(format!("{}: is needed for an export", file.display()))),
    }
}
