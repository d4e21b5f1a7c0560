//! The command line program. It starts with the one check that must come before any
//! instruction which the CPU might not have.

use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    if let Some(feature) = ptfast::internals::missing_feature() {
        refuse(feature);
    }
    ptfast::internals::run()
}

/// Only calls into std, which is compiled for any x86-64.
#[cold]
#[inline(never)]
fn refuse(feature: &'static str) -> ! {
    let mut stderr = std::io::stderr();
    for part in [
        "ptfast: this build needs ",
        feature,
        ", which this CPU lacks: rebuild here with `cargo clean && cargo build --release`\n",
    ] {
        // Nothing is left to be said if standard error is closed.
        let _ = stderr.write_all(part.as_bytes());
    }
    std::process::exit(70)
}
