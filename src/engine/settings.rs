//! Settings of a render: the camera, image size, sampling and engine.

use super::backdrop::Backdrop;
use super::plan::Plan;
use super::pool::Pin;
use crate::error::{Error, Result};
use crate::film::Tile;
use crate::limits::{self, Limit, Limits};
use crate::sampler::Sampler;
use crate::scene::{Sampling, Scene};
use crate::shading::Camera;

/// The engines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// Traces waves of paths stage by stage, with vector instructions.
    #[default]
    Wavefront,
    /// Traces one ray at a time, as the reference.
    Scalar,
}

impl Engine {
    /// All engines.
    pub const ALL: [Self; 2] = [Self::Wavefront, Self::Scalar];

    /// The name on the command line and in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wavefront => "wavefront",
            Self::Scalar => "scalar",
        }
    }
}

/// Settings of a render. Only the fields from `camera` to `backdrop` affect the image.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// The camera.
    pub camera: Camera,
    /// Image width in pixels, 1 to 65 536.
    pub width: u32,
    /// Image height in pixels, 1 to 65 536.
    pub height: u32,
    /// Samples per pixel, 1 to 16 777 216.
    pub spp: u32,
    /// Largest number of segments of a path, 1 to 65 536.
    pub depth: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// How paths find light: by scattering, by sampling lights, or by both.
    pub sampling: Sampling,
    /// The source of random numbers.
    pub sampler: Sampler,
    /// First segment that a path reaches only if it survives Russian roulette, 1 to 65 536; `None`
    /// for no roulette. The camera ray is segment 1.
    pub roulette: Option<u32>,
    /// Maximum component of a sample, above 0; infinite to disable clamping. Brighter samples are
    /// scaled down, which hides fireflies and loses energy.
    pub clamp: f32,
    /// What the camera sees behind the scene.
    pub backdrop: Backdrop,

    /// The engine. It does not affect the image.
    pub engine: Engine,
    /// Number of worker threads, 0 for as many as the process may use. It does not affect the
    /// image.
    pub threads: u32,
    /// Whether each thread is pinned to a core.
    pub pin: Pin,
    /// Maximum number of paths of a wave, which a worker of the wavefront engine traces at once; 0
    /// lets the engine choose. A wave is larger only if a single pixel has more paths. The wave
    /// size does not affect the image.
    pub wave_size: u32,
    /// The plan of the wavefront engine, including the wave size; `None` lets the engine choose.
    pub plan: Option<Plan>,
    /// Whether kernels count their work, which takes some time.
    #[doc(hidden)]
    pub count: bool,
    /// Whether to record a timeline of the workers' activities.
    #[doc(hidden)]
    pub timeline: bool,
    /// Limits on the number of pixels and on memory.
    pub limits: Limits,
}

impl RenderSettings {
    /// The camera and default settings of `scene`, with seed 1 and all threads.
    pub fn of(scene: &Scene) -> Self {
        let defaults = scene.defaults();
        Self {
            camera: scene.camera().clone(),
            width: defaults.width,
            height: defaults.height,
            spp: defaults.spp,
            depth: defaults.depth,
            seed: 1,
            sampling: scene.default_sampling(),
            sampler: Sampler::default(),
            roulette: Some(defaults.roulette),
            clamp: f32::INFINITY,
            backdrop: Backdrop::default(),
            engine: Engine::default(),
            threads: 0,
            pin: Pin::default(),
            wave_size: 0,
            plan: None,
            count: false,
            timeline: false,
            limits: scene.limits().clone(),
        }
    }

    /// Sets the width and height. If only one is given, the other is scaled in proportion and
    /// rounded.
    #[must_use]
    pub fn with_size(self, width: Option<u32>, height: Option<u32>) -> Self {
        let scale = |side: u32, by: u32, of: u32| {
            let of = u64::from(of.max(1));
            let scaled = (u64::from(side) * u64::from(by) + of / 2) / of;
            u32::try_from(scaled.max(1)).unwrap_or(u32::MAX)
        };
        let (width, height) = match (width, height) {
            (Some(width), Some(height)) => (width, height),
            (Some(width), None) => (width, scale(width, self.height, self.width)),
            (None, Some(height)) => (scale(height, self.width, self.height), height),
            (None, None) => (self.width, self.height),
        };
        Self { width, height, ..self }
    }

    /// Checks that all settings are in range.
    ///
    /// # Errors
    /// If a setting is out of range, returns [`Error::Usage`], which names the first such setting.
    pub fn check(&self) -> Result<()> {
        limits::check_image(self.width, self.height)
            .and_then(|()| self.limits.check(Limit::Pixels, self.image().pixels()))
            .and_then(|()| limits::check_sampling(self.spp, self.depth, self.roulette))
            .and_then(|()| limits::check("wave_size", self.wave_size.max(1), limits::MAX_WAVE))
            .and_then(|()| self.plan.as_ref().map_or(Ok(()), Plan::check))
            .and_then(|()| limits::check("threads", self.threads.max(1), limits::MAX_THREADS))
            .and_then(|()| match self.clamp > 0.0 {
                true => Ok(()),
                false => Err(format!("clamp must be above 0, is {}", self.clamp)),
            })
            .map_err(Error::Usage)
    }

    /// Whether samples rendered with `self` and with `other` belong to the same image. The numbers
    /// of samples may differ.
    pub(super) fn same_image(&self, other: &Self) -> bool {
        let size =
            |settings: &Self| (settings.width, settings.height, settings.depth, settings.seed);
        let light = |settings: &Self| (settings.sampling, settings.sampler, settings.roulette);
        self.camera == other.camera
            && size(self) == size(other)
            && light(self) == light(other)
            && self.clamp == other.clamp
            && self.backdrop == other.backdrop
    }

    /// The tile of all pixels.
    #[doc(hidden)]
    pub fn image(&self) -> Tile {
        Tile { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// Number of paths of the image.
    pub fn paths(&self) -> u64 {
        self.image().pixels() * u64::from(self.spp)
    }

    /// Whether paths sample the lights of `scene`.
    pub(super) fn samples_lights(&self, scene: &Scene) -> bool {
        self.sampling != Sampling::Bsdf && scene.lights() > 0
    }
}
