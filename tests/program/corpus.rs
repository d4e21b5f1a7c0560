//! Runs the fuzz subjects on the corpora of `tests/fuzz` and on random variations of them.
//!
//! This looks for the same faults as cargo-fuzz, but works with any toolchain and is short enough to run as a test.

#[path = "../fuzz/subjects.rs"]
mod subjects;

use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

use ptfast::internals::Stream;

/// Least number of runs per subject.
const RUNS: usize = 2000;

/// Returns `bytes` with a few changed, removed, repeated, or replaced by a part of `other`.
fn varied(bytes: &[u8], other: &[u8], random: &mut Stream) -> Vec<u8> {
    let mut varied = bytes.to_vec();
    for _ in 0..1 + random.bits() % 4 {
        let mut below = |end: usize| (random.bits() % (end as u64).max(1)) as usize;
        let at = below(varied.len() + 1);
        let length = below(8).min(varied.len() - at);
        match below(6) {
            0 if at < varied.len() => varied[at] ^= 1 << below(8),
            1 if at < varied.len() => varied[at] = b"0123456789-+.eE\"(){}[],:\0\xff"[below(26)],
            2 => drop(varied.drain(at..at + length)),
            3 => {
                let part = varied[at..at + length].to_vec();
                varied.splice(at..at, part.repeat(1 + below(20)));
            }
            4 => {
                let from = below(other.len() + 1);
                let part = &other[from..(from + below(64)).min(other.len())];
                varied.splice(at..at + length, part.iter().copied());
            }
            _ => varied.truncate(at.max(1)),
        }
    }
    varied
}

/// cargo-fuzz needs one program and one manifest entry per subject.
#[test]
fn each_subject_is_a_target() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz");
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    for (name, _) in subjects::ALL {
        let target = fs::read_to_string(folder.join(format!("targets/{name}.rs"))).unwrap();
        assert!(target.contains(&format!("|bytes: &[u8]| subjects::{name}(bytes)")), "{name}");
        assert!(manifest.contains(&format!("path = \"targets/{name}.rs\"")), "{name}");
    }
    assert_eq!(fs::read_dir(folder.join("targets")).unwrap().count(), subjects::ALL.len());
}

#[test]
fn corpora_and_their_variations_run_without_faults() {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus");
    let found = tempfile::tempdir().unwrap().keep();
    let mut faults = Vec::new();
    for (name, subject) in subjects::ALL {
        let mut files: Vec<PathBuf> = fs::read_dir(corpora.join(name))
            .unwrap_or_else(|error| panic!("{name}: {error}"))
            .map(|entry| entry.unwrap().path())
            .collect();
        files.sort();
        let corpus: Vec<Vec<u8>> = files.iter().map(|file| fs::read(file).unwrap()).collect();
        assert!(corpus.len() >= 3, "{name} needs a corpus of at least 3 files");
        let mut random = Stream::new(7);
        let mut run = |bytes: &[u8]| {
            if catch_unwind(|| subject(bytes)).is_err() {
                let file = found.join(format!("{name}-{}", faults.len()));
                fs::write(&file, bytes).unwrap();
                faults.push(file);
            }
        };
        corpus.iter().for_each(|bytes| run(bytes));
        for _ in corpus.len()..RUNS {
            let [bytes, other] =
                [0; 2].map(|_| &corpus[(random.bits() % corpus.len() as u64) as usize]);
            run(&varied(bytes, other, &mut random));
        }
        println!("{name}: {} files", corpus.len());
    }
    assert!(faults.is_empty(), "{faults:?}");
    fs::remove_dir(found).unwrap();
}
