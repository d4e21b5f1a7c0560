//! `ptfast render --stats`.

use super::say;
use crate::engine::{Render, Stage};
use crate::error::Result;

/// Prints what a render did.
pub(super) fn print(render: &Render) -> Result<()> {
    for (name, paths) in render.endings.each() {
        say(format_args!("ended   {paths:>12} {name}"))?;
    }
    let paths = render.rays.primary as f64;
    for stage in Stage::ALL {
        let work = render.waves.stage(stage);
        say(format_args!(
            "stage   {:10} {:8.3} s {:8.2} ns a path {:6.1}% of lanes",
            stage.name(),
            work.seconds,
            work.seconds / paths * 1e9,
            work.active as f64 / work.issued as f64 * 100.0
        ))?;
    }
    for (segment, works) in (1..).zip(&render.waves.segments) {
        let work = |stage: Stage| works[stage as usize];
        let extend = work(Stage::Extend);
        say(format_args!(
            "segment {segment:2} {:>12} rays {:8.2} ns extend {:6.2} sort {:6.2} shade",
            extend.active,
            extend.seconds / extend.active as f64 * 1e9,
            work(Stage::Sort).seconds / extend.active as f64 * 1e9,
            work(Stage::Shade).seconds / extend.active as f64 * 1e9,
        ))?;
    }
    Ok(())
}
