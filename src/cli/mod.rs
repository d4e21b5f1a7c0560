//! The command line: parse, run, and say what went wrong in one line.
// Help texts have defaults in brackets, which are no links.
#![allow(rustdoc::broken_intra_doc_links)]

mod args;
mod bench;
mod bench_args;
mod bench_options;
mod bench_table;
mod compare;
mod converge;
mod dashboard;
mod figures;
mod files;
mod keep;
mod keep_args;
mod limits;
mod merge;
mod named;
mod path;
mod place;
mod plan;
mod progress;
mod rays;
mod record;
mod render;
mod sample_args;
mod scenes;
mod scheduler;
mod share;
mod stats;
mod summary;
mod target;
mod timeline;
mod trace;
mod watch;

use std::env;
use std::ffi::OsString;
use std::fmt;
use std::io::{self, Write};
use std::panic;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Parser;
use clap::error::ErrorKind;
use serde_json::json;

use crate::error::{Error, Result};
use crate::interrupt::survive_large_files;
use crate::isa::{Isa, compiled_isa, detected_isa};
use args::{Cli, Command, ScenesCommand};

/// Runs the program with the process's arguments.
pub fn run() -> ExitCode {
    report_panics_in_one_line();
    for_programs(asks_for_json(env::args_os()));
    let code = panic::catch_unwind(|| match Cli::try_parse() {
        Ok(cli) => exit_code(survive_large_files().and_then(|()| dispatch(&cli.command))),
        Err(error) => explain_usage(&error),
    });
    ExitCode::from(code.unwrap_or(INTERNAL_FAULT))
}

const INTERNAL_FAULT: u8 = 70;

fn dispatch(command: &Command) -> Result<u8> {
    match command {
        Command::Render(args) => render::run(args).map(|()| 0),
        Command::Scenes(args) => {
            scenes::run(args.command.as_ref().unwrap_or(&ScenesCommand::List)).map(|()| 0)
        }
        Command::Figures(args) => figures::run(args).map(|()| 0),
        Command::Compare(args) => compare::run(args),
        Command::Merge(args) => merge::run(args).map(|()| 0),
        Command::Rays(args) => rays::run(args).map(|()| 0),
        Command::Path(args) => path::run(args).map(|()| 0),
        Command::Trace(args) => trace::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Converge(args) => converge::run(args).map(|()| 0),
        Command::Dashboard(args) => dashboard::run(args).map(|()| 0),
    }
}

fn exit_code(result: Result<u8>) -> u8 {
    result.unwrap_or_else(|error| {
        complain(&error.to_string(), error.exit_code());
        error.exit_code()
    })
}

/// Help and version go to standard output; a wrong usage becomes one line.
fn explain_usage(error: &clap::Error) -> u8 {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        return exit_code(say(format_args!("{}", error.to_string().trim_end())).map(|()| 0));
    }
    let text = error.to_string();
    let what = text.split("\n\nUsage:").next().unwrap_or_default();
    let what = what.split("\n\nFor more information").next().unwrap_or_default();
    let what = what.strip_prefix("error: ").unwrap_or(what);
    let hint = if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        "a command is missing: render, merge, scenes, figures, compare, converge, rays, path, trace, bench or dashboard"
            .to_owned()
    } else {
        what.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    complain(&format!("{hint} (see `ptfast --help`)"), 2);
    2
}

/// Without what would steer the terminal, which files and their names may say; lines stay.
fn printable(text: &str) -> String {
    let escape = |c: char| {
        let escaped = (c.is_control() && c != '\n').then(|| c.escape_default());
        let plain = escaped.is_none().then_some(c);
        escaped.into_iter().flatten().chain(plain)
    };
    text.chars().flat_map(escape).collect()
}

/// On one line, which is not too long: files may hold words of any length.
fn one_line(text: &str) -> String {
    const MOST: usize = 2000;
    let text = text.replace('\n', "\\n");
    let count = text.chars().count();
    let cut: String = match count > MOST {
        true => {
            let begin = text.chars().take(MOST / 2);
            begin.chain(" ... ".chars()).chain(text.chars().skip(count - MOST / 2)).collect()
        }
        false => text,
    };
    printable(&cut)
}

/// A line, or a few, on standard output.
fn say(lines: fmt::Arguments<'_>) -> Result<()> {
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "{}", printable(&lines.to_string()))
        .and_then(|()| stdout.flush())
        .map_err(Error::io(Path::new("standard output"), "write"))
}

/// Whether a program reads standard error: all lines are JSON.
static FOR_PROGRAMS: AtomicBool = AtomicBool::new(false);

/// Whether these arguments do, right or wrong as they are.
fn asks_for_json(arguments: impl Iterator<Item = OsString>) -> bool {
    let arguments: Vec<_> = arguments.collect();
    let pair = |pair: &[OsString]| pair[0] == "--progress" && pair[1] == "json";
    arguments.windows(2).any(pair) || arguments.iter().any(|word| word == "--progress=json")
}

/// From now on each line on standard error is an object of JSON, or not.
fn for_programs(are: bool) {
    FOR_PROGRAMS.store(are, Ordering::Relaxed);
}

/// A line on standard error.
fn notice(line: fmt::Arguments<'_>) {
    tell("notice", &line.to_string(), None);
}

/// Why the program ends with `code`.
fn complain(message: &str, code: u8) {
    tell("error", message, Some(code));
}

fn tell(event: &str, message: &str, code: Option<u8>) {
    let mut line = format!("ptfast: {}", one_line(message));
    if FOR_PROGRAMS.load(Ordering::Relaxed) {
        let mut object = json!({"schema": 1, "event": event, "message": message});
        if let Some(code) = code {
            object["code"] = code.into();
        }
        line = object.to_string();
    }
    // There is nowhere to say that standard error is closed.
    let _ = writeln!(io::stderr(), "{line}");
}

/// One line where a build for this CPU would be faster: where the build falls behind what the CPU
/// has, up to the instruction set that is still `useful`.
fn advise_on_build(useful: Isa) {
    let (built, has) = (compiled_isa(), detected_isa());
    if built != Isa::Portable && built < has.min(useful) {
        notice(format_args!(
            "built for {built} on a CPU with {has}: rebuild for speed with \
             RUSTFLAGS=\"-C target-cpu=native\" cargo build --release"
        ));
    }
}

fn report_panics_in_one_line() {
    static REPORTED: AtomicBool = AtomicBool::new(false);
    panic::set_hook(Box::new(|info| {
        if !REPORTED.swap(true, Ordering::Relaxed) {
            complain(&format!("internal fault: {info}"), INTERNAL_FAULT);
        }
    }));
}
