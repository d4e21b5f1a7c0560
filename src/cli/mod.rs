//! The command line: parse, run, and say what went wrong in one line.

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
mod limits;
mod merge;
mod path;
mod plan;
mod progress;
mod rays;
mod record;
mod render;
mod scenes;
mod share;
mod stats;
mod target;
mod timeline;
mod trace;

use std::fmt;
use std::io::{self, Write};
use std::panic;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Parser;
use clap::error::ErrorKind;

use crate::error::{Error, Result};
use crate::interrupt::survive_large_files;
use crate::isa::{Isa, compiled_isa, detected_isa};
use args::{Cli, Command, ScenesCommand};

/// Runs the program with the process's arguments.
pub fn run() -> ExitCode {
    report_panics_in_one_line();
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
        notice(format_args!("{}", printable(&error.to_string())));
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
    notice(format_args!("{hint} (see `ptfast --help`)"));
    2
}

/// `text` on one line: what a file or its name says must not steer the terminal.
fn printable(text: &str) -> String {
    text.chars()
        .flat_map(|c| {
            let escaped = c.is_control().then(|| c.escape_default());
            let plain = (!c.is_control()).then_some(c);
            escaped.into_iter().flatten().chain(plain)
        })
        .collect()
}

/// A line on standard output.
fn say(line: fmt::Arguments<'_>) -> Result<()> {
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "{line}")
        .and_then(|()| stdout.flush())
        .map_err(Error::io(Path::new("standard output"), "write"))
}

/// A line on standard error.
fn notice(line: fmt::Arguments<'_>) {
    // There is nowhere to say that standard error is closed.
    let _ = writeln!(io::stderr(), "ptfast: {line}");
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
            notice(format_args!("internal fault: {}", printable(&info.to_string())));
        }
    }));
}
