//! The commands that repeat a run.

use crate::bench::{Record, Run, Workload};

/// Measures all engines again, so that the speed-up is told too. The bench is that of the checkout where
/// it is run, since old commits have none.
pub(super) fn bench(record: &Record, run: &Run) -> String {
    format!(
        "{}cargo run --release -- bench --program {}/target/release/ptfast {} --blocks {}",
        build(record),
        folder(record),
        work(&run.work),
        run.blocks.len()
    )
}

/// Renders the image once.
pub(super) fn render(record: &Record, run: &Run) -> String {
    let Workload { engine, height, depth, sampling, sampler, .. } = &run.work;
    // Old programs have no such option.
    let sampler =
        if sampler.is_empty() { String::new() } else { format!(" --sampler {}", quoted(sampler)) };
    format!(
        "{}{}/target/release/ptfast render {} --height {height} --depth {depth} --engine {} --sampling {}{sampler}",
        build(record),
        folder(record),
        work(&run.work),
        quoted(engine),
        quoted(sampling)
    )
}

/// Builds the commit as it was built, beside the checkout.
fn build(record: &Record) -> String {
    let (commit, flags) = (&record.machine.commit, &record.machine.flags);
    let changed =
        if commit.ends_with("-dirty") { "# and with changes that no commit has\n" } else { "" };
    let (commit, folder) = (quoted(clean(commit)), folder(record));
    format!(
        "{changed}[ -d {folder} ] || git worktree add {folder} {commit}\n\
         (cd {folder} && RUSTFLAGS={} cargo build --release --target-dir target)\n",
        quoted(flags)
    )
}

fn clean(commit: &str) -> &str {
    commit.trim_end_matches("-dirty")
}

fn folder(record: &Record) -> String {
    quoted(&format!("../ptfast-{}", clean(&record.machine.commit)))
}

fn work(work: &Workload) -> String {
    let Workload { scene, threads, width, spp, seed, .. } = work;
    let scene = quoted(scene);
    format!("--scene {scene} --threads {threads} --width {width} --spp {spp} --seed {seed}")
}

/// A word of a shell, whatever it holds.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_they_must_be() {
        assert_eq!(quoted("cloud:1000"), "cloud:1000");
        assert_eq!(quoted("-C target-cpu=native"), "'-C target-cpu=native'");
        assert_eq!(quoted("it's; rm"), "'it'\\''s; rm'");
        assert_eq!(quoted(""), "''");
    }
}
