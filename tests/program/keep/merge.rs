//! Parts make the whole.

use std::fs;

use super::{hash, refusal, with};

const SMALL: [&str; 9] =
    ["render", "--scene", "cornell", "--width", "100", "--spp", "50", "--quiet", "-o"];

/// By tiles, by samples, by both, and cropped.
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
            // In another order than they were made.
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
            // A film that was merged is one like any other.
            let again = with(&with(&SMALL, &["again.png", "--resume", "merged.film"]), crop);
            assert_eq!(hash(here, &again), whole);
        }
    }
}

/// Twice, missing, not done, of something else.
#[test]
fn what_makes_no_whole_is_refused() {
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
        (&["0.film"][..], "0.film: sample 0 of pixel 32,0 is in none of these"),
        (&["0.film", "1.film", "0.film"], "0.film: sample 0 of pixel 0,0 is in 0.film, too"),
        (&["0.film", "a.film"], "sample 0 of pixel 0,0 is in 0.film, too"),
        (&["a.film", "b.film"], "a.film, b.film: sample 16 of pixel 0,0 is in none of these"),
        (&["0.film", "other.film"], "other.film: is of a render with seed 2, 0.film of one with 1"),
        (&["0.film", "half.partial.film"], "half.partial.film: is not done, but to "),
        (&["0.film", "none.film"], "none.film: cannot read"),
    ] {
        let code = if why.contains("cannot read") { 74 } else { 65 };
        let says = refusal(here, &with(&["merge", "-o", "m.png"], parts), code);
        assert!(says.contains(why), "{why}: {says}");
    }
    assert!(!here.join("m.png").exists());
    let image = with(&SMALL, &["a.png", "--shard", "0/2"]);
    assert!(refusal(here, &image, 2).contains("a.png: a part of a render makes no image"));
    let over = ["merge", "0.film", "1.film", "-o", "0.film"];
    assert!(refusal(here, &over, 2).contains("would replace a part"));
}
