//! Tests of `ptfast bench`: records, exports, comparisons.
//!
//! They do not test measured speeds. If a verdict matters, the bench runs fake programs, which
//! render nothing and report a time that the test chooses.

#[cfg(unix)]
mod gate;
#[cfg(unix)]
mod interrupt;
mod record;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::common::{ptfast, stderr, stdout};

/// Arguments of a bench of a few pixels, with both engines.
const SMALL: [&str; 10] =
    ["bench", "--scene", "cornell", "--width", "16", "--spp", "2", "--threads", "1", "--quiet"];

/// Runs a small bench, checks that it succeeds, and returns its table.
#[track_caller]
fn bench(folder: &Path, more: &[&str]) -> String {
    let output = ptfast(folder, &[&SMALL[..], more].concat());
    assert!(output.status.success(), "{more:?}: {}", stderr(&output));
    stdout(&output)
}

/// Checks that the program fails with this exit code and one line that contains these words.
#[track_caller]
fn fails(folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let output = ptfast(folder, arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    for word in words {
        assert!(said.contains(word), "{word} is missing in: {said}");
    }
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

/// Runs the same render as the counting render of a bench, and writes the record of that render to
/// a file.
fn render_counting(folder: &Path, engine: &str, record: &str) {
    let what = ["--scene", "cornell", "--width", "16", "--spp", "2", "--threads", "1"];
    let how = ["-q", "--stats", "--engine", engine, "--json", record];
    assert!(ptfast(folder, &[&["render"], &what[..], &how[..]].concat()).status.success());
}

/// A fake program that renders nothing. It writes the record of a render of cornell with another
/// time and, if given, another hash for the scalar engine.
#[cfg(unix)]
fn pretender(folder: &Path, name: &str, seconds: f64, scalar_hash: Option<&str>) -> PathBuf {
    for engine in ["scalar", "wavefront"] {
        let file = format!("{name}.{engine}.json");
        render_counting(folder, engine, &file);
        let mut record = read(&folder.join(&file));
        record["seconds"]["render"] = json!(seconds);
        record["interference"] = json!({ "stolen": 0.0, "waited": 0.0, "switches": 0 });
        if let (Some(hash), "scalar") = (scalar_hash, engine) {
            record["hash"] = json!(hash);
        }
        fs::write(folder.join(&file), record.to_string()).unwrap();
    }
    let path = folder.join(name);
    let script = format!(
        "#!/bin/sh\nwhile [ $# -gt 0 ]; do\n  case $1 in --json) to=$2 ;; --engine) engine=$2 ;; esac\n  \
         shift\ndone\ncat '{}'.$engine.json > \"$to\"\n",
        path.display()
    );
    write_program(&path, &script);
    path
}

#[cfg(unix)]
fn write_program(path: &Path, script: &str) {
    use std::os::unix::fs::PermissionsExt;
    fs::write(path, script).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}
