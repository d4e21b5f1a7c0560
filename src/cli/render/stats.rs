//! `ptfast render --stats`: tables of the work.

use super::plan_file::describe;
use crate::cli::console::say;
use crate::engine::{Plan, Render, SegmentWork, Stage, StageWork, WaveStats};
use crate::error::Result;

/// Prints the work of a render, with its `plan` if it had one.
pub(crate) fn print(render: &Render, plan: Option<&Plan>) -> Result<()> {
    counts(render)?;
    let Some(plan) = plan else { return Ok(()) };
    say(format_args!("{}", describe(plan)))?;
    stages(render)?;
    segments(render, plan)
}

/// Prints the number of rays by kind, and of paths by ending.
fn counts(render: &Render) -> Result<()> {
    let rays = &render.tally.rays;
    say(format_args!(
        "{} rays: {} primary, {} bounce, {} shadow",
        rays.total(),
        rays.primary,
        rays.bounce,
        rays.shadow
    ))?;
    let endings = render.tally.endings.each().into_iter().filter(|&(_, paths)| paths > 0);
    let endings: Vec<String> = endings
        .map(|(name, paths)| format!("{paths} {name} ({:.1}%)", percent(paths, rays.primary)))
        .collect();
    say(format_args!("{} paths ended: {}", render.tally.endings.total(), endings.join(", ")))
}

fn percent(part: u64, of: u64) -> f64 {
    part as f64 / of as f64 * 100.0
}

/// Prints a line per stage. Times are summed over threads.
fn stages(render: &Render) -> Result<()> {
    let (waves, paths) = (&render.waves, render.tally.rays.primary as f64);
    let all = waves.seconds();
    say(format_args!(""))?;
    say(format_args!("stage            ms  share  ns/path    lanes"))?;
    for stage in Stage::ALL {
        let work = waves.stage(stage);
        if work.active > 0 {
            say(format_args!(
                "{:<10}{:>9.1}{:>6.1}%{:>11.2}{:>6.0}%",
                stage.name(),
                work.seconds * 1e3,
                work.seconds / all * 100.0,
                work.seconds / paths * 1e9,
                work.occupancy() * 100.0,
            ))?;
        }
    }
    Ok(())
}

/// Prints a line per segment: how its rays were traced, with counters, and the share of active lanes.
fn segments(render: &Render, plan: &Plan) -> Result<()> {
    say(format_args!(""))?;
    say(format_args!(
        "segment  rays          miss  {TRACE_HEAD}  sort  shade  order  shadow rays   {TRACE_HEAD}"
    ))?;
    for (number, segment) in (1..).zip(&render.waves.segments) {
        let (how, work) = (plan.segment(number), |stage| segment.stage(stage));
        let lanes = |stage| match work(stage).active {
            0 => "-".to_owned(),
            _ => format!("{:.0}%", work(stage).occupancy() * 100.0),
        };
        let line = format!(
            "{number:>2}{:<6} {:<12}{:>5.1}%  {}  {:>4}  {:>5}  {:>5}  {}",
            if number as usize == WaveStats::SEGMENTS { " on" } else { "" },
            work(Stage::Extend).active,
            percent(misses(segment), work(Stage::Extend).active),
            trace(&how.closest_by(), work(Stage::Extend)),
            lanes(Stage::Sort),
            lanes(Stage::Shade),
            lanes(Stage::Order),
            match work(Stage::Connect) {
                StageWork { active: 0, .. } => String::new(),
                work => format!("{:<12}  {}", work.active, trace(&how.occluded_by(), work)),
            },
        );
        say(format_args!("{}", line.trim_end()))?;
    }
    Ok(())
}

fn misses(segment: &SegmentWork) -> u64 {
    segment.endings.background
}

const TRACE_HEAD: &str = "by                  ns  nodes  tests  lanes";

/// The cost of a ray: kernel, time, nodes, tests, and active lanes.
fn trace(by: &str, work: &StageWork) -> String {
    let a_ray = |count: u64| count as f64 / work.active as f64;
    let (nodes, tests) = (a_ray(work.counters.node_visits), a_ray(work.counters.leaf_tests));
    let (ns, lanes) = (work.seconds / work.active as f64 * 1e9, work.occupancy() * 100.0);
    format!("{by:<14} {ns:>7.1} {nodes:>6.2} {tests:>6.2}  {lanes:>4.0}%")
}
