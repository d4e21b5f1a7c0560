//! Tests that merged parts equal the whole render.

use std::fs;

use super::{hash, refusal, with};
use crate::common::stdout;

const SMALL: [&str; 11] = [
    "render", "--scene", "cornell", "--width", "100", "--spp", "50", "--quiet", "--print", "hash",
    "-o",
];

/// Renders in shards and in ranges of samples, of the whole image and of a crop.
#[test]
fn parts_make_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let crop = ["--crop", "7,9,81,95"];
    for crop in [&[][..], &crop] {
        let whole = hash(here, &with(&with(&SMALL, &["whole.png"]), crop));
        for shards in [1, 2, 3, 7, 16] {
            let names: Vec<String> = (0..shards).map(|i| format!("part{i}.film")).collect();
            for (index, name) in names.iter().enumerate() {
                let shard = format!("{index}/{shards}");
                let part = with(&with(&SMALL, &[name, "--shard", &shard]), crop);
                assert!(super::ptfast(here, &part).status.success(), "{part:?}");
            }
            // Merge in reverse order.
            let mut words = vec!["merge", "-o", "merged.png"];
            words.extend(names.iter().rev().map(String::as_str));
            assert_eq!(hash(here, &words), whole, "{shards} shards");
            assert!(
                fs::read(here.join("merged.png")).unwrap()
                    == fs::read(here.join("whole.png")).unwrap()
            );
        }
        for ranges in [&["0..16", "16..50"][..], &["32..48", "48..50", "0..32"]] {
            for (name, range) in ["x.film", "y.film", "z.film"].iter().zip(ranges) {
                let part = with(&with(&SMALL, &[name, "--sample-range", range]), crop);
                assert!(super::ptfast(here, &part).status.success(), "{part:?}");
            }
            let parts = &["x.film", "y.film", "z.film"][..ranges.len()];
            let merged = with(&["merge", "-o", "merged.film"], parts);
            assert_eq!(hash(here, &merged), whole, "{ranges:?}");
            // A merged film can be continued like any other.
            let again = with(&with(&SMALL, &["again.png", "--checkpoint", "merged.film"]), crop);
            assert_eq!(hash(here, &again), whole);
        }
    }
}

/// Alpha and layers of merged and of continued renders have the bytes of one run.
#[test]
fn parts_have_all_layers() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = [
        "render",
        "--scene",
        "spheres",
        "--width",
        "60",
        "--spp",
        "50",
        "--quiet",
        "--transparent",
        "--layers",
        "alpha,albedo,normal,depth,position,uv,direct,indirect,emission,background,instance,material,halves",
        "--first-hit",
        "through",
        "-o",
    ];
    let run = |words: &[&str]| {
        let output = super::ptfast(here, words);
        assert!(output.status.success(), "{words:?}: {output:?}");
    };
    run(&with(&base, &["whole.exr"]));
    let whole = fs::read(here.join("whole.exr")).unwrap();
    for parts in [
        [["--shard", "0/3"], ["--shard", "1/3"], ["--shard", "2/3"]],
        [["--sample-range", "32..50"], ["--sample-range", "0..16"], ["--sample-range", "16..32"]],
    ] {
        let names = ["x.film", "y.film", "z.film"];
        for (name, part) in names.iter().zip(&parts) {
            run(&with(&with(&base, &[name]), part));
        }
        run(&with(&["merge", "-o", "merged.exr"], &names));
        assert!(fs::read(here.join("merged.exr")).unwrap() == whole, "{parts:?}");
        // All samples are finished, so the partial image has all values, but sums are rounded in another order.
        run(&with(&["merge", "--partial", "-o", "partial.exr"], &names));
        let compared = stdout(&super::ptfast(here, &["compare", "partial.exr", "merged.exr"]));
        let layers = compared.lines().filter(|line| line.starts_with("layer "));
        let differences = layers.filter_map(|line| line.split_once("most by ")?.1.split_once(' '));
        for (most, _) in differences {
            assert!(most.parse::<f64>().unwrap() < 1e-4, "{compared}");
        }
        assert!(compared.contains("layer depth") && compared.contains("layer A "), "{compared}");
    }
    run(&["merge", "-o", "b.exr", "x.film", "y.film", "z.film", "--layers", "depth"]);
    let compared = stdout(&super::ptfast(here, &["compare", "b.exr", "merged.exr"]));
    assert!(compared.contains("layer depth      identical"), "{compared}");
    assert!(compared.contains("layer albedo     only in the second image"), "{compared}");
    let says = refusal(
        here,
        &["merge", "-o", "c.exr", "x.film", "y.film", "z.film", "--layers", "samples"],
        2,
    );
    assert!(says.contains("--layers samples: the parts lack this layer"), "{says}");
    let part = with(&with(&base, &["whole2.exr", "--time-limit", "1ms"]), &[]);
    assert_eq!(super::ptfast(here, &part).status.code(), Some(75));
    run(&with(&base, &["whole2.exr"]));
    assert!(fs::read(here.join("whole2.exr")).unwrap() == whole, "continued");
    // Films with other layers belong to other renders.
    run(&[
        "render", "--scene", "spheres", "--width", "60", "--spp", "50", "--quiet", "--shard",
        "0/2", "-o", "x.film",
    ]);
    run(&with(&base, &["y.film", "--shard", "1/2"]));
    let says = refusal(here, &["merge", "-o", "a.exr", "x.film", "y.film"], 65);
    assert!(says.contains("transparent") || says.contains("layers"), "{says}");
}

/// `merge` rejects duplicate, missing, unfinished and foreign parts.
#[test]
fn wrong_sets_of_parts_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let part = |name: &str, more: &[&str]| {
        let words = with(&with(&SMALL, &[name]), more);
        assert!(super::ptfast(here, &words).status.success(), "{words:?}");
    };
    part("0.film", &["--shard", "0/2"]);
    part("1.film", &["--shard", "1/2"]);
    part("a.film", &["--sample-range", "0..16"]);
    part("b.film", &["--sample-range", "32..50"]);
    part("other.film", &["--shard", "1/2", "--seed", "2"]);
    let stopped = with(&SMALL, &["half.film", "--shard", "1/2", "--time-limit", "1ms"]);
    refusal(here, &stopped, 75);
    for (parts, why) in [
        (&["0.film"][..], "0.film: shards are missing: 1/2"),
        (&["0.film", "1.film", "0.film"], "0.film: sample 0 of pixel 0,0 is also in 0.film"),
        (&["0.film", "a.film"], "sample 0 of pixel 0,0 is also in 0.film"),
        (&["a.film", "b.film"], "a.film, b.film: sample 16 of pixel 0,0 is missing"),
        (&["0.film", "other.film"], "other.film: belongs to a render with seed 2, but 0.film"),
        (&["0.film", "half.partial.film"], "half.partial.film: is only "),
        (&["0.film", "none.film"], "none.film: cannot read"),
    ] {
        let code = if why.contains("cannot read") { 74 } else { 65 };
        let says = refusal(here, &with(&["merge", "-o", "m.png"], parts), code);
        assert!(says.contains(why), "{why}: {says}");
    }
    assert!(!here.join("m.png").exists());
    let image = with(&SMALL, &["a.png", "--shard", "0/2"]);
    assert!(
        refusal(here, &image, 2)
            .contains("a.png: --shard and --sample-range render a part of an image")
    );
    let over = ["merge", "0.film", "1.film", "-o", "0.film"];
    assert!(refusal(here, &over, 2).contains("would overwrite a part"));
}
