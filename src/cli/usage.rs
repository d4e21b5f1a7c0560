//! Parsing of the arguments, and one line for wrong usage.

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches};

use super::args::Cli;
use super::console::{complain, say_lines};
use crate::formats::Source;
use crate::measure::machine::Machine;

const WRONG_USAGE: u8 = 2;

/// Parses the arguments. An argument such as -1 is a value, and the value's parser rejects it.
pub(crate) fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Cli, clap::Error> {
    let mut command = Cli::command();
    let names: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    for name in names {
        command = command.mut_subcommand(name, |command| {
            command.mut_args(|arg| match arg.get_action().takes_values() && !arg.is_positional() {
                true => arg.allow_negative_numbers(true),
                false => arg,
            })
        });
    }
    let matches = command.try_get_matches_from_mut(arguments)?;
    Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
}

/// Prints help or the version on standard output, or one line about wrong usage. Returns the exit code.
pub(crate) fn explain(error: &clap::Error) -> u8 {
    match error.kind() {
        ErrorKind::DisplayHelp => print(error.to_string().trim_end()),
        ErrorKind::DisplayVersion if verbose() => print(&verbose_version()),
        ErrorKind::DisplayVersion => print(error.to_string().trim_end()),
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand => {
            let commands = Cli::command();
            let names: Vec<&str> = commands.get_subcommands().map(|c| c.get_name()).collect();
            complain(
                &format!("a command is missing: {} (see `ptfast --help`)", names.join(", ")),
                WRONG_USAGE,
            );
            WRONG_USAGE
        }
        _ => {
            complain(&format!("{} (see `{} --help`)", message(error), command()), WRONG_USAGE);
            WRONG_USAGE
        }
    }
}

fn print(text: &str) -> u8 {
    super::exit_code(say_lines(text).map(|()| 0))
}

/// The command that the arguments name, with `ptfast` before it.
fn command() -> String {
    let known = Cli::command();
    let mut words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let named = words.find(|word| known.find_subcommand(word).is_some());
    named.map_or("ptfast".to_owned(), |name| format!("ptfast {name}"))
}

/// clap's message on one line, without usage and without suggestions of arguments that merely share some letters.
fn message(error: &clap::Error) -> String {
    let text = error.to_string();
    let text = text.split("\n\nUsage:").next().unwrap_or_default();
    let text = text.split("\n\nFor more information").next().unwrap_or_default();
    let mut text = text.strip_prefix("error: ").unwrap_or(text);
    let unknown = invalid_argument(error).filter(|_| error.kind() == ErrorKind::UnknownArgument);
    let other = OTHER_NAMES.iter().find(|(other, _)| unknown == Some(other));
    if unknown.is_some() && (other.is_some() || !suggests_a_typo(error)) {
        text = text.split("\n\n  tip:").next().unwrap_or_default();
    }
    let text = text.replace("\n\n  tip: ", ", ").split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((_, name)) = other {
        return format!("{text}, use --{name}");
    }
    match error.kind() {
        ErrorKind::UnknownArgument => long_option(std::env::args_os()).unwrap_or(text),
        ErrorKind::InvalidSubcommand => match context(error, ContextKind::InvalidSubcommand) {
            Some(word) if Source::find(word).is_ok() => {
                format!("a command is missing, `ptfast render {word}` renders this scene")
            }
            _ => text,
        },
        ErrorKind::ValueValidation => match context(error, ContextKind::InvalidValue) {
            Some(value) => number(&text, value),
            None => text,
        },
        _ => text,
    }
}

/// A message for the first argument such as `-spp`, whose letters clap reads as options of their own.
fn long_option(arguments: impl Iterator<Item = OsString>) -> Option<String> {
    let known = Cli::command();
    let is_long = |name: &str| {
        let mut all = known.get_subcommands().flat_map(|command| command.get_arguments());
        all.any(|option| option.get_long() == Some(name))
    };
    let words = arguments.map(|word| word.to_string_lossy().into_owned());
    let name = words.filter(|word| !word.starts_with("--")).find_map(|word| {
        let name = word.strip_prefix('-')?.split('=').next()?;
        (name.len() > 1 && is_long(name)).then(|| name.to_owned())
    })?;
    Some(format!("unexpected argument '-{name}' found, use --{name}"))
}

/// The message `text` about a `value` that is no whole number.
fn number(text: &str, value: &str) -> String {
    let text = text.replace("invalid digit found in string", "must be a whole number");
    let sides = value.split_once(['x', 'X', '×']).filter(|(width, height)| {
        text.contains("'--width <")
            && [width, height].iter().all(|side| side.parse::<u32>().is_ok())
    });
    match sides {
        Some((width, height)) => format!("{text}, use --width {width} --height {height}"),
        None => text,
    }
}

/// The text of this kind that belongs to an error.
fn context(error: &clap::Error, kind: ContextKind) -> Option<&str> {
    match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text),
        _ => None,
    }
}

/// What other programs call our arguments.
const OTHER_NAMES: [(&str, &str); 4] =
    [("aov", "layers"), ("aovs", "layers"), ("normals", "layers"), ("passes", "layers")];

/// The name of the wrong argument, without dashes and value.
fn invalid_argument(error: &clap::Error) -> Option<&str> {
    context(error, ContextKind::InvalidArg)?.trim_start_matches('-').split('=').next()
}

/// Whether the suggested argument differs from the given one by at most one edit, plus one for
/// every five letters.
fn suggests_a_typo(error: &clap::Error) -> bool {
    let suggested = context(error, ContextKind::SuggestedArg);
    let (Some(given), Some(suggested)) = (invalid_argument(error), suggested) else { return false };
    strsim::damerau_levenshtein(given, suggested.trim_start_matches('-')) <= 1 + given.len() / 5
}

fn verbose() -> bool {
    std::env::args_os().any(|word| word == "--verbose" || word == "-v")
}

fn verbose_version() -> String {
    let Machine { commit, isa, lanes, rustc, flags, .. } = Machine::this();
    format!(
        "ptfast {}\ncommit: {commit}\ninstruction set: {isa}, {lanes} lanes\ncompiler: {rustc}\nflags: {flags}",
        env!("CARGO_PKG_VERSION"),
    )
}
