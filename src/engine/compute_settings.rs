//! Settings that decide how an image is computed, and never its bits.

use super::{Pin, Plan, PlanChoice};
use crate::accel::TreeQuality;
use crate::error::{Error, Result};
use crate::limits;

/// The engines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// Traces waves of paths stage by stage, with vector instructions.
    #[default]
    Wavefront,
    /// Traces one ray at a time, as the reference.
    Scalar,
}

names! { pub Engine: Wavefront = "wavefront", Scalar = "scalar" }

/// How an image is computed. None of these settings changes a bit of the image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComputeSettings {
    /// The engine.
    pub engine: Engine,
    /// Number of worker threads, 0 for as many as the process may use.
    pub threads: u32,
    /// Whether each thread is pinned to a core.
    pub pin: Pin,
    /// Maximum number of paths of a wave, which a worker of the wavefront engine traces at once; 0
    /// lets the engine choose. A wave is larger only if a single pixel has more paths.
    pub wave_size: u32,
    /// The plan of the wavefront engine.
    pub plan: PlanChoice,
    /// The quality of the trees, if this render is the first of its prepared scene: later ones use the same trees.
    pub trees: TreeQuality,
    /// Whether kernels count their work, which takes some time.
    #[doc(hidden)]
    pub count: bool,
    /// Whether to record a timeline of the workers' activities.
    #[doc(hidden)]
    pub timeline: bool,
}

impl From<Engine> for ComputeSettings {
    /// The default settings with this engine.
    fn from(engine: Engine) -> Self {
        Self { engine, ..Self::default() }
    }
}

impl ComputeSettings {
    /// Checks that all settings are in range.
    ///
    /// # Errors
    /// If a setting is out of range, returns [`Error::Usage`], which names the first such setting.
    pub fn check(&self) -> Result<()> {
        limits::check("wave_size", self.wave_size.max(1), limits::MAX_WAVE)
            .and_then(|()| self.plan.given().map_or(Ok(()), Plan::check))
            .and_then(|()| limits::check("threads", self.threads.max(1), limits::MAX_THREADS))
            .map_err(Error::Usage)
    }
}
