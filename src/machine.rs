//! The machine and build that a record speaks of.

use std::fs;

use serde::Serialize;

use crate::isa::{compiled_isa, cpu_name};
use crate::simd::LANES;

/// Where and with what a figure was measured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// The CPU's name.
    pub cpu: String,
    /// Logical cores that the process may use.
    pub cores: usize,
    /// Instruction set that the program was compiled for.
    pub isa: &'static str,
    /// f32 lanes of its vectors.
    pub lanes: u32,
    /// Operating system and kernel.
    pub os: String,
    /// Compiler version.
    pub rustc: &'static str,
    /// `RUSTFLAGS` of the build.
    pub flags: &'static str,
    /// Commit of the source, `-dirty` where it was changed.
    pub commit: &'static str,
}

impl Machine {
    /// This machine and build.
    pub fn this() -> Self {
        let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
        Self {
            cpu: cpu_name(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            isa: compiled_isa().name(),
            lanes: LANES as u32,
            os: format!("{} {}", std::env::consts::OS, kernel.trim()).trim().to_owned(),
            rustc: env!("PTFAST_RUSTC"),
            flags: env!("PTFAST_FLAGS"),
            commit: env!("PTFAST_COMMIT"),
        }
    }
}

/// Largest resident set of the process so far in bytes; `None` where the operating system
/// does not tell.
pub fn peak_rss_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
