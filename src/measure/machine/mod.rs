//! Describes the machine and the build, for records of measurements.

mod interference;

use std::fs;

pub(crate) use interference::{Interference, busy_seconds_of_others};
use serde::{Deserialize, Serialize};

use crate::isa::{compiled_isa, cpu_model, cpu_name};
use crate::simd::LANES;

/// The machine and the build that a figure was measured with.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Machine {
    /// Name of the CPU.
    pub cpu: String,
    /// Family, model and stepping of the CPU; empty if unknown.
    #[serde(default)]
    pub cpu_model: String,
    /// Number of logical cores that the process may use.
    pub cores: usize,
    /// Instruction set that the program was compiled for.
    pub isa: String,
    /// Number of f32 lanes per vector.
    pub lanes: u32,
    /// Operating system and kernel.
    pub os: String,
    /// Compiler version.
    pub rustc: String,
    /// `RUSTFLAGS` of the build.
    pub flags: String,
    /// Commit of the source, with `-dirty` if it was changed.
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

/// Largest resident set of the process so far in bytes; `None` if the operating system does not
/// report it.
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
