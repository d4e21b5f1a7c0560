//! Tests of the gate: verdicts, and measurements too uncertain for a verdict.

use super::*;

#[test]
fn the_gate_fails_if_a_program_is_slower() {
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
    // The measured program takes 4% longer.
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
    // The slow program is not slower by 5%, and the fast one is not slower at all.
    assert_eq!(gate(&slow, &fast, "5").0, Some(0));
    let (code, outcomes, ..) = gate(&fast, &slow, "1");
    assert_eq!((code, outcomes), (Some(0), vec!["improved".to_owned(); 2]));
    let (code, outcomes, ..) = gate(&fast, &fast, "1");
    assert_eq!((code, outcomes), (Some(0), vec!["same".to_owned(); 2]));
}

/// Compares paths per clock cycle with those of an earlier record.
#[test]
fn the_gate_fails_if_a_program_is_slower_than_its_baseline() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let [slow, fast] = [("slow", 1.0), ("fast", 0.5)]
        .map(|(name, seconds)| pretender(here, name, seconds, None).display().to_string());
    // Other tests disturb the measured clock frequency, so allow a large threshold.
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
    // Remove the recorded load, so that the load of other tests does not matter.
    change("quiet.json", &load(Value::Null));
    let (code, outcome, _, told) = gate(&slow, "quiet.json");
    assert_eq!((code, &*outcome), (Some(3), "regressed"), "{told}");
    assert!(told.contains("gate: 2 regressed, 0 improved, 0 the same, 0 unclear"), "{told}");
    let (code, outcome, _, told) = gate(&fast, "quiet.json");
    assert_eq!((code, &*outcome), (Some(0), "same"), "{told}");

    if cfg!(target_os = "linux") {
        assert!(read(&here.join("old.json"))["runs"][0]["blocks"][0]["load"].is_f64());
        // The actual load cannot match both an idle and a fully loaded machine.
        let unclear = |share: f64| {
            change("busy.json", &load(json!(share)));
            let (code, outcome, reason, _) = gate(&slow, "busy.json");
            let unclear = outcome == "unclear" && reason.contains("load by other processes");
            assert_eq!(code, Some(if outcome == "regressed" { 3 } else { 0 }));
            unclear
        };
        assert!(unclear(0.0) || unclear(1.0));
    }
    change("image.json", &|run| run["hash"] = json!("another"));
    let (code, outcome, reason, told) = gate(&slow, "image.json");
    assert_eq!((code, &*outcome, &*reason), (Some(0), "unclear", "the images differ"), "{told}");
    assert!(told.contains("2 unclear"), "{told}");
    let compared = [&SMALL[..], &["--program", &slow, "--baseline", "image.json"]].concat();
    let told = stdout(&ptfast(here, &compared));
    assert_eq!(
        told.matches("the images differ").count(),
        2,
        "different images must be reported without --gate too: {told}"
    );
}

/// Both programs share a measured plan, since measuring again could choose another plan by chance.
#[test]
fn measured_plans_are_shared_by_both_programs() {
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
    assert_eq!(timed("usual"), (4096, 8192), "default plans may differ between versions");
}

/// A bench warns immediately if its record would be useless as a baseline.
#[test]
fn records_useless_as_a_baseline_are_reported() {
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
    let told = "not usable as a baseline for cornell scalar 1 (most blocks are contaminated), \
                cornell wavefront 1";
    assert!(stderr(&output).contains(told), "{}", stderr(&output));
}

/// A disturbed bench takes more samples until two are clean, but at most four.
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
    // Each block has four renders of this program, and the first sample has 6 blocks.
    let (code, doubts, again, told) = gate(1 + 4 * 6);
    assert_eq!((code, &doubts[..], again), (Some(3), &[true, false, false][..], 2), "{told}");
    assert!(told.contains("REGRESSED (1 of 3 measurements discarded)"), "{told}");
    let (code, doubts, again, told) = gate(u32::MAX);
    assert_eq!((code, &doubts[..], again), (Some(0), &[true; 4][..], 3), "{told}");
    assert!(told.contains("unclear (most blocks are contaminated, 4 of 4"), "{told}");
}

#[test]
fn a_wrong_image_fails_the_bench() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let wrong = pretender(here, "wrong", 0.1, Some("abc")).display().to_string();
    let measured = [&SMALL[..], &["--program", &wrong, "--json", "bench.json"]].concat();
    fails(here, &measured, 70, &["cornell", "scalar", "abc", "wavefront"]);
    assert!(!here.join("bench.json").exists());
}
