//! What a finished render is.

use std::time::Instant;

use super::stats::WaveStats;
use super::tally::Tally;
use super::timeline::Event;
use super::unit::UnitEngine;
use crate::image::Image;

/// A finished render.
#[derive(Clone, Debug)]
pub struct Render {
    /// The linear image.
    pub image: Image,
    /// What was traced, and what came of it.
    pub tally: Tally,
    /// What the stages of the wavefront engine did; of the scalar engine, where it is asked to count,
    /// the work of its rays, without times.
    #[doc(hidden)]
    pub waves: WaveStats,
    /// Time of each step.
    pub seconds: Seconds,
    /// What each worker did when, if the settings ask for it; the first two million events.
    #[doc(hidden)]
    pub timeline: Vec<Event>,
}

/// Wall-clock seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Building the acceleration structure and starting the threads.
    pub build: f64,
    /// Finding the plan, and making what its trials need.
    pub plan: f64,
    /// Rendering.
    pub render: f64,
}

impl Seconds {
    /// What it took since `start` to make `engine`.
    pub(super) fn of_build(engine: &dyn UnitEngine, start: Instant) -> Self {
        let plan = engine.plan().map_or(0.0, |(.., seconds)| seconds);
        Self { build: start.elapsed().as_secs_f64() - plan, plan, render: 0.0 }
    }
}
