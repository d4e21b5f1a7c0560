//! Tests of `--denoise` and `ptfast denoise`.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{ptfast, stderr, stdout};

const SMALL: [&str; 8] = ["render", "cornell", "--width", "60", "--spp", "4", "-q", "-o"];

/// Runs the program, and returns what it prints.
fn run(here: &Path, words: &[&str]) -> String {
    let output = ptfast(here, words);
    assert!(output.status.success(), "{words:?}: {}", stderr(&output));
    stdout(&output)
}

fn with<'a>(words: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [words, more].concat()
}

/// The hash in the line that begins with `name`.
fn line<'a>(text: &'a str, name: &str) -> &'a str {
    let line = text.lines().find_map(|line| line.strip_prefix(name));
    line.unwrap_or_else(|| panic!("no line {name} in {text}")).trim()
}

fn identical(here: &Path, a: &str, b: &str) -> bool {
    ptfast(here, &["compare", a, b]).status.success()
}

#[test]
fn renders_merges_and_files_are_denoised_alike() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here, &with(&SMALL, &["noisy.exr"]));
    let hashes = ["--print", "hashes", "--json", "record.json"];
    let printed = run(here, &with(&with(&SMALL, &["a.exr", "--denoise"]), &hashes));
    // The hash is that of the undenoised image, which the file still has.
    let noisy = run(here, &with(&SMALL, &["other.exr", "--print", "hash"]));
    assert_eq!(line(&printed, "color "), noisy.trim());
    assert!(identical(here, "a.exr:noisy", "noisy.exr"));
    let record = fs::read_to_string(here.join("record.json")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    assert_eq!(record["denoised_hash"], line(&printed, "denoised "));
    assert!(record["seconds"]["denoise"].as_f64().unwrap() > 0.0);
    // Layers that only denoising needs are not written.
    assert!(!printed.contains("albedo"), "{printed}");

    // The same from a film in two shards, and from a file with layers.
    let layers = ["--layers", "halves,albedo,normal,depth", "--first-hit", "through"];
    for (name, shard) in [("0.film", "0/2"), ("1.film", "1/2")] {
        run(here, &with(&with(&SMALL, &[name, "--shard", shard]), &layers));
    }
    for quality in ["fast", "good"] {
        let flag = format!("--denoise={quality}");
        let printed = run(here, &with(&SMALL, &["b.exr", &flag, "-j", "1", "--print", "hashes"]));
        let wanted = line(&printed, "denoised ").to_owned();
        let merged = run(here, &["merge", "0.film", "1.film", "-o", "c.png", &flag]);
        assert_eq!(line(&merged, "denoised "), wanted, "{quality}");
        run(here, &with(&with(&SMALL, &["layers.exr"]), &layers));
        let words = ["denoise", "layers.exr", "-o", "d.exr", "--quality", quality, "-j", "2"];
        assert_eq!(line(&run(here, &words), "denoised "), wanted, "{quality}");
        // What was denoised can be denoised again, from what it was before.
        assert!(identical(here, "d.exr", "b.exr"), "{quality}");
        assert!(identical(here, "d.exr:noisy", "noisy.exr"), "{quality}");
    }
}

#[test]
fn complete_denoised_pictures_are_skipped() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for name in ["a.exr", "a.png"] {
        let words = with(&SMALL, &[name, "--denoise", "--skip-complete"]);
        run(here, &words);
        let before = fs::metadata(here.join(name)).unwrap().modified().unwrap();
        run(here, &words);
        let more = with(&SMALL, &[name, "--denoise", "--skip-complete", "--layers", "depth"]);
        let now = || fs::metadata(here.join(name)).unwrap().modified().unwrap();
        assert_eq!(now(), before, "{name} was rendered again");
        run(here, &more);
        assert_ne!(now(), before, "{name} has another layer");
        run(here, &words);
        let before = now();
        run(here, &with(&SMALL, &[name, "--denoise=fast", "--skip-complete"]));
        assert_ne!(now(), before, "{name} has another quality");
    }
}

#[test]
fn what_cannot_be_denoised_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let one = ["render", "cornell", "--width", "20", "--spp", "1", "-o", "a.png", "--denoise"];
    for (words, wanted) in [
        (with(&SMALL, &["a.film", "--denoise"]), "ptfast merge --denoise"),
        (with(&SMALL, &["a.film", "--denoise", "--shard", "0/2"]), "ptfast merge --denoise"),
        (one.to_vec(), "--denoise=fast"),
        (with(&SMALL, &["a.png", "--denoise=best"]), "good"),
        (vec!["denoise", "missing.exr", "-o", "b.png"], "missing.exr"),
    ] {
        let output = ptfast(here, &words);
        assert!(!output.status.success(), "{words:?}");
        let error = stderr(&output);
        assert!(error.trim().lines().count() == 1 && error.contains(wanted), "{words:?}: {error}");
    }
    run(here, &with(&SMALL, &["plain.exr"]));
    let words = ["denoise", "plain.exr", "-o", "b.png", "--quality", "good"];
    let output = ptfast(here, &words);
    assert!(!output.status.success() && stderr(&output).contains("color_even"));
    run(here, &with(&SMALL, &["part.film"]));
    let output = ptfast(here, &["merge", "part.film", "-o", "b.png", "--denoise"]);
    assert!(!output.status.success() && stderr(&output).contains("--layers halves"));
    assert!(!here.join("a.png").exists() && !here.join("b.png").exists());
    run(here, &with(&SMALL, &["own.exr", "--denoise"]));
    let before = fs::read(here.join("own.exr")).unwrap();
    let output = ptfast(here, &["denoise", "own.exr:noisy", "-o", "own.exr"]);
    assert!(!output.status.success() && before == fs::read(here.join("own.exr")).unwrap());
    run(here, &["merge", "part.film", "-o", "c.png", "--denoise=fast"]);
    // Without layers, `fast` still works, and says what would help.
    let output = ptfast(here, &["denoise", "plain.exr", "-o", "b.png"]);
    assert!(output.status.success() && stderr(&output).contains("albedo"), "{}", stderr(&output));
    // One sample is enough for it.
    let mut words = one.to_vec();
    words[8] = "--denoise=fast";
    run(here, &words);
}

#[test]
fn crops_filters_and_unfinished_parts_are_denoised() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // Pixels far from the border of a crop have the values of the whole.
    let crop = with(&SMALL, &["crop.exr", "--denoise=fast", "--crop", "10,10,50,40"]);
    run(here, &crop);
    run(here, &with(&SMALL, &["whole.exr", "--denoise=fast"]));
    let [whole, crop] = ["whole.exr", "crop.exr"].map(|name| ptfast::Image::read(&here.join(name)));
    let (whole, crop) = (whole.unwrap(), crop.unwrap());
    let at =
        |image: &ptfast::Image, x: u32, y: u32| image.pixels()[(y * image.width() + x) as usize];
    assert_eq!((crop.width(), crop.height()), (40, 30));
    let near =
        |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.02 * b + 0.002);
    for (x, y) in [(15, 12), (20, 15), (31, 21)] {
        let (of_crop, of_whole) = (at(&crop, x, y), at(&whole, x + 10, y + 10));
        assert!(near(of_crop, of_whole), "{x}, {y}: {of_crop:?} is not {of_whole:?}");
    }
    // A filter with negative weights.
    let shown = run(here, &["scenes", "show", "cornell"]);
    let scene = shown.replace("vfov: 40.0,", "vfov: 40.0, filter: mitchell(),");
    assert_ne!(scene, shown);
    fs::write(here.join("mitchell.ron"), scene).unwrap();
    let mut words = with(&SMALL, &["mitchell.exr", "--denoise"]);
    words[1] = "mitchell.ron";
    run(here, &words);
    let mitchell = ptfast::Image::read(&here.join("mitchell.exr")).unwrap();
    assert!(mitchell.pixels().iter().flatten().all(|x| *x >= 0.0 && x.is_finite()));
    let noisy = ptfast::Image::read(&here.join("mitchell.exr:noisy")).unwrap();
    assert!(noisy.pixels().iter().flatten().any(|x| *x < 0.0));
    // One of two parts.
    let layers = ["--layers", "halves,albedo,normal,depth", "--shard", "0/2"];
    run(here, &with(&with(&SMALL, &["part.film"]), &layers));
    run(here, &["merge", "part.film", "--partial", "-o", "part.exr", "--denoise"]);
    let noisy = ptfast::Image::read(&here.join("part.exr:noisy")).unwrap();
    assert_ne!(ptfast::Image::read(&here.join("part.exr")).unwrap().pixels(), noisy.pixels());
}

#[test]
fn goals_and_denoising_go_together() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let goal = ["render", "cornell", "--width", "60", "--json", "a.json", "-o", "a.png"];
    let said = |more: &[&str]| {
        let output = ptfast(here, &with(&goal, more));
        assert!(output.status.success(), "{more:?}: {}", stderr(&output));
        let record: Value =
            serde_json::from_str(&fs::read_to_string(here.join("a.json")).unwrap()).unwrap();
        (record, stderr(&output))
    };
    // A denoised picture needs fewer samples for the same error.
    let (noisy, hint) = said(&["--noise", "9%"]);
    assert!(hint.contains("--denoise would lower"), "{hint}");
    let (denoised, hint) = said(&["--noise", "9%", "--denoise"]);
    assert!(!hint.contains("--denoise"), "{hint}");
    let samples = |record: &Value| record["spp"].as_u64().unwrap();
    assert!(samples(&denoised) < samples(&noisy));
    assert!(denoised["noise"].as_f64().unwrap() <= 0.09);
    // With a clean picture, there is nothing to say.
    let (clean, hint) = said(&["--noise", "2.9%"]);
    assert!(!hint.contains("--denoise") && samples(&clean) > samples(&noisy), "{hint}");
    // The picture has the samples that fit in the time, and is that of so many samples.
    let (timed, _) = said(&["--time", "300ms", "--denoise=fast"]);
    let spp = samples(&timed).to_string();
    let (again, _) = said(&["--spp", &spp, "--denoise=fast"]);
    assert_eq!(timed["denoised_hash"], again["denoised_hash"]);
}

#[test]
fn damaged_files_with_layers_give_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let layers = ["--layers", "halves,albedo,normal,depth", "--first-hit", "through"];
    run(here, &with(&with(&SMALL, &["whole.exr"]), &layers));
    let whole = fs::read(here.join("whole.exr")).unwrap();
    let mut refused = 0;
    // Cut off, and with other bytes in the header and in the pixels.
    let cuts = [8, whole.len() / 2, whole.len() - 1].map(|end| whole[..end].to_vec());
    let changed = (0..12).map(|k| {
        let mut bytes = whole.clone();
        let at = if k < 6 { 9 + 61 * k } else { whole.len() * k / 12 };
        bytes[at..at + 4].fill(0xFF);
        bytes
    });
    for (k, bytes) in cuts.into_iter().chain(changed).enumerate() {
        fs::write(here.join("damaged.exr"), bytes).unwrap();
        let output = ptfast(here, &["denoise", "damaged.exr", "-o", "out.png"]);
        if output.status.success() {
            fs::remove_file(here.join("out.png")).unwrap();
            continue;
        }
        refused += 1;
        let error = stderr(&output);
        let errors = error.lines().filter(|line| !line.contains("lacks the layers")).count();
        assert!(errors == 1 && error.contains("damaged.exr"), "{k}: {error}");
        assert!(!here.join("out.png").exists(), "{k}");
    }
    assert!(refused >= 5, "only {refused} files were refused");
}
