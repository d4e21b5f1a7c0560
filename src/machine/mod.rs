//! The machine and build that a record speaks of.

mod interference;

use std::fs;

pub(crate) use interference::{Interference, busy_seconds_of_others};
use serde::{Deserialize, Serialize};

use crate::isa::{compiled_isa, cpu_model, cpu_name};
use crate::simd::LANES;

/// Where and with what a figure was measured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Machine {
    /// The CPU's name.
    pub cpu: String,
    /// Its family, model and stepping; empty where they are not known.
    #[serde(default)]
    pub cpu_model: String,
    /// Logical cores that the process may use.
    pub cores: usize,
    /// Instruction set that the program was compiled for.
    pub isa: String,
    /// f32 lanes of its vectors.
    pub lanes: u32,
    /// Operating system and kernel.
    pub os: String,
    /// Compiler version.
    pub rustc: String,
    /// `RUSTFLAGS` of the build.
    pub flags: String,
    /// Commit of the source, `-dirty` where it was changed.
    pub commit: String,
}

impl Machine {
    /// This machine and build.
    pub(crate) fn this() -> Self {
        let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
        Self {
            cpu: cpu_name(),
            cpu_model: cpu_model(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            isa: compiled_isa().name().to_owned(),
            lanes: LANES as u32,
            os: format!("{} {}", std::env::consts::OS, kernel.trim()).trim().to_owned(),
            rustc: env!("PTFAST_RUSTC").to_owned(),
            flags: env!("PTFAST_FLAGS").to_owned(),
            commit: env!("PTFAST_COMMIT").to_owned(),
        }
    }
}

/// Largest resident set of the process so far in bytes; `None` where the operating system
/// does not tell.
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
