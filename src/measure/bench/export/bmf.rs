//! Exports records in the Bencher Metric Format.

use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::error::Result;
use crate::measure::bench::Record;
use crate::output::write_atomically;

/// Writes the throughput of each run in rays per second.
pub(super) fn write(record: &Record, file: &Path) -> Result<()> {
    let metrics = record.runs.iter().map(|run| {
        let speed = run.mrays_per_s;
        let metric = json!({
            "throughput": {
                "value": speed.median * 1e6,
                "lower_value": speed.lo * 1e6,
                "upper_value": speed.hi * 1e6,
            }
        });
        (super::name_of(&run.work), metric)
    });
    let metrics: Value = metrics.collect();
    write_atomically(file, |out| writeln!(out, "{metrics:#}"))
}
