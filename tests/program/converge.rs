//! Tests of `ptfast converge`: its table, record and plot.

use std::fs;

use crate::common::{ptfast, stderr, stdout};
use serde_json::Value;

#[test]
fn errors_are_reported_as_table_record_and_plot() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "converge",
        "--scene",
        "cornell",
        "--width",
        "16",
        "--spp",
        "8",
        "--rounds",
        "2",
        "--sampling",
        "light",
        "--sampling",
        "mis",
        "--json",
        "a.json",
        "--plot",
        "a.svg",
    ];
    let output = ptfast(folder.path(), &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let table = stdout(&output);
    for way in ["light    independent", "light    sobol", "mis      independent", "mis      sobol"]
    {
        assert!(table.contains(way), "{table}");
    }
    let record: Value =
        serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    assert_eq!((&record["width"], &record["height"]), (&16.into(), &16.into()));
    assert_eq!(record["reference_spp"], 8 * 32);
    let curves = record["curves"].as_array().unwrap();
    assert_eq!(curves.len(), 4);
    for curve in curves {
        assert!(curve["slope"].as_f64().unwrap() < 0.0, "{curve}");
        let points = curve["points"].as_array().unwrap();
        let spp: Vec<u64> = points.iter().map(|point| point["spp"].as_u64().unwrap()).collect();
        assert_eq!(spp, [1, 2, 4, 8]);
        assert!(points.iter().all(|point| point["seconds"].as_f64().unwrap() > 0.0));
        let mse = |place: usize| points[place]["mse"].as_f64().unwrap();
        assert!(mse(0) > mse(3), "{curve}");
    }
    let plot = fs::read_to_string(folder.path().join("a.svg")).unwrap();
    assert!(plot.starts_with("<svg") && plot.contains("mis sobol, slope -"), "{plot}");
}

/// Errors at times that were not measured are left out instead of extrapolated.
#[test]
fn errors_that_were_not_measured_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let run = |more: &[&str]| {
        let base =
            ["converge", "--scene", "cornell", "--width", "8", "--spp", "4", "--rounds", "2"];
        // A repeated sampling mode is rendered once.
        let way =
            ["--sampling", "mis", "--sampling", "mis", "--sampler", "sobol", "--json", "a.json"];
        let output = ptfast(folder.path(), &[&base[..], &way, more].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let record: Value =
            serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
        assert_eq!(record["curves"].as_array().unwrap().len(), 1);
        (record["curves"][0]["mse_at_seconds"].clone(), stdout(&output), stderr(&output))
    };
    let (error, _, told) = run(&[]);
    assert!(error.as_f64().unwrap() > 0.0 && told.is_empty(), "{told}");
    let (error, table, told) = run(&["--compare-at", "1e300"]);
    assert!(error.is_null() && table.contains("–"), "{table}");
    assert!(told.contains("some renders have no error at"), "{told}");
}

#[test]
fn wrong_usage_is_refused_before_anything_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, part) in [
        (&["--plot", "a.png"] as &[&str], "a.png: the name of a plot must end with .svg"),
        (&["--compare-at", "0"], "--compare-at must be above 0"),
        (&["--json", "no/such/a.json"], "no/such"),
        (&["--plot", "a.svg", "--json", "a.svg"], "need different files"),
        (&["--spp", "1"], "--spp"),
    ] {
        let arguments = [&["converge", "--scene", "cornell"], arguments].concat();
        let output = ptfast(folder.path(), &arguments);
        assert!(matches!(output.status.code(), Some(2 | 74)), "{arguments:?}");
        assert!(stderr(&output).contains(part), "{arguments:?}: {}", stderr(&output));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{arguments:?}");
    }
}
