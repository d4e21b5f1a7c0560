//! The command line program.
//!
//! It first checks that the CPU has all features of this build, because any later instruction could
//! be one that the CPU lacks.

use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    if let Some(feature) = ptfast::internals::missing_feature() {
        refuse(feature);
    }
    ptfast::internals::run()
}

/// Reports the missing feature and exits. Calls only into std, which is compiled for any x86-64.
#[cold]
#[inline(never)]
fn refuse(feature: &'static str) -> ! {
    let mut stderr = std::io::stderr();
    for part in [
        "ptfast: this build needs ",
        feature,
        ", which this CPU lacks: rebuild here with `cargo clean && cargo build --release`\n",
    ] {
        // If standard error is closed, there is no way to report anything.
        let _ = stderr.write_all(part.as_bytes());
    }
    std::process::exit(70)
}
