//! Tests of `ptfast converge`: its table, record and plot.

use std::fs;

use serde_json::Value;

use crate::common::{ptfast, stderr, stdout};

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

/// The curves that `converge` records, with these options.
fn curves(scene: &str, options: &str) -> Vec<Value> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.ron"), scene).unwrap();
    let base = ["converge", "scene.ron", "--width", "40", "--sampling", "bsdf", "--json", "a.json"];
    let options: Vec<&str> = base.into_iter().chain(options.split(' ')).collect();
    let output = ptfast(folder.path(), &options);
    assert!(output.status.success(), "{}", stderr(&output));
    let record = fs::read(folder.path().join("a.json")).unwrap();
    let record: Value = serde_json::from_slice(&record).unwrap();
    assert_eq!(record["width"], record["height"]);
    record["curves"].as_array().unwrap().clone()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Under a smooth sky, the image of a diffuse ball is smooth except at the rim. The error of
/// independent samples falls as 1/n, that of Sobol' points faster.
#[test]
fn errors_fall_as_theory_says() {
    let scene = r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
        background: gradient(bottom: (0, 0, 0), top: (1, 1, 1)), render: (width: 40, height: 40),
        materials: {"m": lambertian(albedo: (0.7, 0.7, 0.7))},
        primitives: [sphere(center: (0, 0, 0), radius: 1, material: "m")])"#;
    let curves = curves(scene, "--spp 64 --reference 1024");
    let named = |name: &str| curves.iter().find(|curve| curve["sampler"] == name).unwrap();
    let [independent, sobol] = ["independent", "sobol"].map(named);
    let slope = |curve: &Value| (number(&curve["slope"]), 6.0 * number(&curve["slope_error"]));
    let (of_independent, of_sobol) = (slope(independent), slope(sobol));
    assert!((of_independent.0 + 1.0).abs() < of_independent.1, "{of_independent:?}");
    assert!(of_sobol.0 < -1.0 - of_sobol.1, "{of_sobol:?}");
    let last = |curve: &Value| {
        let point = &curve["points"][6];
        assert_eq!(point["spp"], 64);
        (number(&point["mse"]), 6.0 * number(&point["mse_error"]))
    };
    let (independent, sobol) = (last(independent), last(sobol));
    assert!(sobol.0 + sobol.1 < independent.0 - independent.1, "{sobol:?} {independent:?}");
}

/// A noisy reference makes the estimated error noisier, not larger.
#[test]
fn the_noise_of_the_reference_does_not_count() {
    let folder = tempfile::tempdir().unwrap();
    let cornell = stdout(&ptfast(folder.path(), &["scenes", "show", "cornell"]));
    let [few, many] = ["32", "4096"].map(|reference| {
        let options = format!("--spp 16 --sampler independent --reference {reference}");
        let point = &curves(&cornell, &options)[0]["points"][4];
        [number(&point["mse"]), number(&point["mse_error"])]
    });
    // The noise of both small references together is as large as that of the renders. It affects the
    // differences of all renders alike, so `mse_error` does not cover it. It adds an error of about
    // the same size.
    let error = (few[1] * few[1] + many[1] * many[1]).sqrt();
    assert!((few[0] - many[0]).abs() < 12.0 * error, "{few:?} {many:?}");
}
