//! Build script that passes compiler, flags and commit to the program, for its records.

use std::env;
use std::process::Command;

fn main() {
    let rustc = env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    note("PTFAST_RUSTC", output(&rustc, &["--version"]));
    let flags = env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default().replace('\x1f', " ");
    note("PTFAST_FLAGS", Some(flags));
    note("PTFAST_COMMIT", commit());
    for path in ["src", "scenes", "Cargo.toml", ".git/HEAD", ".git/logs/HEAD"] {
        if std::path::Path::new(path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
}

/// The commit of this package, with `-dirty` if files differ from it. `None` if the package is not
/// the root of a git repository.
fn commit() -> Option<String> {
    let here = env::current_dir().ok()?.canonicalize().ok()?;
    let top = output("git", &["rev-parse", "--show-toplevel"])?;
    if std::path::Path::new(&top).canonicalize().ok()? != here {
        return None;
    }
    let commit = output("git", &["rev-parse", "--short=12", "HEAD"])?;
    let changes =
        output("git", &["--no-optional-locks", "status", "--porcelain", "--untracked-files=no"])?;
    Some(if changes.is_empty() { commit } else { commit + "-dirty" })
}

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn note(variable: &str, value: Option<String>) {
    println!("cargo::rustc-env={variable}={}", value.unwrap_or_else(|| "unknown".into()));
}
