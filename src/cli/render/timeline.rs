//! `ptfast render --trace`: a timeline of each worker, in the Trace Event Format that Perfetto and Chrome
//! read.

use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::engine::{Activity, Event, Render};
use crate::error::Result;
use crate::film::Unit;
use crate::output::write_atomically;

/// Writes the timeline of the workers of `render`.
pub(crate) fn write(path: &Path, scene: &str, threads: usize, render: &Render) -> Result<()> {
    let process = json!({ "name": format!("ptfast {scene}") });
    let names =
        std::iter::once(metadata("process_name", 0, process)).chain((0..threads).map(|worker| {
            metadata("thread_name", worker, json!({ "name": format!("worker {worker}") }))
        }));
    write_atomically(path, |file| {
        // One event per line, since there may be a million events.
        writeln!(file, "{{\"displayTimeUnit\":\"ms\",\"traceEvents\":[")?;
        let events = names.chain(render.timeline.iter().map(event));
        for (number, event) in events.enumerate() {
            let comma = if number == 0 { "" } else { ",\n" };
            write!(file, "{comma}{event}")?;
        }
        writeln!(file, "\n]}}")
    })
}

fn metadata(name: &str, worker: usize, args: Value) -> Value {
    json!({ "ph": "M", "pid": 1, "tid": worker, "name": name, "args": args })
}

/// An event of the format's type "complete" (`X`), with times in microseconds.
fn event(event: &Event) -> Value {
    let (name, category, args) = match event.activity {
        Activity::Unit(Unit { tile, first, end }) => {
            let place = format!("tile {}, {}", tile.x, tile.y);
            let size =
                json!({ "width": tile.width, "height": tile.height, "samples": [first, end] });
            (place, "tile", size)
        }
        Activity::Stage { stage, segment, active } => {
            (stage.name().to_owned(), "stage", json!({ "segment": segment, "active": active }))
        }
    };
    json!({
        "ph": "X",
        "pid": 1,
        "tid": event.worker,
        "ts": event.start * 1e6,
        "dur": event.seconds * 1e6,
        "name": name,
        "cat": category,
        "args": args,
    })
}
