//! Tests of `ptfast dashboard` with a synthetic history.
//!
//! Only `.ci/run` runs the tests that need a browser.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::common::{ptfast, stderr, stdout};

/// Speeds of the scene `spheres` on the first of two machines. They drop by 8% at the fifth of 8
/// commits.
const SPEEDS: [f64; 8] = [100.0, 100.4, 99.8, 100.1, 92.0, 92.3, 91.9, 92.1];

fn estimate(median: f64) -> Value {
    json!({ "median": median, "lo": 0.99 * median, "hi": 1.01 * median })
}

fn run(scene: &str, engine: &str, threads: u32, speed: f64, clock: f64) -> Value {
    let rays = 1_000_000;
    let block = |number: u32| {
        let seconds = f64::from(rays) / (speed * 1e6) * (1.0 + 0.0005 * f64::from(number % 5));
        let rays = json!({ "primary": rays / 2, "bounce": rays / 2, "shadow": 0 });
        // Clock frequencies change from hour to hour, but speed per cycle does not.
        json!({ "seconds": seconds / clock, "rays": rays, "clock": 3.5 * clock })
    };
    let work = |active: u32| json!({ "active": active, "issued": 1000 });
    let wavefront = engine == "wavefront";
    let mut run = json!({
        "scene": scene, "scene_hash": "0123456789abcdef", "engine": engine, "threads": threads,
        "width": 640, "height": 360, "spp": 16, "depth": 50, "sampling": "bsdf", "seed": 1,
        "hash": "a", "blocks": (0..10).map(block).collect::<Vec<_>>(),
        "mrays_per_s": estimate(clock * speed), "msamples_per_s": estimate(0.5 * clock * speed),
        "stages": if wavefront { json!({ "extend": 0.6, "shade": 0.3, "sort": 0.1, "connect": 0.0 }) }
            else { json!({ "extend": 0.0 }) },
        "counters": { "node_visits": 500, "leaf_tests": 900, "lanes_issued": 2000, "lanes_active": 1500 },
        "lanes": if wavefront {
            json!([{ "extend": work(900), "shade": work(800) }, { "extend": work(700), "shade": work(750) }])
        } else { json!([]) },
        "peak_rss_bytes": 20_000_000,
    });
    // Old versions of the program did not record a sampler.
    if scene == "cornell" {
        run["sampler"] = json!("sobol");
    }
    run
}

fn record(number: usize, cpu_model: &str, speed: f64) -> Value {
    let clock = [1.0, 0.9, 1.1][number % 3];
    let mut record = json!({
        "schema": 1, "time": format!("2026-01-{:02}T00:00:00Z", number + 1),
        "machine": {
            "cpu": "A CPU", "cpu_model": cpu_model, "cores": 2, "isa": "avx2", "lanes": 8, "os": "linux", "rustc": "rustc 1.95.0",
            "flags": "</script><b>", "commit": format!("c{number}ffee0123456"),
        },
        "runs": [
            run("spheres", "scalar", 1, 10.0, clock),
            run("spheres", "wavefront", 1, speed, clock),
            run("cornell", "wavefront", 2, 70.0, clock),
        ],
        "ratios": [{
            "scene": "spheres", "threads": 1, "of": "wavefront", "to": "scalar",
            "median": speed / 10.0, "lo": speed / 10.1, "hi": speed / 9.9,
        }],
    });
    if number >= 6 {
        record["runs"][1]["counters"]["node_visits"] = json!(490);
    }
    record
}

fn history(folder: &Path) {
    fs::create_dir(folder.join("history")).unwrap();
    let write = |name: String, record: Value| {
        fs::write(folder.join("history").join(name), record.to_string()).unwrap();
    };
    for (number, speed) in SPEEDS.into_iter().enumerate() {
        // Records are ordered by time, not by file name.
        write(format!("{}.json", 9 - number), record(number, "First model", speed));
        if number < 3 {
            // A hypervisor may report one name for different CPUs.
            write(format!("b{number}.json"), record(number, "Second model", 50.0));
        }
    }
    fs::write(folder.join("history/notes.txt"), "no record").unwrap();
}

fn page(folder: &Path) -> String {
    history(folder);
    let output = ptfast(folder, &["dashboard", "--history", "history", "--out", "out/page"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).contains("11 records"), "{}", stdout(&output));
    fs::read_to_string(folder.join("out/page/index.html")).unwrap()
}

/// The data embedded in the page.
fn data(page: &str) -> Value {
    let data = page.split("const DATA = ").nth(1).unwrap();
    serde_json::from_str(data.split(";</script>").next().unwrap()).unwrap()
}

#[test]
fn each_series_has_one_machine_and_the_change_point_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let data = data(&page(folder.path()));
    let machines: Vec<&str> =
        data["machines"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert_eq!(machines.len(), 2);
    let name = |model: &str| format!("A CPU ({model} model), 2 cores, avx2 (8 lanes)");
    assert_eq!(machines, [name("First"), name("Second")]);
    let series = data["series"].as_array().unwrap();
    assert_eq!(series.len(), 6, "two machines with three runs each");
    for series in series {
        let points = series["points"].as_array().unwrap();
        let first = series["machine"] == 0;
        assert_eq!(points.len(), if first { 8 } else { 3 });
        let render = points[0]["render"].as_str().unwrap();
        assert!(render.contains(" --sampling bsdf"), "{render}");
        assert_eq!(render.contains(" --sampler sobol"), series["scene"] == "cornell", "{render}");
        let changed: Vec<usize> =
            (0..points.len()).filter(|&point| !points[point]["change"].is_null()).collect();
        let slows = first && series["scene"] == "spheres" && series["engine"] == "wavefront";
        assert_eq!(changed, if slows { vec![4] } else { vec![] }, "{series}");
        if slows {
            let change = &points[4]["change"];
            assert_eq!(change["confirmed"], true);
            let ratio = change["ratio"]["median"].as_f64().unwrap();
            assert!((ratio - 0.92).abs() < 0.005, "{ratio}");
            let commit =
                data["records"][points[4]["record"].as_u64().unwrap() as usize]["commit"].as_str();
            assert_eq!(commit, Some("c4ffee0123456"));
            assert!(
                points[4]["bench"]
                    .as_str()
                    .unwrap()
                    .contains("../ptfast-c4ffee0123456 c4ffee0123456\n")
            );
        }
    }
}

#[test]
fn the_page_needs_no_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let html = page(folder.path());
    for outside in ["src=", "href=", "@import", "url(", "fetch(", "XMLHttpRequest"] {
        assert!(!html.contains(outside), "{outside}");
    }
    // The text of a record must not end the script element.
    assert!(!html.contains("</script><b>") && html.contains("\\u003c/script>\\u003cb>"));
    assert!(html.contains("Leon Sorokin"), "the page must contain uPlot's licence with its code");

    // If Criterion's report exists, the page links to it.
    let here = folder.path();
    fs::create_dir_all(here.join("target/criterion/report")).unwrap();
    fs::write(here.join("target/criterion/report/index.html"), "").unwrap();
    let output = ptfast(here, &["dashboard", "--history", "history", "--out", "out/page"]);
    assert!(output.status.success());
    let html = fs::read_to_string(here.join("out/page/index.html")).unwrap();
    assert!(html.contains("href=\"../../target/criterion/report/index.html\""));
}

#[test]
fn bad_histories_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let fails = |code: i32, words: &str| {
        let output = ptfast(here, &["dashboard", "--history", "history", "--out", "out"]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
        assert!(!here.join("out").exists());
    };
    fails(74, "history");
    fs::create_dir(here.join("history")).unwrap();
    fails(65, "no bench records");
    fs::write(here.join("history/a.json"), "{}").unwrap();
    fails(65, "a.json");
    let mut late = record(1, "", 1.0);
    late["time"] = json!("yesterday");
    fs::write(here.join("history/a.json"), late.to_string()).unwrap();
    fails(65, "a.json:time");
}

/// A script that sets the filters of the page step by step, and records the visible parts.
const STEPS: &str = r##"
<script>
const seen = {};
const titles = () => [...document.querySelectorAll("#speeds .chart")].map((box) => box.dataset.title);
const seenOnPage = (element) => element.getClientRects().length > 0;
const legend = () => [...document.querySelectorAll("#speeds .u-legend .u-label")].filter(seenOnPage).map((label) => label.textContent);
const rows = (id = "changes") => [...byId(id).rows].slice(1).map((row) => row.textContent);
const set = (box, on) => { box.checked = on; box.dispatchEvent(new Event("change")); };
const choose = (id, value) => { byId(id).value = value; byId(id).dispatchEvent(new Event("change")); };
// Counts pixels of about this colour in some columns of the first canvas, which is read once.
const canvas = document.querySelector("#speeds canvas");
const { data, width } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
const inked = (rgb, from = 0, columns = width) => {
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    const x = (i / 4) % width;
    const inside = x >= from && x < from + columns && data[i + 3] > 200;
    count += inside && rgb.every((c, k) => Math.abs(data[i + k] - c) < 30);
  }
  return count;
};
const RED = [0xd8, 0x70, 0x3b];
// The column of a record. The change point is at the fifth record, number 4.
const at = (record) => Math.round(plots[0].valToPos(record, "x", true)) - 2;
seen.machine = byId("machine").selectedOptions[0].textContent;
seen.first = { titles: titles(), legend: legend(), rows: rows(), 
  line: inked(RED), before: inked(RED, at(3), 4), change: inked(RED, at(4), 4) };
seen.counts = rows("countchanges");
seen.sections = ["stages", "lanes", "counters"].map((id) => document.querySelectorAll("#" + id + " canvas").length);
set(document.querySelector("input[name=scene][value=cornell]"), false);
seen.withoutCornell = { titles: titles(), legend: legend() };
set(document.querySelector("input[name=engine][value=scalar]"), false);
seen.withoutScalar = { legend: legend() };
choose("metric", "speedup");
seen.speedup = { titles: titles() };
choose("metric", "mrays");
choose("machine", "1");
seen.second = { titles: titles(), rows: rows() };
set(document.querySelector("input[name=thread][value='1']"), false);
seen.none = { titles: titles() };
choose("machine", "0");
set(document.querySelector("input[name=thread][value='1']"), true);
const slow = shown()[0];
show(slow, slow.points.find((point) => point.change).record);
seen.point = byId("point").textContent;
seen.buttons = [...document.querySelectorAll("#speeds .chart")].map((box) => box.querySelectorAll("button").length);
document.querySelector("#speeds button").click();
seen.pressed = byId("point").querySelector("h3").textContent;
const report = document.createElement("pre");
report.id = "seen";
report.textContent = JSON.stringify(seen);
document.body.append(report);
</script>
"##;

/// Loads a page in Chromium. Returns the document as its scripts left it, and the console messages.
fn browse(file: &Path) -> (String, Vec<String>) {
    let output = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--enable-logging=stderr", "--window-size=1400,1000", "--virtual-time-budget=5000"])
        .arg(format!("--user-data-dir={}", file.with_extension("profile").display()))
        .args(["--dump-dom", &format!("file://{}", file.display())])
        .output()
        .expect("cannot run chromium, which .ci/run installs");
    let said = stderr(&output);
    let console = said.lines().filter(|line| line.contains("CONSOLE")).map(str::to_owned).collect();
    (stdout(&output), console)
}

/// The history in the repository, from real machines and old versions.
#[test]
#[ignore = "needs Chromium, which .ci/run installs: cargo test --test program dashboard -- --ignored"]
fn the_page_of_the_real_history_works_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let history = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/record");
    let output = ptfast(here, &["dashboard", "--history", history, "--out", "page"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let (dom, console) = browse(&here.join("page/index.html"));
    assert!(console.is_empty(), "the console must be empty: {console:?}");
    for scene in ["spheres", "spacetime", "checker", "cornell"] {
        assert!(dom.contains(&format!("data-title=\"{scene}: Mrays/s\"")), "{scene}");
    }
}

#[test]
#[ignore = "needs Chromium, which .ci/run installs: cargo test --test program dashboard -- --ignored"]
fn the_page_works_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let html = page(here).replace("</body>", &format!("{STEPS}</body>"));
    let file = here.join("steps.html");
    fs::write(&file, html).unwrap();
    let (dom, console) = browse(&file);
    assert!(console.is_empty(), "the console must be empty: {console:?}");
    let seen = dom
        .split("<pre id=\"seen\">")
        .nth(1)
        .unwrap_or_else(|| panic!("the script left no report: {dom}"));
    let seen = seen.split("</pre>").next().unwrap();
    let seen = seen.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let seen: Value = serde_json::from_str(&seen).unwrap();

    assert!(seen["machine"].as_str().unwrap().starts_with("A CPU (First model)"), "{seen}");
    let first = &seen["first"];
    assert_eq!(first["titles"], json!(["spheres: Mrays/s", "cornell: Mrays/s"]));
    let legend: Vec<&str> =
        first["legend"].as_array().unwrap().iter().map(|label| label.as_str().unwrap()).collect();
    assert_eq!(
        legend,
        ["commit", "scalar, 1 thread", "wavefront, 1 thread", "commit", "wavefront, 2 threads"]
    );
    let rows = first["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 1, "{rows:?}");
    for word in ["c4ffee0", "spheres", "wavefront", "0.9"] {
        assert!(rows[0].as_str().unwrap().contains(word), "{word}: {rows:?}");
    }
    assert_eq!(seen["counts"], json!(["c6ffee0sphereswavefront1node visits 0.9800"]));
    let pixels = |of: &str| first[of].as_u64().unwrap();
    assert!(pixels("line") > 300, "the second series must be drawn in its colour: {first}");
    assert!(
        pixels("change") > 2 * pixels("before") + 50,
        "a line must mark the change point: {first}"
    );
    assert_eq!(seen["sections"], json!([2, 2, 1]));
    assert_eq!(seen["withoutCornell"]["titles"], json!(["spheres: Mrays/s"]));
    assert_eq!(seen["withoutScalar"]["legend"], json!(["commit", "wavefront, 1 thread"]));
    assert_eq!(seen["speedup"]["titles"], json!(["spheres: speed relative to scalar"]));
    assert_eq!(seen["second"], json!({ "titles": ["spheres: Mrays/s"], "rows": ["none"] }));
    assert_eq!(seen["none"]["titles"], json!([]));
    let point = seen["point"].as_str().unwrap();
    let command = "[ -d ../ptfast-c4ffee0123456 ] || git worktree add ../ptfast-c4ffee0123456 c4ffee0123456\n\
                   (cd ../ptfast-c4ffee0123456 && RUSTFLAGS='</script><b>' cargo build --release --target-dir target)\n\
                   cargo run --release -- bench --program ../ptfast-c4ffee0123456/target/release/ptfast \
                   --scene spheres";
    assert!(point.contains(command), "{point}");
    assert_eq!(seen["buttons"], json!([8]), "each point must have a button");
    assert_eq!(
        seen["pressed"],
        json!("spheres, wavefront, 1 thread, commit c0ffee0123456"),
        "{seen}"
    );
}

/// Checks that the tests above can fail.
#[test]
#[ignore = "needs Chromium, which .ci/run installs: cargo test --test program dashboard -- --ignored"]
fn errors_on_a_page_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wrong.html");
    fs::write(&file, "<script>nowhere.to.be.found();</script>").unwrap();
    let (_, console) = browse(&file);
    assert!(console.iter().any(|line| line.contains("nowhere is not defined")), "{console:?}");
}
