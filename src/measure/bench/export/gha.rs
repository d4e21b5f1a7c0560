//! Exports records for github-action-benchmark with the tool `customBiggerIsBetter`.

use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::error::Result;
use crate::measure::bench::{Record, Run, Workload};
use crate::measure::settings;
use crate::output::write_atomically;

/// Writes one row for each run.
pub(super) fn write(record: &Record, file: &Path) -> Result<()> {
    let rows: Vec<Value> = record.runs.iter().map(|run| row(run, record)).collect();
    write_atomically(file, |out| writeln!(out, "{:#}", Value::from(rows)))
}

fn row(run: &Run, record: &Record) -> Value {
    let speed = run.mrays_per_s;
    let machine = &record.machine;
    let Workload { threads, settings, .. } = &run.work;
    let hash = &run.hash;
    json!({
        "name": super::name_of(&run.work),
        "unit": "Mrays/s",
        "value": speed.median,
        "range": format!("± {:.3}", 0.5 * (speed.hi - speed.lo)),
        "extra": format!(
            "{}, {threads} threads\n{}, {} lanes, {}\nimage {hash}",
            settings::describe(settings), machine.cpu, machine.lanes, machine.rustc
        ),
    })
}
