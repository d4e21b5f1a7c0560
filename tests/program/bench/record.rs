//! Tests of bench records, their exports, and comparisons with a baseline.

use super::*;

#[test]
fn records_have_the_fields_that_scripts_rely_on() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bench(here, &["--blocks", "7", "--json", "bench.json", "--threads", "2"]);
    for word in ["Mrays/s", "x scalar", "cornell", "wavefront", "control", "shade", "commit"] {
        assert!(table.contains(word), "{word} is missing in {table}");
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
    // All engines and thread counts give the same image as `render`.
    let arguments = ["render", "--scene", "cornell", "--width", "16", "--spp", "2"];
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

/// Counters are exact: they equal those of a `render --stats`.
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
        // The wavefront engine traces cornell without a tree, the scalar engine with one.
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
    // A line with other columns cannot be appended, which must be reported before measuring.
    let other = [&SMALL[..], &["--export", "csv", "out", "--json", "new.json"]].concat();
    fails(here, &other, 65, &["bench.csv:1", "time,commit,cornell/scalar"]);
    assert_eq!(fs::read_to_string(here.join("out/bench.csv")).unwrap(), csv);
    assert!(!here.join("new.json").exists());
}

#[test]
fn baselines_are_compared_with_counters() {
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
    assert!(ptfast(here, &compared).status.success(), "old records do not name the CPU model");
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
    // The run of the baseline has a plan that this version does not know, so the counters of that
    // run cannot be compared.
    with(&|record| record["runs"][1]["plan"] = json!({ "kernels": ["quantum"] }));
    let told = stdout(&ptfast(here, &compared));
    assert!(
        told.contains("of 1 runs compared: no change; 1 differ in work, plan or lanes"),
        "{told}"
    );
    with(&|record| {
        record["runs"].as_array_mut().unwrap().iter_mut().for_each(|run| run["spp"] = json!(3));
    });
    fails(here, &compared, 65, &["changed.json:runs", "no run matches this bench"]);
    fs::write(here.join("changed.json"), "{\"schema\":1").unwrap();
    fails(here, &compared, 65, &["changed.json:1:11"]);
}

#[test]
fn wrong_usage_is_reported_before_anything_is_measured() {
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
    fails(&["--json", "a.json", "--baseline", "./a.json"], 2, &["would overwrite the baseline"]);
    let scene = "(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
        background: constant(radiance: (1, 1, 1)),
        materials: { \"grey\": lambertian(albedo: (0.5, 0.5, 0.5)) },
        primitives: [mesh(file: \"a.obj\", material: \"grey\")])";
    fs::write(here.join("a.ron"), scene).unwrap();
    fs::write(here.join("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    for file in ["a.ron", "a.obj"] {
        fails(&["--scene", "a.ron", "--json", file], 2, &["would overwrite a part of the scene"]);
        fs::metadata(here.join(file)).unwrap();
    }
    fs::remove_file(here.join("a.ron")).unwrap();
    fs::remove_file(here.join("a.obj")).unwrap();
    let clash = ["benchmark.json", "export"];
    fails(&["--json", "benchmark.json", "--export", "gha", "."], 2, &clash);
    fails(&["--export", "gha", "out", "--export", "gha", "./out"], 2, &clash);
    fs::create_dir(here.join("bmf.json")).unwrap();
    fails(&["--export", "bmf", "."], 74, &["bmf.json"]);
    fs::remove_dir(here.join("bmf.json")).unwrap();
    fails(&["--width", "60000", "--spp", "100000"], 2, &["exceeds the limit"]);
    assert_eq!(fs::read_dir(here).unwrap().count(), 1);
}
