//! Runs renders of a ptfast binary as a user would.
//!
//! Each render is a separate process, so that none profits from data that another left in caches, or
//! from a lucky placement of its memory.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

use serde::Deserialize;
use serde_json::Value;

use super::run::Lanes;
use crate::accel::Counters;
use crate::engine::{Engine, ImageSettings, Planning, RayCounts};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::measure::machine::{Interference, Machine};

/// Settings of a render.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Task {
    pub(super) scene: String,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) spp: u32,
    pub(super) seed: u64,
    pub(super) threads: usize,
}

/// A ptfast binary, and a folder for its output.
#[derive(Debug)]
pub(super) struct Program {
    /// Path of the binary as the user gave it.
    name: String,
    scratch: tempfile::TempDir,
    /// Additional arguments of each render.
    arguments: Vec<String>,
}

// Names of files in the folder. The binary is a copy, so that a build in the meantime does not replace
// it.
const BINARY: &str = "ptfast";
const IMAGE: &str = "image.png";
const RECORD: &str = "record.json";
const PLAN: &str = "plan.json";
const SAID: &str = "stderr.txt";
/// Longest interval between two checks whether a render has ended. The checks are rare because each one
/// takes a core for a moment.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// The fields of a render's record (`ptfast render --json`) that a bench reads. Binaries of other
/// versions may not write all of them.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Rendered {
    pub(super) machine: Machine,
    #[serde(default)]
    pub(super) scene_hash: String,
    #[serde(flatten)]
    pub(super) settings: ImageSettings,
    pub(super) hash: String,
    pub(super) seconds: Seconds,
    pub(super) rays: RayCounts,
    #[serde(default)]
    pub(super) peak_rss_bytes: Option<u64>,
    #[serde(default)]
    pub(super) interference: Option<Interference>,
    #[serde(default)]
    pub(super) plan: Option<Value>,
    #[serde(default)]
    planning: Option<String>,
    #[serde(default)]
    pub(super) stages: BTreeMap<String, f64>,
    #[serde(default)]
    segments: Vec<Segment>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Seconds {
    pub(super) render: f64,
    #[serde(default)]
    plan: f64,
}

#[derive(Clone, Debug, Deserialize)]
struct Segment {
    stages: BTreeMap<String, Workload>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct Workload {
    active: u64,
    issued: u64,
    #[serde(default)]
    counters: Option<Counters>,
}

impl Program {
    /// Prepares the binary at `path`, which will render every task with the additional `arguments`.
    ///
    /// # Errors
    /// If `path` is not a file, or it cannot be copied to a temporary folder.
    pub(super) fn new(path: &Path, arguments: &[String]) -> Result<Self> {
        let file = fs::metadata(path).map_err(Error::io(path, "run"))?;
        if !file.is_file() {
            return Err(Error::Usage(format!("{}: not a program", path.display())));
        }
        let folder = std::env::temp_dir();
        let scratch = tempfile::Builder::new().prefix("ptfast-bench-").tempdir_in(&folder);
        let scratch = scratch.map_err(Error::io(&folder, "create a folder"))?;
        fs::copy(path, scratch.path().join(BINARY)).map_err(Error::io(path, "copy"))?;
        Ok(Self { name: path.display().to_string(), scratch, arguments: arguments.to_vec() })
    }

    /// Renders `task` with `plan`, or with the program's own plan. If `count`, the program also counts
    /// its work, which takes time.
    ///
    /// # Errors
    /// If the program cannot be run, fails or writes no valid record.
    pub(super) fn render(
        &self,
        task: &Task,
        engine: Engine,
        plan: Option<&Value>,
        count: bool,
    ) -> Result<Rendered> {
        let here = |name: &str| self.scratch.path().join(name);
        let record = here(RECORD);
        let mut command = Command::new(here(BINARY));
        command.args(["render", "--quiet", "--scene", &task.scene, "--engine", engine.name()]);
        for (name, value) in [
            ("--width", u64::from(task.width)),
            ("--height", u64::from(task.height)),
            ("--spp", u64::from(task.spp)),
            ("--seed", task.seed),
            ("--threads", task.threads as u64),
        ] {
            command.arg(name).arg(value.to_string());
        }
        command.args(&self.arguments).arg("--output").arg(here(IMAGE)).arg("--json").arg(&record);
        if count {
            command.arg("--stats");
        }
        if let Some(plan) = plan {
            let file = here(PLAN);
            fs::write(&file, plan.to_string()).map_err(Error::io(&file, "write"))?;
            command.arg("--plan").arg(file);
        }
        let said = File::create(here(SAID)).map_err(Error::io(&here(SAID), "write"))?;
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(said);
        let status = self.run(&mut command)?;
        if !status.success() {
            let said = fs::read(here(SAID)).map_err(Error::io(&here(SAID), "read"))?;
            return Err(self.failed(&String::from_utf8_lossy(&said), status));
        }
        let no_record = |why: String| {
            Error::Usage(format!(
                "{}: not ptfast, it wrote no valid render record: {why}",
                self.name
            ))
        };
        let text = fs::read_to_string(&record).map_err(|error| no_record(error.to_string()))?;
        // The next render must not find the record of this one.
        fs::remove_file(&record).map_err(Error::io(&record, "remove"))?;
        let mut rendered: Rendered =
            serde_json::from_str(&text).map_err(|error| no_record(error.to_string()))?;
        // The program ran on this machine, whatever its version reports about it.
        let here = Machine::this();
        rendered.machine = Machine {
            cpu: here.cpu,
            cpu_model: here.cpu_model,
            cores: here.cores,
            ..rendered.machine
        };
        let Seconds { render, .. } = rendered.seconds;
        if !(render > 0.0 && render.is_finite() && rendered.rays.primary > 0) {
            return Err(no_record(format!(
                "the render took {render} seconds and traced {:?}",
                rendered.rays
            )));
        }
        Ok(rendered)
    }

    /// Runs `command` until it ends or this process is interrupted.
    fn run(&self, command: &mut Command) -> Result<ExitStatus> {
        let failed = || Error::io(Path::new(&self.name), "run");
        let mut child = command.spawn().map_err(failed())?;
        let mut pause = LOOK_EVERY / 16;
        loop {
            let status = child.try_wait().map_err(failed())?;
            // A signal that ended the child has usually reached this process, too.
            if let Err(interrupted) = interrupt::check() {
                // If the child has already ended, these calls do nothing.
                let _ = child.kill();
                let _ = child.wait();
                return Err(interrupted);
            }
            match status {
                Some(status) => return Ok(status),
                None => thread::sleep(pause),
            }
            pause = (2 * pause).min(LOOK_EVERY);
        }
    }

    /// An error with the last line that the program printed to stderr, and with the program's exit code
    /// if it is one that ptfast uses for errors.
    fn failed(&self, said: &str, status: ExitStatus) -> Error {
        let said = said.lines().last().unwrap_or("it printed no error message");
        let message = said.strip_prefix("ptfast: ").unwrap_or(said).to_owned();
        let code = status.code().and_then(|code| u8::try_from(code).ok());
        let code = code.filter(|code| [2, 65, 74].contains(code)).unwrap_or(70);
        Error::Program { program: self.name.clone(), message: format!("{status}: {message}"), code }
    }
}

impl Rendered {
    /// Whether the plan was chosen by a measurement, so that the next render may choose another one. Old
    /// versions only report the time for planning, which is almost zero without a measurement.
    pub(super) fn measured_plan(&self) -> bool {
        match &self.planning {
            Some(planning) => planning == Planning::Measured.name(),
            None => self.seconds.plan > 0.01,
        }
    }

    /// Counters summed over all segments and stages.
    pub(super) fn counters(&self) -> Counters {
        let works = self.segments.iter().flat_map(|segment| segment.stages.values());
        works.filter_map(|work| work.counters).fold(Counters::default(), |mut sum, counters| {
            sum += counters;
            sum
        })
    }

    /// Lanes by segment and stage.
    pub(super) fn lanes(&self) -> Vec<BTreeMap<String, Lanes>> {
        let lanes = |work: &Workload| match work.counters {
            Some(counters) => {
                Lanes { active: counters.lanes_active, issued: counters.lanes_issued }
            }
            None => Lanes { active: work.active, issued: work.issued },
        };
        let of = |segment: &Segment| {
            segment.stages.iter().map(|(stage, work)| (stage.clone(), lanes(work))).collect()
        };
        self.segments.iter().map(of).collect()
    }
}
