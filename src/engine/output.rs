//! The result of a render: its image, counts and times.

use std::time::Instant;

use super::{Event, Tally, UnitEngine, WaveStats};
use crate::image::Image;

/// A finished render.
#[derive(Clone, Debug)]
pub struct Render {
    /// The linear image.
    pub image: Image,
    /// Counts of rays, path endings and samples.
    pub tally: Tally,
    /// The work of the wavefront engine's stages. For the scalar engine, they contain no times,
    /// only counts of the work for its rays, and only if the settings ask for counting.
    #[doc(hidden)]
    pub waves: WaveStats,
    /// The time of each step.
    pub seconds: Seconds,
    /// The activities of all workers, if the settings ask for them. Only the first two million
    /// events are kept.
    #[doc(hidden)]
    pub timeline: Vec<Event>,
}

/// Wall-clock seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Building the acceleration structure and starting the threads.
    pub build: f64,
    /// Finding the plan, including building the trees that its trials need.
    pub plan: f64,
    /// Rendering.
    pub render: f64,
}

impl Seconds {
    /// The times for building `engine`, which began at `start`.
    pub(super) fn of_build(engine: &dyn UnitEngine, start: Instant) -> Self {
        let plan = engine.plan().map_or(0.0, |(.., seconds)| seconds);
        Self { build: start.elapsed().as_secs_f64() - plan, plan, render: 0.0 }
    }
}
