//! `ptfast bench`: records, exports, comparisons. What it measures is not tested here: where a verdict
//! matters, programs take part that only say how long they took.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use common::{ptfast, stderr, stdout};
use serde_json::{Value, json};

/// A bench of a few pixels, in which everything takes part.
const SMALL: [&str; 10] =
    ["bench", "--scene", "cornell", "--width", "16", "--spp", "2", "--threads", "1", "--quiet"];

#[track_caller]
fn bench(folder: &Path, more: &[&str]) -> String {
    let output = ptfast(folder, &[&SMALL[..], more].concat());
    assert!(output.status.success(), "{more:?}: {}", stderr(&output));
    stdout(&output)
}

/// Ends with this code and a line that contains these words.
#[track_caller]
fn fails(folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let output = ptfast(folder, arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    for word in words {
        assert!(said.contains(word), "{word} is not in: {said}");
    }
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn records_have_the_fields_that_scripts_rely_on() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bench(here, &["--blocks", "7", "--json", "bench.json", "--threads", "2"]);
    for word in ["Mrays/s", "x scalar", "cornell", "wavefront", "control", "shade", "commit"] {
        assert!(table.contains(word), "{word} is not in {table}");
    }
    let record = read(&here.join("bench.json"));
    assert_eq!(record["schema"], 1);
    for field in ["cpu", "cores", "isa", "lanes", "os", "rustc", "flags", "commit"] {
        assert!(!record["machine"][field].is_null(), "machine.{field}");
    }
    let runs = record["runs"].as_array().unwrap();
    let names: Vec<(&str, u64)> = runs
        .iter()
        .map(|run| (run["engine"].as_str().unwrap(), run["threads"].as_u64().unwrap()))
        .collect();
    assert_eq!(names, [("scalar", 1), ("wavefront", 1), ("scalar", 2), ("wavefront", 2)]);
    for run in runs {
        assert_eq!(run["scene"], "cornell");
        for (field, value) in [("width", 16), ("height", 16), ("spp", 2), ("seed", 1)] {
            assert_eq!(run[field], value, "{field}");
        }
        let blocks = run["blocks"].as_array().unwrap();
        assert_eq!(blocks.len(), 7);
        for block in blocks {
            assert!(number(&block["seconds"]) > 0.0);
            assert_eq!(block["rays"]["primary"], 16 * 16 * 2);
            assert!(block["contaminated"].is_boolean());
        }
        for rate in ["mrays_per_s", "msamples_per_s"] {
            let of = |end: &str| number(&run[rate][end]);
            assert!(0.0 < of("lo") && of("lo") <= of("median") && of("median") <= of("hi"));
        }
        let counters = &run["counters"];
        for counter in ["node_visits", "leaf_tests", "lanes_issued", "lanes_active"] {
            assert!(counters[counter].is_u64(), "{counter}");
        }
        assert!(counters["lanes_issued"].as_u64() >= counters["lanes_active"].as_u64());
        assert!(counters["lanes_active"].as_u64() > Some(0));
        assert!(run["peak_rss_bytes"].as_u64() > Some(1 << 20));
        if run["engine"] == "wavefront" {
            for stage in ["generate", "extend", "sort", "shade", "connect", "accumulate"] {
                assert!(number(&run["stages"][stage]) > 0.0, "{stage}");
            }
        }
    }
    // Engines and threads give one image, that of `render`.
    let arguments = ["render", "--scene", "cornell", "--width", "16", "--spp", "2", "-q"];
    let told = stdout(&ptfast(here, &arguments));
    for run in runs {
        assert!(told.contains(run["hash"].as_str().unwrap()), "{told}");
    }
    let ratios = record["ratios"].as_array().unwrap();
    let pairs: Vec<(&str, &str)> = ratios
        .iter()
        .map(|ratio| (ratio["of"].as_str().unwrap(), ratio["to"].as_str().unwrap()))
        .collect();
    assert_eq!(pairs, [("wavefront", "scalar"), ("wavefront", "wavefront")].repeat(2));
    for ratio in ratios {
        assert_eq!(ratio["scene"], "cornell");
        assert!(number(&ratio["lo"]) <= number(&ratio["median"]), "{ratio}");
    }
}

/// What a bench renders to count the work, with its record in a file.
fn render_counting(folder: &Path, engine: &str, record: &str) {
    let what = ["--scene", "cornell", "--width", "16", "--spp", "2", "--threads", "1"];
    let how = ["-q", "--stats", "--engine", engine, "--json", record];
    assert!(ptfast(folder, &[&["render"], &what[..], &how[..]].concat()).status.success());
}

/// Counts are exact, of a render that anyone can repeat.
#[test]
fn counters_are_those_of_a_render_that_counts() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bench(here, &["--json", "bench.json"]);
    for run in read(&here.join("bench.json"))["runs"].as_array().unwrap() {
        let engine = run["engine"].as_str().unwrap();
        render_counting(here, engine, "render.json");
        let render = read(&here.join("render.json"));
        let mut node_visits = 0;
        for segment in render["segments"].as_array().unwrap() {
            for stage in segment["stages"].as_object().unwrap().values() {
                node_visits += stage["counters"]["node_visits"].as_u64().unwrap_or(0);
            }
        }
        assert_eq!(run["counters"]["node_visits"], node_visits, "{engine}");
        let leaf_tests = run["counters"]["leaf_tests"].as_u64().unwrap();
        // Cornell's rays are tested against all primitives; the reference has its tree.
        assert!(leaf_tests > 0 && (node_visits > 0) == (engine == "scalar"), "{engine}: {run}");
    }
}

#[test]
fn exports_have_the_fields_of_their_formats() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let exports = |folder| {
        ["criterion", "gha", "bmf", "csv"].map(|format| ["--export", format, folder]).concat()
    };
    let engine = ["--engine", "wavefront", "--json", "bench.json"];
    bench(here, &[&engine[..], &exports("out")].concat());
    bench(here, &[&engine[..], &exports("out")].concat());
    let record = read(&here.join("bench.json"));
    let speed = &record["runs"][0]["mrays_per_s"];
    let commit = record["machine"]["commit"].as_str().unwrap();

    let criterion = here.join("out/criterion/cornell/wavefront/1").join(commit);
    let estimates = read(&criterion.join("estimates.json"));
    for statistic in ["mean", "median", "median_abs_dev", "std_dev"] {
        let of = &estimates[statistic];
        let interval = &of["confidence_interval"];
        assert_eq!(interval["confidence_level"], 0.95);
        let [lo, hi] = ["lower_bound", "upper_bound"].map(|end| number(&interval[end]));
        assert!(lo <= number(&of["point_estimate"]) && number(&of["point_estimate"]) <= hi);
        assert!(number(&of["standard_error"]) >= 0.0);
    }
    let benchmark = read(&criterion.join("benchmark.json"));
    assert_eq!(benchmark["full_id"], "cornell/wavefront/1");
    let blocks = record["runs"][0]["blocks"].as_array().unwrap();
    let rays = blocks[0]["rays"].as_object().unwrap().values().map(number).sum::<f64>();
    assert_eq!(number(&benchmark["throughput"]["Elements"]), rays);
    let mean = blocks.iter().map(|block| number(&block["seconds"])).sum::<f64>() / 12.0;
    let told = number(&estimates["mean"]["point_estimate"]);
    assert!((told / (mean * 1e9) - 1.0).abs() < 1e-9, "{told} {mean}");

    let rows = read(&here.join("out/benchmark.json"));
    assert_eq!(
        (rows[0]["name"].as_str(), rows[0]["unit"].as_str()),
        (Some("cornell/wavefront"), Some("Mrays/s"))
    );
    assert_eq!(rows[0]["value"], speed["median"]);
    assert!(rows[0]["range"].is_string() && rows[0]["extra"].is_string());

    let throughput = &read(&here.join("out/bmf.json"))["cornell/wavefront"]["throughput"];
    for (field, end) in [("value", "median"), ("lower_value", "lo"), ("upper_value", "hi")] {
        assert_eq!(number(&throughput[field]), number(&speed[end]) * 1e6, "{field}");
    }

    let csv = fs::read_to_string(here.join("out/bench.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!((lines[0], lines.len()), ("time,commit,cornell/wavefront", 3));
    assert!(lines[2].contains(commit) && lines[2].ends_with(&speed["median"].to_string()), "{csv}");
    // A line of other columns does not fit, which is known before anything is measured.
    let other = [&SMALL[..], &["--export", "csv", "out", "--json", "new.json"]].concat();
    fails(here, &other, 65, &["bench.csv:1", "time,commit,cornell/scalar"]);
    assert_eq!(fs::read_to_string(here.join("out/bench.csv")).unwrap(), csv);
    assert!(!here.join("new.json").exists());
}

#[test]
fn baselines_are_compared_and_counters_told() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bench(here, &["--json", "old.json"]);
    let same = bench(here, &["--baseline", "old.json"]);
    assert!(same.contains("exact counts of 2 runs compared: no change\n"), "{same}");
    assert!(same.contains("times ") && !same.contains("by more than"), "{same}");

    let old = read(&here.join("old.json"));
    let with = |change: &dyn Fn(&mut Value)| {
        let mut changed = old.clone();
        change(&mut changed);
        fs::write(here.join("changed.json"), changed.to_string()).unwrap();
    };
    let compared = [&SMALL[..], &["--baseline", "changed.json"]].concat();
    with(&|record| record["runs"][1]["counters"]["leaf_tests"] = json!(1));
    let told = stdout(&ptfast(here, &compared));
    assert!(told.contains("exact counts of 2 runs compared: changed\n"), "{told}");
    assert!(told.contains("cornell wavefront 1: leaf tests 1 -> "), "{told}");
    assert_eq!(told.matches("counter ").count(), 1, "{told}");

    with(&|record| record["machine"]["cpu_model"] = json!("family 1 model 1 stepping 1"));
    fails(here, &compared, 65, &["changed.json:machine", "family 1 model 1", "cannot be compared"]);
    with(&|record| record["machine"]["cpu_model"] = json!(""));
    assert!(ptfast(here, &compared).status.success(), "records of old do not tell");
    with(&|record| record["machine"]["cpu"] = json!("another"));
    fails(here, &compared, 65, &["changed.json:machine", "another"]);
    with(&|record| record["schema"] = json!(2));
    fails(here, &compared, 65, &["changed.json:schema", "version 2"]);
    with(&|record| record["runs"][0]["blocks"] = json!([]));
    fails(here, &compared, 65, &["changed.json:runs[0].blocks"]);
    for (field, value) in
        [("seconds", json!(0)), ("clock", json!(1e300)), ("seconds", json!(1e-320))]
    {
        with(&|record| record["runs"][1]["blocks"][2][field] = value.clone());
        fails(here, &compared, 65, &["changed.json:runs[1].blocks[2]"]);
    }
    with(&|record| record["runs"][0]["mrays_per_s"]["hi"] = json!(0.0));
    fails(here, &compared, 65, &["changed.json:runs[0].mrays_per_s", "finite"]);
    // Of another version: its plan is unknown here, and what was counted by it.
    with(&|record| record["runs"][1]["plan"] = json!({ "kernels": ["quantum"] }));
    let told = stdout(&ptfast(here, &compared));
    assert!(told.contains("of 1 runs compared: no change; 1 cannot be compared"), "{told}");
    with(&|record| {
        record["runs"].as_array_mut().unwrap().iter_mut().for_each(|run| run["spp"] = json!(3));
    });
    fails(here, &compared, 65, &["changed.json:runs", "nothing of what is to be measured"]);
    fs::write(here.join("changed.json"), "{\"schema\":1").unwrap();
    fails(here, &compared, 65, &["changed.json:1:11"]);
}

#[test]
fn wrong_usage_is_told_before_anything_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let fails = |more: &[&str], code, words: &[&str]| {
        fails(here, &[&["bench"], more].concat(), code, words);
    };
    fails(&["--gate"], 2, &["--baseline", "--against"]);
    fails(&["--threshold", "0"], 2, &["between 0 and 100"]);
    fails(&["--blocks", "5"], 2, &["6"]);
    fails(&["--export", "gah", "out"], 2, &["did you mean `gha`"]);
    fails(&["--scene", "spheers"], 2, &["did you mean `spheres`"]);
    fails(&["--baseline", "none.json"], 74, &["none.json"]);
    fails(&["--quiet", "--against", "none"], 74, &["none", "run"]);
    fails(&["--quiet", "--against", "."], 2, &["not a program"]);
    fails(&["--json", "none/a.json"], 74, &["none/a.json"]);
    fs::write(here.join("a.json"), "{}").unwrap();
    fails(&["--json", "a.json", "--baseline", "./a.json"], 2, &["would replace the baseline"]);
    let clash = ["benchmark.json", "export"];
    fails(&["--json", "benchmark.json", "--export", "gha", "."], 2, &clash);
    fails(&["--export", "gha", "out", "--export", "gha", "./out"], 2, &clash);
    fs::create_dir(here.join("bmf.json")).unwrap();
    fails(&["--export", "bmf", "."], 74, &["bmf.json"]);
    fs::remove_dir(here.join("bmf.json")).unwrap();
    fails(&["--width", "60000", "--spp", "100000"], 2, &["at most"]);
    assert_eq!(fs::read_dir(here).unwrap().count(), 1);
}

/// A program that renders nothing: it says what a render of cornell said, but for its time and hash.
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

#[cfg(unix)]
#[test]
fn the_gate_shuts_where_a_program_is_slower() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let [slow, fast] = [("slow", 0.52), ("fast", 0.50)]
        .map(|(name, seconds)| pretender(here, name, seconds, None).display().to_string());
    let gate = |program: &str, against: &str, threshold: &str| {
        let more = [
            "--program",
            program,
            "--against",
            against,
            "--gate",
            "--threshold",
            threshold,
            "--json",
            "gate.json",
        ];
        let output = ptfast(here, &[&SMALL[..], &more].concat());
        let record = read(&here.join("gate.json"));
        let verdicts = record["gate"]["verdicts"].as_array().unwrap();
        let outcomes: Vec<String> = verdicts
            .iter()
            .map(|verdict| verdict["outcome"].as_str().unwrap().to_owned())
            .collect();
        (output.status.code(), outcomes, record, stdout(&output))
    };
    // 4% slower.
    let (code, outcomes, record, told) = gate(&slow, &fast, "1");
    assert_eq!((code, outcomes), (Some(3), vec!["regressed".to_owned(); 2]), "{told}");
    assert!(told.contains("REGRESSED"), "{told}");
    let verdict = &record["gate"]["verdicts"][0];
    let findings = verdict["findings"].as_array().unwrap();
    let change = &findings[0]["change"];
    assert!((number(&change["median"]) - 0.5 / 0.52).abs() < 1e-9, "{change}");
    assert_eq!(findings, &[json!({ "change": change }), json!({ "change": change })]);
    assert_eq!(record["gate"]["again"][0]["runs"][0]["blocks"].as_array().unwrap().len(), 24);
    assert!(told.contains("exact counts of 2 runs compared: no change\n"), "{told}");
    assert_eq!(record["against"]["runs"][0]["engine"], "scalar");
    let to = record["ratios"][2]["to"].as_str().unwrap();
    assert!(to.starts_with("wavefront@") || to.starts_with("scalar@"), "{to}");
    // Not by 5%; nor is the fast one slower.
    assert_eq!(gate(&slow, &fast, "5").0, Some(0));
    let (code, outcomes, ..) = gate(&fast, &slow, "1");
    assert_eq!((code, outcomes), (Some(0), vec!["improved".to_owned(); 2]));
    let (code, outcomes, ..) = gate(&fast, &fast, "1");
    assert_eq!((code, outcomes), (Some(0), vec!["same".to_owned(); 2]));
}

/// Beside a record of another time, by paths a clock cycle; clocks may differ a little even here.
#[cfg(unix)]
#[test]
fn the_gate_shuts_where_a_program_is_slower_than_its_baseline() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let [slow, fast] = [("slow", 1.0), ("fast", 0.5)]
        .map(|(name, seconds)| pretender(here, name, seconds, None).display().to_string());
    // Clocks that other tests disturb are told less exactly than those of cores that are free.
    let blocks = ["--blocks", "6", "--threshold", "30"];
    bench(here, &[&blocks[..], &["--program", &fast, "--json", "old.json"]].concat());
    let gate = |program: &str, baseline: &str| {
        let gate = ["--baseline", baseline, "--gate", "--json", "new.json", "--program", program];
        let output = ptfast(here, &[&SMALL[..], &blocks, &gate].concat());
        let verdicts = read(&here.join("new.json"))["gate"]["verdicts"].clone();
        let told = |what: &str| verdicts[0][what].as_str().unwrap().to_owned();
        (output.status.code(), told("outcome"), told("reason"), stdout(&output))
    };
    let change = |name: &str, change: &dyn Fn(&mut Value)| {
        let mut record = read(&here.join("old.json"));
        record["runs"].as_array_mut().unwrap().iter_mut().for_each(change);
        fs::write(here.join(name), record.to_string()).unwrap();
    };
    let load = |load: Value| {
        move |run: &mut Value| {
            let blocks = run["blocks"].as_array_mut().unwrap();
            blocks.iter_mut().for_each(|block| block["load"] = load.clone());
        }
    };
    // How busy tests keep the machine is no matter here.
    change("quiet.json", &load(Value::Null));
    let (code, outcome, _, told) = gate(&slow, "quiet.json");
    assert_eq!((code, &*outcome), (Some(3), "regressed"), "{told}");
    assert!(told.contains("gate: 2 regressed, 0 improved, 0 the same, 0 unclear"), "{told}");
    let (code, outcome, _, told) = gate(&fast, "quiet.json");
    assert_eq!((code, &*outcome), (Some(0), "same"), "{told}");

    if cfg!(target_os = "linux") {
        assert!(read(&here.join("old.json"))["runs"][0]["blocks"][0]["load"].is_f64());
        // Whatever else runs meanwhile, it cannot be like none and like all cores.
        let unclear = |share: f64| {
            change("busy.json", &load(json!(share)));
            let (code, outcome, reason, _) = gate(&slow, "busy.json");
            let unclear = outcome == "unclear" && reason.contains("cores busy");
            assert_eq!(code, Some(if outcome == "regressed" { 3 } else { 0 }));
            unclear
        };
        assert!(unclear(0.0) || unclear(1.0));
    }
    change("image.json", &|run| run["hash"] = json!("another"));
    let (code, outcome, reason, told) = gate(&slow, "image.json");
    assert_eq!((code, &*outcome, &*reason), (Some(0), "unclear", "another image"), "{told}");
    assert!(told.contains("2 unclear"), "{told}");
    let compared = [&SMALL[..], &["--program", &slow, "--baseline", "image.json"]].concat();
    let told = stdout(&ptfast(here, &compared));
    assert_eq!(told.matches("another image").count(), 2, "said without --gate, too: {told}");
}

/// Another measurement may choose another plan: that would be no difference of programs.
#[cfg(unix)]
#[test]
fn plans_that_were_measured_are_measured_once() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let timed = |planning: &str| {
        let [first, second] = [("first", 4096), ("second", 8192)].map(|(name, wave)| {
            let program = pretender(here, name, 0.5, None);
            let file = here.join(format!("{name}.wavefront.json"));
            let mut record = read(&file);
            record["planning"] = json!(planning);
            record["plan"]["wave_size"] = json!(wave);
            fs::write(file, record.to_string()).unwrap();
            program.display().to_string()
        });
        let against = ["--program", &first, "--against", &second, "--engine", "wavefront"];
        bench(here, &[&against[..], &["--blocks", "6", "--json", "plans.json"]].concat());
        let record = read(&here.join("plans.json"));
        let wave = |run: &Value| run["timed_plan"]["wave_size"].as_u64().unwrap();
        (wave(&record["runs"][0]), wave(&record["against"]["runs"][0]))
    };
    assert_eq!(timed("measured"), (4096, 4096));
    assert_eq!(timed("usual"), (4096, 8192), "a version may plan otherwise");
}

/// Who keeps a record learns at once that it would be no baseline.
#[cfg(unix)]
#[test]
fn records_that_tell_nothing_as_a_baseline_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let program = pretender(here, "disturbed", 0.5, None);
    for engine in ["scalar", "wavefront"] {
        let file = here.join(format!("disturbed.{engine}.json"));
        let mut record = read(&file);
        record["interference"]["switches"] = json!(1_000_000);
        fs::write(file, record.to_string()).unwrap();
    }
    let loud = SMALL.into_iter().filter(|argument| *argument != "--quiet");
    let more = ["--blocks", "6", "--json", "a.json", "--program", program.to_str().unwrap()];
    let output = ptfast(here, &loud.chain(more).collect::<Vec<_>>());
    let told = "as a baseline it would tell nothing of cornell scalar 1 (most blocks are contaminated), \
                cornell wavefront 1";
    assert!(stderr(&output).contains(told), "{}", stderr(&output));
}

/// Sends a signal, by what every shell has; `false` where there is no such process.
#[cfg(unix)]
fn kill(signal: &str, pid: &str) -> bool {
    let mut shell = Command::new("sh");
    shell.args(["-c", "kill \"$0\" \"$1\"", signal, pid]).stderr(Stdio::null());
    shell.status().unwrap().success()
}

/// A render is ended with the bench that asked for it, though only that was told to.
#[cfg(unix)]
#[test]
fn renders_end_with_the_bench() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sleeper = here.join("sleeper");
    write_program(&sleeper, "#!/bin/sh\necho $$ > pid\nexec sleep 600\n");
    let mut bench = Command::new(env!("CARGO_BIN_EXE_ptfast"))
        .args(["bench", "--quiet", "--scene", "cornell", "--program"])
        .arg(&sleeper)
        .current_dir(here)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let pid = loop {
        assert!(bench.try_wait().unwrap().is_none(), "it has ended before");
        match fs::read_to_string(here.join("pid")) {
            Ok(pid) if pid.ends_with('\n') => break pid.trim().to_owned(),
            _ => std::thread::sleep(Duration::from_millis(10)),
        }
    };
    assert!(kill("-TERM", &bench.id().to_string()));
    assert_eq!(bench.wait().unwrap().code(), Some(143));
    assert!(!kill("-0", &pid), "the render goes on");
}

/// One that is disturbed in the first blocks is measured until two samples are clean, or four were taken.
#[cfg(unix)]
#[test]
fn disturbed_samples_are_measured_again() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let [slow, fast] = [("slow", 0.52), ("fast", 0.50)]
        .map(|(name, seconds)| pretender(here, name, seconds, None).display().to_string());
    let (disturbed, calls) = (here.join("disturbed"), here.join("calls"));
    let gate = |renders: u32| {
        let script = format!(
            "#!/bin/sh\n'{slow}' \"$@\"\necho >> '{calls}'\n[ $(wc -l < '{calls}') -gt {renders} ] && exit\n\
             while [ \"$1\" != --json ]; do shift; done\n\
             sed 's/\"switches\":0/\"switches\":100000/' \"$2\" > \"$2.new\"\nmv \"$2.new\" \"$2\"\n",
            calls = calls.display()
        );
        write_program(&disturbed, &script);
        fs::write(&calls, "").unwrap();
        let engine = ["--engine", "scalar", "--blocks", "6", "--json", "gate.json"];
        let more = ["--program", disturbed.to_str().unwrap(), "--against", &fast, "--gate"];
        let output = ptfast(here, &[&SMALL[..], &engine, &more].concat());
        let gate = read(&here.join("gate.json"))["gate"].clone();
        let findings = gate["verdicts"][0]["findings"].as_array().unwrap().clone();
        let doubts: Vec<bool> = findings.iter().map(|f| f["doubt"] == "contaminated").collect();
        (output.status.code(), doubts, gate["again"].as_array().unwrap().len(), stdout(&output))
    };
    // Four renders of it in a block, of which the first sample has 6.
    let (code, doubts, again, told) = gate(1 + 4 * 6);
    assert_eq!((code, &doubts[..], again), (Some(3), &[true, false, false][..], 2), "{told}");
    assert!(told.contains("REGRESSED (1 of 3 samples discarded)"), "{told}");
    let (code, doubts, again, told) = gate(u32::MAX);
    assert_eq!((code, &doubts[..], again), (Some(0), &[true; 4][..], 3), "{told}");
    assert!(told.contains("unclear (most blocks are contaminated, 4 of 4"), "{told}");
}

/// Nothing is left behind, and what ended it is told.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let endless = ["--blocks", "10000", "--json", "bench.json"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_ptfast"))
        .args([&SMALL[..], &endless].concat())
        .current_dir(here)
        .env("TMPDIR", here)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // As soon as it has made its folder.
    let made = |entry: std::io::Result<fs::DirEntry>| {
        entry.unwrap().file_name().to_string_lossy().starts_with("ptfast-bench-")
    };
    while !fs::read_dir(here).unwrap().any(made) {
        assert!(child.try_wait().unwrap().is_none(), "it has ended before");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(kill("-TERM", &child.id().to_string()));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(143), "{}", stderr(&output));
    assert_eq!(stderr(&output), "ptfast: interrupted by SIGTERM\n");
    assert_eq!(fs::read_dir(here).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn a_wrong_answer_is_never_a_fast_one() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let wrong = pretender(here, "wrong", 0.1, Some("abc")).display().to_string();
    let measured = [&SMALL[..], &["--program", &wrong, "--json", "bench.json"]].concat();
    fails(here, &measured, 70, &["cornell", "scalar", "abc", "wavefront"]);
    assert!(!here.join("bench.json").exists());
}
