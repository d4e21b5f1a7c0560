//! Measuring: renders take turns, block by block, so that what a shared machine does to one side it
//! does to all.
//!
//! A *side* is an engine of a program; a *group* are the sides of one scene and number of threads. In
//! a *block* each side renders twice, forth and back: A B C C B A. What drifts steadily is the same
//! for all of them. One of the sides takes part twice: it is the control, whose ratio to itself is 1.

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

use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::machine::Machine;
use block::Series;
pub(crate) use compare::{Reference, check_machine, check_works, doubtful, judge};
pub(crate) use counts::{CountChanges, count_changes};
pub(crate) use export::{Format, check_export, export, export_file};
use program::{Program, Rendered, Task};
pub(crate) use record::Record;
pub(crate) use run::{Lanes, Ratio, Run, Workload};
pub(crate) use verdict::{Gate, Outcome, Verdict, decide};

/// What is to be measured.
#[derive(Clone, Debug)]
pub(crate) struct Options {
    /// The binary that is measured.
    pub(crate) program: PathBuf,
    /// Another, that it is compared with.
    pub(crate) against: Option<PathBuf>,
    /// Names of scenes, and the width and height of their images.
    pub(crate) scenes: Vec<(String, (u32, u32))>,
    pub(crate) engines: Vec<Engine>,
    pub(crate) threads: Vec<usize>,
    pub(crate) spp: u32,
    pub(crate) seed: u64,
    /// More arguments of each render.
    pub(crate) arguments: Vec<String>,
}

impl Options {
    /// Scene, engine and threads of each run of the program that is measured, in their order.
    pub(crate) fn runs(&self) -> Vec<(&str, Engine, usize)> {
        let of = |(scene, threads)| {
            self.engines
                .iter()
                .map(move |&engine| -> (&str, Engine, usize) { (scene, engine, threads) })
        };
        let scenes = self.scenes.iter().map(|(scene, _)| &**scene);
        let groups =
            scenes.flat_map(|scene| self.threads.iter().map(move |&threads| (scene, threads)));
        groups.flat_map(of).collect()
    }
}

/// Sides that are ready to be measured.
#[derive(Debug)]
pub(crate) struct Bench {
    /// The one that is measured, and the one that it is compared with.
    programs: Vec<Program>,
    groups: Vec<Group>,
    time: String,
}

/// Sides that take turns.
#[derive(Debug)]
struct Group {
    task: Task,
    sides: Vec<Side>,
}

/// An engine of a program.
#[derive(Debug)]
struct Side {
    /// Place among the programs.
    program: usize,
    engine: Engine,
    /// What a render that was not timed told.
    counted: Rendered,
    /// How it works when it is timed.
    plan: Option<Value>,
}

/// What blocks have told: for each group, if it took part, a series a turn.
#[derive(Debug)]
pub(crate) struct Sample(Vec<Option<Vec<Series>>>);

/// Blocks that are done, of so many.
pub(crate) type Progress<'a> = &'a mut dyn FnMut(usize, usize);

impl Bench {
    /// Renders everything once, counting and not timed; by the plans of `baseline` where it has some.
    ///
    /// # Errors
    /// Where a program fails, or engines of one program give different images.
    pub(crate) fn new(options: &Options, baseline: Option<&Record>) -> Result<Self> {
        let program = |path| Program::new(path, &options.arguments);
        let mut programs = vec![program(&*options.program)?];
        programs.extend(options.against.as_deref().map(program).transpose()?);
        let mut bench = Self { programs, groups: Vec::new(), time: now() };
        for &(ref scene, (width, height)) in &options.scenes {
            for &threads in &options.threads {
                let Options { spp, seed, .. } = *options;
                let task = Task { scene: scene.clone(), width, height, spp, seed, threads };
                let sides = bench.sides(&task, &options.engines, baseline)?;
                bench.groups.push(Group { task, sides });
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
                // One plan for all whose work is compared.
                let old = baseline
                    .and_then(|record| record.plan(&task.scene, task.threads, engine.name()));
                let first = sides.iter().find(|side| side.engine == engine);
                let common = old.or_else(|| first.and_then(|side| side.counted.plan.clone()));
                if common.is_some() && common != plan {
                    // Another version may know no such plan: its counts are not comparable then.
                    if let Ok(by_common) = program.render(task, engine, common.as_ref(), true) {
                        counted = by_common;
                        // What chance has a part in would be taken for a difference of programs.
                        if measured {
                            plan = common;
                        }
                    }
                }
                sides.push(Side { program: number, engine, counted, plan });
            }
        }
        let before = self.groups.iter().filter(|group| group.task.scene == task.scene);
        let all = before.flat_map(|group| &group.sides).chain(&sides);
        let own = all.filter(|side| side.program == 0);
        check_hashes(&task.scene, own.map(|side| (side.engine.name(), &*side.counted.hash)))?;
        Ok(sides)
    }

    /// The build of a program, 0 for the one that is measured, and where it runs.
    pub(crate) fn machine(&self, program: usize) -> &Machine {
        let mut sides = self.groups.iter().flat_map(|group| &group.sides);
        let side = sides.find(|side| side.program == program);
        &side.expect("every program has a side").counted.machine
    }

    /// What the program that is measured will render.
    pub(crate) fn works(&self) -> Vec<Workload> {
        let of = |group: &'_ Group| -> Vec<Workload> {
            let own = group.sides.iter().filter(|side| side.program == 0);
            own.map(|side| side.work(&group.task)).collect()
        };
        self.groups.iter().flat_map(of).collect()
    }

    /// Measures `blocks` blocks of those groups that `wanted` says, scene and threads told; tells
    /// `progress`.
    ///
    /// # Errors
    /// Where a program fails, or gives another image than before.
    pub(crate) fn measure(
        &self,
        blocks: usize,
        wanted: impl Fn(&str, usize) -> bool,
        progress: Progress<'_>,
    ) -> Result<Sample> {
        let wanted: Vec<bool> = self
            .groups
            .iter()
            .map(|Group { task, .. }| wanted(&task.scene, task.threads))
            .collect();
        let all = blocks * wanted.iter().filter(|&&wanted| wanted).count();
        let mut sample: Vec<Option<Vec<Series>>> = wanted
            .iter()
            .zip(&self.groups)
            .map(|(&wanted, group)| wanted.then(|| vec![Series::default(); group.turns().count()]))
            .collect();
        let mut done = 0;
        for block in 0..blocks {
            for (group, series) in self.groups.iter().zip(&mut sample) {
                let Some(series) = series else { continue };
                progress(done, all);
                block::measure(&self.programs, group, block % 2 == 1, series)?;
                done += 1;
            }
        }
        Ok(Sample(sample))
    }
}

impl Side {
    fn work(&self, task: &Task) -> Workload {
        let Task { scene, width, height, spp, seed, threads } = task.clone();
        let Rendered { scene_hash, sampling, sampler, depth, .. } = &self.counted;
        let engine = self.engine.name().to_owned();
        Workload {
            scene,
            scene_hash: scene_hash.clone(),
            engine,
            sampling: sampling.clone(),
            sampler: sampler.clone(),
            threads,
            width,
            height,
            spp,
            depth: *depth,
            seed,
        }
    }
}

impl Group {
    /// The side that takes part twice: the wavefront engine of the program that is measured, or what
    /// there is.
    fn control(&self) -> usize {
        let own = |side: &Side| side.program == 0 && side.engine == Engine::Wavefront;
        self.sides.iter().position(own).unwrap_or(0)
    }

    /// The sides that take turns in the first half of a block: each once, the control at the end.
    fn turns(&self) -> impl Iterator<Item = &Side> {
        self.sides.iter().chain([&self.sides[self.control()]])
    }
}

/// One image from all of one program's engines.
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

/// The time in UTC, to the second.
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
