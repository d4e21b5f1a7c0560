//! Benchmarks in which renders take turns, block by block.
//!
//! A disturbance of a shared machine therefore affects all of them alike.
//!
//! A *side* is an engine of a program. A *contest* consists of the sides of one scene and number of
//! threads. In a *block* each side renders twice, in mirrored order (A B C C B A), so that a steady
//! drift affects all sides equally. One side takes part twice and is the *control*: its speed ratio to
//! itself should be 1.

mod block;
mod bootstrap;
mod clock;
mod compare;
mod counts;
mod export;
mod program;
mod read;
mod record;
mod run;
mod summary;
mod verdict;

use std::path::PathBuf;

use serde_json::Value;

use super::machine::Machine;
use crate::engine::Engine;
use crate::error::{Error, Result};
use block::Series;
pub(crate) use compare::{Reference, check_machine, check_works, doubtful, judge};
pub(crate) use counts::{CountChanges, count_changes};
pub(crate) use export::{Format, check_export, export, export_file};
use program::{Program, Rendered, Task};
pub(crate) use record::Record;
pub(crate) use run::{Lanes, Ratio, Run, Workload};
pub(crate) use verdict::{Gate, Outcome, Verdict, decide};

/// Options of a bench.
#[derive(Clone, Debug)]
pub(crate) struct Options {
    /// The binary to measure.
    pub(crate) program: PathBuf,
    /// Another binary, with which `program` is compared.
    pub(crate) against: Option<PathBuf>,
    /// Names of the scenes, with the width and height of their images.
    pub(crate) scenes: Vec<(String, (u32, u32))>,
    pub(crate) engines: Vec<Engine>,
    pub(crate) threads: Vec<usize>,
    pub(crate) spp: u32,
    pub(crate) seed: u64,
    /// Additional arguments of each render.
    pub(crate) arguments: Vec<String>,
}

impl Options {
    /// Scene, engine and number of threads of each run of the measured program, in order.
    pub(crate) fn runs(&self) -> Vec<(&str, Engine, usize)> {
        let of = |(scene, threads)| {
            self.engines
                .iter()
                .map(move |&engine| -> (&str, Engine, usize) { (scene, engine, threads) })
        };
        let scenes = self.scenes.iter().map(|(scene, _)| &**scene);
        let contests =
            scenes.flat_map(|scene| self.threads.iter().map(move |&threads| (scene, threads)));
        contests.flat_map(of).collect()
    }
}

/// A bench whose sides are ready to be measured.
#[derive(Debug)]
pub(crate) struct Bench {
    /// The measured program, then the one it is compared with, if any.
    programs: Vec<Program>,
    contests: Vec<Contest>,
    time: String,
}

/// Sides of one scene and number of threads, which take turns.
#[derive(Debug)]
struct Contest {
    task: Task,
    sides: Vec<Side>,
}

/// An engine of a program.
#[derive(Debug)]
struct Side {
    /// Index into [`Bench::programs`].
    program: usize,
    engine: Engine,
    /// Result of the counting render, which is not timed.
    counted: Rendered,
    /// Plan of the timed renders.
    plan: Option<Value>,
}

/// Measurements of some blocks: for each contest that took part, one series per turn.
#[derive(Debug)]
pub(crate) struct Measurement(Vec<Option<Vec<Series>>>);

/// Callback that receives the number of finished blocks and the number of all blocks.
pub(crate) type Progress<'a> = &'a mut dyn FnMut(usize, usize);

impl Bench {
    /// Renders once with every side to count its work, without timing it. Plans are taken from
    /// `baseline` if it has any.
    ///
    /// # Errors
    /// If a program fails, or engines of one program render different images.
    pub(crate) fn new(options: &Options, baseline: Option<&Record>) -> Result<Self> {
        let program = |path| Program::new(path, &options.arguments);
        let mut programs = vec![program(&*options.program)?];
        programs.extend(options.against.as_deref().map(program).transpose()?);
        let mut bench = Self { programs, contests: Vec::new(), time: now() };
        for &(ref scene, (width, height)) in &options.scenes {
            for &threads in &options.threads {
                let Options { spp, seed, .. } = *options;
                let task = Task { scene: scene.clone(), width, height, spp, seed, threads };
                let sides = bench.sides(&task, &options.engines, baseline)?;
                bench.contests.push(Contest { task, sides });
            }
        }
        Ok(bench)
    }

    fn sides(
        &self,
        task: &Task,
        engines: &[Engine],
        baseline: Option<&Record>,
    ) -> Result<Vec<Side>> {
        let mut sides: Vec<Side> = Vec::new();
        for (number, program) in self.programs.iter().enumerate() {
            for &engine in engines {
                let mut counted = program.render(task, engine, None, true)?;
                let mut plan = counted.plan.clone();
                let measured = counted.measured_plan();
                // Sides whose counts are compared use the same plan.
                let old = baseline
                    .and_then(|record| record.plan(&task.scene, task.threads, engine.name()));
                let first = sides.iter().find(|side| side.engine == engine);
                let common = old.or_else(|| first.and_then(|side| side.counted.plan.clone()));
                if common.is_some() && common != plan {
                    // Another version may not support this plan; its counts are then not comparable.
                    if let Ok(by_common) = program.render(task, engine, common.as_ref(), true) {
                        counted = by_common;
                        // Measured plans vary by chance, which would look like a difference between
                        // programs.
                        if measured {
                            plan = common;
                        }
                    }
                }
                sides.push(Side { program: number, engine, counted, plan });
            }
        }
        let before = self.contests.iter().filter(|contest| contest.task.scene == task.scene);
        let all = before.flat_map(|contest| &contest.sides).chain(&sides);
        let own = all.filter(|side| side.program == 0);
        check_hashes(&task.scene, own.map(|side| (side.engine.name(), &*side.counted.hash)))?;
        Ok(sides)
    }

    /// Build and machine of a program; number 0 is the measured one.
    pub(crate) fn machine(&self, program: usize) -> &Machine {
        let mut sides = self.contests.iter().flat_map(|contest| &contest.sides);
        let side = sides.find(|side| side.program == program);
        &side.expect("every program has a side").counted.machine
    }

    /// The work of each run of the measured program.
    pub(crate) fn works(&self) -> Vec<Workload> {
        let of = |contest: &'_ Contest| -> Vec<Workload> {
            let own = contest.sides.iter().filter(|side| side.program == 0);
            own.map(|side| side.work(&contest.task)).collect()
        };
        self.contests.iter().flat_map(of).collect()
    }

    /// Measures `blocks` blocks of the contests that `wanted` selects by scene and number of threads, and
    /// reports to `progress`.
    ///
    /// # Errors
    /// If a program fails, or renders another image than before.
    pub(crate) fn measure(
        &self,
        blocks: usize,
        wanted: impl Fn(&str, usize) -> bool,
        progress: Progress<'_>,
    ) -> Result<Measurement> {
        let wanted: Vec<bool> = self
            .contests
            .iter()
            .map(|Contest { task, .. }| wanted(&task.scene, task.threads))
            .collect();
        let all = blocks * wanted.iter().filter(|&&wanted| wanted).count();
        let mut sample: Vec<Option<Vec<Series>>> = wanted
            .iter()
            .zip(&self.contests)
            .map(|(&wanted, contest)| {
                wanted.then(|| vec![Series::default(); contest.turns().count()])
            })
            .collect();
        let mut done = 0;
        for block in 0..blocks {
            for (contest, series) in self.contests.iter().zip(&mut sample) {
                let Some(series) = series else { continue };
                progress(done, all);
                block::measure(&self.programs, contest, block % 2 == 1, series)?;
                done += 1;
            }
        }
        Ok(Measurement(sample))
    }
}

impl Side {
    fn work(&self, task: &Task) -> Workload {
        let Rendered { scene_hash, settings, .. } = &self.counted;
        Workload {
            scene: task.scene.clone(),
            scene_hash: scene_hash.clone(),
            engine: self.engine.name().to_owned(),
            threads: task.threads,
            settings: settings.clone(),
        }
    }
}

impl Contest {
    /// Index of the side that takes part twice: the wavefront engine of the measured program, or the
    /// first side if that engine takes no part.
    fn control(&self) -> usize {
        let own = |side: &Side| side.program == 0 && side.engine == Engine::Wavefront;
        self.sides.iter().position(own).unwrap_or(0)
    }

    /// The sides in the order of a block's first half: each side once, then the control again.
    fn turns(&self) -> impl Iterator<Item = &Side> {
        self.sides.iter().chain([&self.sides[self.control()]])
    }
}

/// Fails if the engines of one program rendered different images.
fn check_hashes<'a>(
    scene: &str,
    hashes: impl Iterator<Item = (&'a str, &'a str)> + Clone,
) -> Result<()> {
    let Some((engine, hash)) = hashes.clone().next() else { return Ok(()) };
    let Some((other, found)) = hashes.clone().find(|(_, found)| *found != hash) else {
        return Ok(());
    };
    Err(Error::Internal(format!(
        "{scene}: the {engine} engine's image has the hash {hash}, the {other} engine's {found}"
    )))
}

/// The current time in UTC, rounded to a second.
fn now() -> String {
    let now = jiff::Timestamp::now();
    now.round(jiff::Unit::Second).unwrap_or(now).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_images_are_found() {
        let check = |hashes: &[(&'static str, &'static str)]| {
            check_hashes("cornell", hashes.iter().copied()).map_err(|error| error.to_string())
        };
        assert_eq!(check(&[]), Ok(()));
        assert_eq!(check(&[("scalar", "a"), ("wavefront", "a")]), Ok(()));
        let error = check(&[("scalar", "a"), ("wavefront", "b")]).unwrap_err();
        assert!(error.contains("cornell") && error.contains("wavefront engine's b"), "{error}");
    }
}
