//! A ptfast binary that renders, as a user runs it: each render is a process of its own, so that none
//! profits from what another has left in caches or from where its memory happens to lie.

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
use crate::engine::{Engine, Planning, RayCounts};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::machine::{Interference, Machine};

/// What is rendered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Task {
    pub(super) scene: String,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) spp: u32,
    pub(super) seed: u64,
    pub(super) threads: usize,
}

/// A binary, and a folder for what it writes.
#[derive(Debug)]
pub(super) struct Program {
    /// As it was named.
    name: String,
    scratch: tempfile::TempDir,
    /// More arguments of each render.
    arguments: Vec<String>,
}

/// Names in the folder: a copy of the binary, which is not replaced by a build meanwhile, and files.
const BINARY: &str = "ptfast";
const IMAGE: &str = "image.png";
const RECORD: &str = "record.json";
const PLAN: &str = "plan.json";
const SAID: &str = "stderr.txt";
/// How often it is looked whether a render has ended, once it takes long: rarely, since that takes a core
/// for a moment.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// The record of a render (`ptfast render --json`), as far as a bench reads it. Binaries of other
/// versions may not write all of it.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Rendered {
    pub(super) machine: Machine,
    #[serde(default)]
    pub(super) scene_hash: String,
    pub(super) sampling: String,
    #[serde(default)]
    pub(super) sampler: String,
    pub(super) depth: u32,
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
    /// The binary at `path`, which renders with `arguments` besides its task.
    ///
    /// # Errors
    /// Where there is none, or no room for what it writes.
    pub(super) fn new(path: &Path, arguments: &[String]) -> Result<Self> {
        let file = fs::metadata(path).map_err(Error::io(path, "run"))?;
        if !file.is_file() {
            return Err(Error::Usage(format!("{}: not a program", path.display())));
        }
        let folder = std::env::temp_dir();
        let scratch = tempfile::Builder::new().prefix("ptfast-bench-").tempdir_in(&folder);
        let scratch = scratch.map_err(Error::io(&folder, "make a folder"))?;
        fs::copy(path, scratch.path().join(BINARY)).map_err(Error::io(path, "copy"))?;
        Ok(Self { name: path.display().to_string(), scratch, arguments: arguments.to_vec() })
    }

    /// Renders `task`, by `plan` or its own, and counts the work if asked to, which takes time.
    ///
    /// # Errors
    /// Where the program cannot be run, fails or tells nothing that can be read.
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
            Error::Usage(format!("{}: no ptfast, it wrote no record of a render: {why}", self.name))
        };
        let text = fs::read_to_string(&record).map_err(|error| no_record(error.to_string()))?;
        // Of this render, not of the next.
        fs::remove_file(&record).map_err(Error::io(&record, "remove"))?;
        let mut rendered: Rendered =
            serde_json::from_str(&text).map_err(|error| no_record(error.to_string()))?;
        // It ran here, whatever its version tells of that.
        let here = Machine::this();
        rendered.machine = Machine {
            cpu: here.cpu,
            cpu_model: here.cpu_model,
            cores: here.cores,
            ..rendered.machine
        };
        let Seconds { render, .. } = rendered.seconds;
        if !(render > 0.0 && render.is_finite() && rendered.rays.primary > 0) {
            return Err(no_record(format!("{render} seconds, {:?}", rendered.rays)));
        }
        Ok(rendered)
    }

    /// Runs it to its end, or to that of this process.
    fn run(&self, command: &mut Command) -> Result<ExitStatus> {
        let failed = || Error::io(Path::new(&self.name), "run");
        let mut child = command.spawn().map_err(failed())?;
        let mut pause = LOOK_EVERY / 16;
        loop {
            let status = child.try_wait().map_err(failed())?;
            // A signal that ended it mostly came to this process too.
            if let Err(interrupted) = interrupt::check() {
                // Both fail where it has ended.
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

    /// What the program said, with its own exit code where that is known to mean something.
    fn failed(&self, said: &str, status: ExitStatus) -> Error {
        let said = said.lines().last().unwrap_or("it said nothing");
        let message = said.strip_prefix("ptfast: ").unwrap_or(said).to_owned();
        let code = status.code().and_then(|code| u8::try_from(code).ok());
        let code = code.filter(|code| [2, 65, 74].contains(code)).unwrap_or(70);
        Error::Program { program: self.name.clone(), message: format!("{status}: {message}"), code }
    }
}

impl Rendered {
    /// Whether its plan was found by measuring: another time it may be another. Old versions tell only
    /// how long it took, which is nothing where nothing was measured.
    pub(super) fn measured_plan(&self) -> bool {
        match &self.planning {
            Some(planning) => planning == Planning::Measured.name(),
            None => self.seconds.plan > 0.01,
        }
    }

    /// All the work that was counted.
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
