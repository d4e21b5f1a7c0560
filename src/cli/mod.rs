//! The command line: parses arguments, runs a command, and reports an error in one line.
//!
//! Each command has a file or a folder with its arguments, which clap parses, and a function `run`, which validates
//! them before any work begins.
// Help texts have defaults in brackets, which are not links.
#![allow(rustdoc::broken_intra_doc_links)]

mod args;
mod arguments;
mod bench;
mod compare;
mod console;
mod converge;
mod dashboard;
mod denoise;
mod figures;
mod files;
mod folder;
mod merge;
mod path;
mod progress;
mod rays;
mod render;
mod scenes;
mod trace;
mod usage;
mod view;

use std::env;
use std::ffi::OsString;
use std::panic;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::Result;
use crate::interrupt::survive_large_files;
use args::Command;
use console::complain;
use scenes::ScenesCommand;

const INTERNAL_FAULT: u8 = 70;

/// Runs the program with the process's arguments.
pub fn run() -> ExitCode {
    report_panics_in_one_line();
    console::write_json(asks_for_json(env::args_os()));
    let code = panic::catch_unwind(|| match usage::parse(env::args_os()) {
        Ok(cli) => exit_code(survive_large_files().and_then(|()| dispatch(&cli.command))),
        Err(error) => usage::explain(&error),
    });
    ExitCode::from(code.unwrap_or(INTERNAL_FAULT))
}

fn dispatch(command: &Command) -> Result<u8> {
    match command {
        Command::Render(args) => render::run(args).map(|()| 0),
        Command::Scenes(args) => {
            scenes::run(args.command.as_ref().unwrap_or(&ScenesCommand::List)).map(|()| 0)
        }
        Command::Figures(args) => figures::run(args).map(|()| 0),
        Command::Compare(args) => compare::run(args),
        Command::Denoise(args) => denoise::run(args).map(|()| 0),
        Command::Merge(args) => merge::run(args).map(|()| 0),
        Command::Rays(args) => rays::run(args).map(|()| 0),
        Command::Path(args) => path::run(args).map(|()| 0),
        Command::Trace(args) => trace::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Converge(args) => converge::run(args).map(|()| 0),
        Command::Dashboard(args) => dashboard::run(args).map(|()| 0),
        Command::View(args) => view::run(args).map(|()| 0),
    }
}

fn exit_code(result: Result<u8>) -> u8 {
    result.unwrap_or_else(|error| {
        complain(&error.to_string(), error.exit_code());
        error.exit_code()
    })
}

/// Whether the arguments, valid or not, ask for progress as JSON. If so, errors in the arguments
/// are printed as JSON, too.
fn asks_for_json(arguments: impl Iterator<Item = OsString>) -> bool {
    let arguments: Vec<_> = arguments.collect();
    let pair = |pair: &[OsString]| pair[0] == "--progress" && pair[1] == "json";
    arguments.windows(2).any(pair) || arguments.iter().any(|word| word == "--progress=json")
}

fn report_panics_in_one_line() {
    static REPORTED: AtomicBool = AtomicBool::new(false);
    panic::set_hook(Box::new(|info| {
        if !REPORTED.swap(true, Ordering::Relaxed) {
            complain(&format!("internal fault: {info}"), INTERNAL_FAULT);
        }
    }));
}
