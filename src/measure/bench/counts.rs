//! Compares the exact counts of two records.

use super::{Record, Run, Workload};
use crate::accel::Counters;

/// Result of comparing the counts of two records.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CountChanges {
    /// Number of runs whose counts can be compared: same work, same plan, same number of lanes.
    pub(crate) compared: usize,
    /// Number of runs whose counts cannot be compared.
    pub(crate) others: usize,
    /// One line for each count that differs.
    pub(crate) lines: Vec<String>,
}

/// Compares the counts of `record` with those of the runs `old`, which were counted with `lanes` lanes.
pub(crate) fn count_changes(record: &Record, old: &[Run], lanes: u32) -> CountChanges {
    let mut changes = CountChanges::default();
    for run in &record.runs {
        let alike = |old: &&Run| {
            old.work.is_like(&run.work)
                && old.plan == run.plan
                && lanes == record.machine.lanes
                && old.counters != Counters::default()
        };
        let Some(old) = old.iter().find(alike) else {
            changes.others += 1;
            continue;
        };
        changes.compared += 1;
        let Workload { scene, engine, threads, .. } = &run.work;
        for (name, new, old) in differences(&run.counters, &old.counters) {
            let ratio = new as f64 / old.max(1) as f64;
            changes.lines.push(format!(
                "{scene} {engine} {threads}: {name} {old} -> {new} ({ratio:.4} times as many)"
            ));
        }
    }
    changes
}

/// Returns the counts that differ: name, new value and old value.
fn differences(new: &Counters, old: &Counters) -> impl Iterator<Item = (&'static str, u64, u64)> {
    [
        ("node visits", new.node_visits, old.node_visits),
        ("leaf tests", new.leaf_tests, old.leaf_tests),
        ("lanes issued", new.lanes_issued, old.lanes_issued),
        ("lanes active", new.lanes_active, old.lanes_active),
        ("rays left to scalar", new.scalar_rays, old.scalar_rays),
    ]
    .into_iter()
    .filter(|(_, new, old)| new != old)
}
