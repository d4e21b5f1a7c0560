//! Exports records to folders in criterion's layout: `criterion/GROUP/FUNCTION/VALUE/BASELINE/*.json`.

use std::fs;
use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::measure::bench::bootstrap::{Spread, bootstrap};
use crate::measure::bench::{Record, Run, Workload};
use crate::output::write_atomically;

/// Writes a baseline named after the commit, next to those of other commits. `critcmp --target-dir
/// FOLDER` compares them.
pub(super) fn write(record: &Record, folder: &Path) -> Result<()> {
    for run in &record.runs {
        let Workload { scene, engine, threads, .. } = &run.work;
        let id = [scene, engine, &threads.to_string()].map(|part| file_name(part));
        let directory = id.join("/");
        let place = folder.join(&directory).join(file_name(&record.machine.commit));
        fs::create_dir_all(&place).map_err(Error::io(&place, "create the folder"))?;
        for (name, value) in [
            ("benchmark.json", benchmark(run, &directory)),
            ("estimates.json", estimates(run)),
            ("sample.json", sample(run)),
        ] {
            write_atomically(&place.join(name), |out| writeln!(out, "{value:#}"))?;
        }
    }
    Ok(())
}

/// Turns `text` into a file name as criterion does. Long names keep only their last 60 characters, since
/// the end of a path identifies it better.
fn file_name(text: &str) -> String {
    let safe = |c: char| if "?\"/\\*<>:|^".contains(c) || c.is_control() { '_' } else { c };
    let end = text.chars().count().saturating_sub(60);
    text.chars().skip(end).map(safe).collect()
}

fn benchmark(run: &Run, directory: &str) -> Value {
    let Workload { scene, engine, threads, .. } = &run.work;
    let rays = run.blocks.first().map_or(0, |block| block.rays.total());
    json!({
        "group_id": scene,
        "function_id": engine,
        "value_str": threads.to_string(),
        "throughput": { "Elements": rays },
        "full_id": format!("{scene}/{engine}/{threads}"),
        "directory_name": directory,
        "title": format!("{scene}/{engine}/{threads}"),
    })
}

fn nanoseconds(run: &Run) -> Vec<f64> {
    run.blocks.iter().map(|block| block.seconds * 1e9).collect()
}

/// Estimates of the nanoseconds per render.
fn estimates(run: &Run) -> Value {
    let spread = bootstrap(&nanoseconds(run));
    let estimate = |spread: Spread| {
        json!({
            "confidence_interval": {
                "confidence_level": 0.95,
                "lower_bound": spread.lo,
                "upper_bound": spread.hi,
            },
            "point_estimate": spread.point,
            "standard_error": spread.error,
        })
    };
    json!({
        "mean": estimate(spread.mean),
        "median": estimate(spread.median),
        "median_abs_dev": estimate(spread.median_abs_dev),
        "slope": null,
        "std_dev": estimate(spread.std_dev),
    })
}

fn sample(run: &Run) -> Value {
    let times = nanoseconds(run);
    json!({ "sampling_mode": "Flat", "iters": vec![1.0; times.len()], "times": times })
}
