//! The error type of the crate, and the exit codes of the program.

use std::io;
use std::path::Path;

/// Result with ptfast's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Every failure, displayed as one line that a user can act on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting outside its range, or settings that contradict each other.
    #[error("{0}")]
    Usage(String),

    /// An input file whose content is wrong.
    #[error("{file}{}: {message}", place_suffix(place))]
    Input {
        /// The file, or the name of the built-in scene.
        file: String,
        /// Line and column (`3:14`) or path of the element (`primitives[2]`); may be empty.
        place: String,
        /// The problem, and how to fix it.
        message: String,
    },

    /// A file that cannot be read or written.
    #[error("{path}: cannot {action}: {source}")]
    Io {
        /// The file or folder.
        path: String,
        /// `read`, `write`, ...
        action: &'static str,
        /// The error of the operating system.
        source: io::Error,
    },

    /// A file that a scene names and that cannot be read.
    #[error("{error}{advice}")]
    Unread {
        /// The file, the place that names it, and the error of the operating system.
        error: Box<Error>,
        /// Whether the file is missing.
        missing: bool,
        /// How to do without the file, with its separator; may be empty.
        advice: &'static str,
    },

    /// A program that ptfast ran has failed.
    #[error("{program}: {message}")]
    Program {
        /// Path of the program.
        program: String,
        /// Its exit status and its error message.
        message: String,
        /// The exit code that ptfast returns for this failure.
        code: u8,
    },

    /// A signal with this number ended the run.
    #[error("interrupted by {}", signal_name(.0))]
    Interrupted(u8),

    /// A render was stopped before it was complete.
    #[error("{} after {samples}: {outcome}", stop_name(signal))]
    Stopped {
        /// The number of the signal that stopped it; `None` for the time limit.
        signal: Option<u8>,
        /// The number of samples per pixel so far, in words.
        samples: String,
        /// Location of the saved render, and how to continue it.
        outcome: String,
    },

    /// A file could not be written, but a checkpoint has its content or an earlier state of it.
    #[error("{error}; {outcome}")]
    Saved {
        /// Why the file could not be written.
        error: Box<Error>,
        /// Names the checkpoint.
        outcome: String,
    },

    /// The operating system refused something that the render needs: memory, threads, or pinning.
    #[error("{0}")]
    Resource(String),

    /// A fault of the program or of the machine it runs on.
    #[error("internal fault: {0}")]
    Internal(String),
}

fn signal_name(signal: &u8) -> &'static str {
    match signal {
        1 => "SIGHUP",
        2 => "SIGINT",
        _ => "SIGTERM",
    }
}

fn stop_name(signal: &Option<u8>) -> String {
    match signal {
        Some(signal) => format!("interrupted by {}", signal_name(signal)),
        None => "stopped by the time limit".to_owned(),
    }
}

fn place_suffix(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!(":{place}") }
}

impl Error {
    /// An [`Error::Input`].
    pub fn input(
        file: impl Into<String>,
        place: impl Into<String>,
        message: impl Into<String>,
    ) -> Self {
        Self::Input { file: file.into(), place: place.into(), message: message.into() }
    }

    /// An [`Error::Io`], ready for `map_err`.
    pub fn io(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        let path = path.display().to_string();
        move |source| Self::Io { path, action, source }
    }

    /// Names the element of a scene that names a file, by `at`, if `self` says that it cannot be read.
    pub(crate) fn of_file(self, at: impl FnOnce(&Self) -> Self) -> Self {
        let error = at(&self);
        match self {
            Self::Io { source, .. } => {
                let missing = source.kind() == io::ErrorKind::NotFound;
                Self::Unread { error: Box::new(error), missing, advice: "" }
            }
            _ => error,
        }
    }

    /// Adds `advice`, if `self` says that a file is missing.
    pub(crate) fn with_advice_if_missing(mut self, new: &'static str) -> Self {
        if let Self::Unread { missing: true, advice, .. } = &mut self {
            *advice = new;
        }
        self
    }

    /// The process exit code: 2 for wrong usage, 65 for bad input, 70 for an internal fault, 71 for
    /// a refused resource, 74 for a failed read or write, 75 if stopped by the time limit, and 129,
    /// 130 or 143 if interrupted by a signal.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Input { .. } => 65,
            Self::Internal(_) => 70,
            Self::Resource(_) => 71,
            Self::Io { .. } | Self::Unread { .. } => 74,
            Self::Saved { error, .. } => error.exit_code(),
            Self::Program { code, .. } => *code,
            Self::Interrupted(signal) | Self::Stopped { signal: Some(signal), .. } => 128 + signal,
            Self::Stopped { signal: None, .. } => 75,
        }
    }
}

/// Returns `, did you mean ...?` with the known name nearest to `found`, or the list of all names
/// if they are few.
pub(crate) fn suggestion<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    // Only the first 1000 names are compared, and no names longer than 64 bytes: more would take
    // long, and nobody types such long names by hand.
    let (most, longest) = (1000, 64);
    let known: Vec<&str> = known.into_iter().take(most).collect();
    let short = |name: &&&str| name.len().max(found.len()) <= longest;
    let nearest = known
        .iter()
        .filter(short)
        .map(|name| (strsim::damerau_levenshtein(found, name), name))
        .min_by_key(|(distance, _)| *distance);
    match nearest {
        Some((distance, name)) if distance <= 1 + name.len() / 3 => {
            format!(", did you mean `{name}`?")
        }
        _ if known.is_empty() => ", none is defined".to_owned(),
        _ if known.len() <= 20 => format!(", known: `{}`", known.join("`, `")),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggestions_name_the_nearest_or_all() {
        assert_eq!(suggestion("raduis", ["center", "radius"]), ", did you mean `radius`?");
        assert_eq!(suggestion("xyz", ["center", "radius"]), ", known: `center`, `radius`");
        assert_eq!(suggestion("xyz", []), ", none is defined");
        let long = "a".repeat(1 << 20);
        assert_eq!(suggestion(&long, [&*long, "b"].repeat(11)), "");
    }

    #[test]
    fn errors_are_one_line_with_place() {
        let error = Error::input("a.ron", "3:4", "bad");
        assert_eq!(error.to_string(), "a.ron:3:4: bad");
        assert_eq!(Error::input("a.ron", "", "bad").to_string(), "a.ron: bad");
        assert_eq!(error.exit_code(), 65);
        let interrupted = [(2, "interrupted by SIGINT", 130), (15, "interrupted by SIGTERM", 143)];
        for (signal, line, code) in interrupted {
            let error = Error::Interrupted(signal);
            assert_eq!((error.to_string().as_str(), error.exit_code()), (line, code));
        }
    }
}
