//! `ptfast render --stats`.

use super::say;
use crate::engine::{Plan, Render, Stage, StageWork, WaveStats};
use crate::error::Result;

/// Prints what a render did, by `plan` if it had one.
pub(super) fn print(render: &Render, plan: Option<&Plan>) -> Result<()> {
    let paths = render.tally.rays.primary as f64;
    let ended: Vec<String> = render
        .tally
        .endings
        .each()
        .into_iter()
        .filter(|(_, ended)| *ended > 0)
        .map(|(name, ended)| format!("{name} {ended} ({:.1}%)", ended as f64 / paths * 100.0))
        .collect();
    say(format_args!("ended   {}", ended.join(", ")))?;
    let Some(plan) = plan else { return Ok(()) };
    let stages = Stage::ALL.map(|stage| (stage, render.waves.stage(stage)));
    let all: f64 = stages.iter().map(|(_, work)| work.seconds).sum();
    for (stage, work) in stages.into_iter().filter(|(_, work)| work.active > 0) {
        say(format_args!(
            "stage   {:<10}{:>9.3} s {:>5.1}%{:>8.2} ns a path, {:.0}% of lanes",
            stage.name(),
            work.seconds,
            work.seconds / all * 100.0,
            work.seconds / paths * 1e9,
            work.occupancy() * 100.0,
        ))?;
    }
    for (number, segment) in (1..).zip(&render.waves.segments) {
        let more = if number as usize == WaveStats::SEGMENTS { "+" } else { " " };
        let (how, extend) = (plan.segment(number), segment.stage(Stage::Extend));
        let connect = segment.stage(Stage::Connect);
        let lanes: Vec<String> = Stage::ALL
            .into_iter()
            .filter(|&stage| segment.stage(stage).active > 0)
            .map(|stage| {
                let occupancy = segment.stage(stage).occupancy();
                format!("{} {:.0}%", stage.name(), occupancy * 100.0)
            })
            .collect();
        say(format_args!(
            "segment {number:>2}{more}{:>12} rays, {:.1}% miss; {}{} {}{}; lanes: {}",
            extend.active,
            segment.misses as f64 / extend.active as f64 * 100.0,
            if how.ordered { "ordered " } else { "" },
            how.closest.name(),
            each(extend),
            match connect.active {
                0 => String::new(),
                rays => format!("; {rays} shadow rays {} {}", how.occluded.name(), each(connect)),
            },
            lanes.join(", "),
        ))?;
    }
    Ok(())
}

/// What a ray takes.
fn each(work: &StageWork) -> String {
    let a_ray = |count: u64| count as f64 / work.active as f64;
    let (nodes, tests) = (a_ray(work.counters.node_visits), a_ray(work.counters.leaf_tests));
    format!(
        "{:.1} ns, {nodes:.2} nodes, {tests:.2} tests each",
        work.seconds / work.active as f64 * 1e9
    )
}
