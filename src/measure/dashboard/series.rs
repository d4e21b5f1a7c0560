//! Sorts the runs of a history into series of comparable runs, which the page joins by lines.

use std::collections::BTreeMap;

use serde::Serialize;

use super::changes::{Change, changes};
use super::command;
use super::history::History;
use crate::accel::Counters;
use crate::measure::bench::{Lanes, Record, Run};
use crate::measure::machine::Machine;
use crate::measure::settings;
use crate::measure::statistics::Estimate;

/// All data that the page shows.
#[derive(Debug, Serialize)]
pub(super) struct Data {
    /// Names of the machines.
    machines: Vec<String>,
    records: Vec<Entry>,
    series: Vec<Series>,
}

/// Description of a record.
#[derive(Debug, Serialize)]
struct Entry {
    file: String,
    time: String,
    commit: String,
    rustc: String,
    flags: String,
    os: String,
}

/// Runs of the same work on the same machine.
#[derive(Debug, Serialize)]
struct Series {
    /// Index into [`Data::machines`].
    machine: usize,
    scene: String,
    engine: String,
    threads: usize,
    /// Size, samples and the other settings that decide the work.
    settings: String,
    points: Vec<Point>,
}

/// A run of a series.
#[derive(Debug, Serialize)]
struct Point {
    /// Index into [`Data::records`].
    record: usize,
    mrays: Estimate,
    msamples: Estimate,
    cycle: Option<Estimate>,
    seconds: Estimate,
    speedup: Option<Estimate>,
    /// Seconds by stage.
    stages: BTreeMap<String, f64>,
    /// Counters of the whole render.
    counters: Counters,
    rays: u64,
    /// Shares of active lanes, by segment and stage.
    lanes: Vec<BTreeMap<String, f64>>,
    blocks: usize,
    contaminated: usize,
    change: Option<Change>,
    /// Command that repeats the measurement.
    bench: String,
    /// Command that repeats the render.
    render: String,
}

/// Name that identifies a machine by everything that decides speed besides the program. It includes
/// the instruction set, so that builds for different instruction sets are in different series.
fn machine_name(machine: &Machine) -> String {
    let Machine { cpu, cpu_model, cores, isa, lanes, .. } = machine;
    let model = if cpu_model.is_empty() { String::new() } else { format!(" ({cpu_model})") };
    format!("{cpu}{model}, {cores} cores, {isa} ({lanes} lanes)")
}

fn described(run: &Run) -> String {
    let scene: String = run.work.scene_hash.chars().take(8).collect();
    format!("{}, scene {scene}", settings::describe(&run.work.settings))
}

impl Data {
    pub(super) fn of(history: &History) -> Self {
        let mut machines: Vec<String> = Vec::new();
        let mut series: Vec<Series> = Vec::new();
        let mut runs: Vec<Vec<&Run>> = Vec::new();
        for (record_number, (_, record)) in history.records.iter().enumerate() {
            let machine = place(&mut machines, machine_name(&record.machine));
            for run in &record.runs {
                let point = point(record_number, record, run);
                let of_run = |series: &Series| {
                    (series.machine, &series.scene, &series.engine, series.threads)
                        == (machine, &run.work.scene, &run.work.engine, run.work.threads)
                        && series.settings == described(run)
                };
                if let Some(found) = series.iter().position(of_run) {
                    series[found].points.push(point);
                    runs[found].push(run);
                } else {
                    runs.push(vec![run]);
                    series.push(Series {
                        machine,
                        scene: run.work.scene.clone(),
                        engine: run.work.engine.clone(),
                        threads: run.work.threads,
                        settings: described(run),
                        points: vec![point],
                    });
                }
            }
        }
        for (series, runs) in series.iter_mut().zip(runs) {
            for (point, change) in series.points.iter_mut().zip(levels(&runs)) {
                point.change = change;
            }
        }
        Self { machines, records: history.records.iter().map(entry).collect(), series }
    }
}

/// Index of `name` in `names`. A missing name is added.
fn place(names: &mut Vec<String>, name: String) -> usize {
    names.iter().position(|known| *known == name).unwrap_or_else(|| {
        names.push(name);
        names.len() - 1
    })
}

fn entry((file, record): &(String, Record)) -> Entry {
    let Machine { commit, rustc, flags, os, .. } = record.machine.clone();
    Entry { file: file.clone(), time: record.time.clone(), commit, rustc, flags, os }
}

/// Finds the changes of a series in paths per cycle, since clocks change from hour to hour, or in paths
/// per second if the clock of every run is unknown. Skips runs whose blocks are mostly
/// contaminated, and runs without a known clock if other runs have one.
fn levels(runs: &[&Run]) -> Vec<Option<Change>> {
    let cycles = || runs.iter().map(|run| run.paths_per_cycle());
    let mut speeds: Vec<Vec<f64>> = if cycles().any(|speeds| speeds.is_some()) {
        cycles().map(Option::unwrap_or_default).collect()
    } else {
        runs.iter().map(|run| run.paths_per_second()).collect()
    };
    for (run, speeds) in runs.iter().zip(&mut speeds) {
        if run.contaminated() * 2 > run.blocks.len() {
            speeds.clear();
        }
    }
    changes(&speeds.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

fn point(number: usize, record: &Record, run: &Run) -> Point {
    let speedup = record.ratio(run, "scalar").filter(|ratio| ratio.of != ratio.to);
    let shares = |stages: &BTreeMap<String, Lanes>| {
        let used = stages.iter().filter(|(_, lanes)| lanes.issued > 0);
        used.map(|(stage, lanes)| (stage.clone(), lanes.active as f64 / lanes.issued as f64))
            .collect()
    };
    Point {
        record: number,
        mrays: run.mrays_per_s,
        msamples: run.msamples_per_s,
        cycle: run.paths_per_cycle().map(Estimate::of),
        seconds: Estimate::of(run.blocks.iter().map(|block| block.seconds)),
        speedup: speedup.map(|ratio| ratio.speed),
        stages: run.stages.clone(),
        counters: run.counters,
        rays: run.blocks.first().map_or(0, |block| block.rays.total()),
        lanes: run.lanes.iter().map(shares).collect(),
        blocks: run.blocks.len(),
        contaminated: run.contaminated(),
        change: None,
        bench: command::bench(record, run),
        render: command::render(record, run),
    }
}
