//! Shell commands that repeat a run.

use crate::measure::bench::{Record, Run, Workload};
use crate::measure::settings::{self, quoted};

/// Command that measures all engines again, so that the result includes the speed-up. It uses the
/// bench of the current checkout, since old commits have no bench.
pub(super) fn bench(record: &Record, run: &Run) -> String {
    format!(
        "{}cargo run --release -- bench --program {}/target/release/ptfast {} --blocks {}",
        build(record),
        folder(record),
        work(&run.work),
        run.blocks.len()
    )
}

/// Command that renders the image once.
pub(super) fn render(record: &Record, run: &Run) -> String {
    let Workload { scene, engine, threads, settings, .. } = &run.work;
    format!(
        "{}{}/target/release/ptfast render --scene {} --threads {threads} --engine {} {}",
        build(record),
        folder(record),
        quoted(scene),
        quoted(engine),
        settings::flags(settings, |_| true)
    )
}

/// Commands that build the commit with its original flags in a worktree next to the checkout.
fn build(record: &Record) -> String {
    let (commit, flags) = (&record.machine.commit, &record.machine.flags);
    let changed = if commit.ends_with("-dirty") {
        "# measured with uncommitted changes, which these commands do not include\n"
    } else {
        ""
    };
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

/// The arguments of `ptfast bench`, which has no others for settings.
fn work(Workload { scene, threads, settings, .. }: &Workload) -> String {
    let has = |flag: &str| ["width", "spp", "seed"].contains(&flag);
    format!("--scene {} --threads {threads} {}", quoted(scene), settings::flags(settings, has))
}
