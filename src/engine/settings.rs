//! What a render is made of besides its scene.

use crate::error::{Error, Result};
use crate::film::Tile;
use crate::limits::{self, Limit, Limits};
use crate::sampler::Sampler;
use crate::scene::{Camera, Sampling, Scene};

use super::plan::Plan;
use super::pool::Pin;

/// The engines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// Waves of paths, stage by stage, in vectors.
    #[default]
    Wavefront,
    /// The reference: one ray, one loop.
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

/// Settings of a render. Only the first group decides the image.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// The camera.
    pub camera: Camera,
    /// Image width in pixels, 1 to 65 536.
    pub width: u32,
    /// Image height in pixels, 1 to 65 536.
    pub height: u32,
    /// Samples a pixel, 1 to 16 777 216.
    pub spp: u32,
    /// Largest number of segments of a path, 1 to 65 536.
    pub depth: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// How light is found.
    pub sampling: Sampling,
    /// Where random numbers are from.
    pub sampler: Sampler,
    /// Whether paths of little weight end by Russian roulette from segment 5 on.
    pub roulette: bool,
    /// The largest component that a sample may have, above 0: brighter ones are scaled down, which
    /// hides fireflies and loses energy. Infinite for none of that.
    pub clamp: f32,

    /// The engine; the image does not depend on it.
    pub engine: Engine,
    /// Worker threads, 0 for as many as the process may use; the image does not depend on
    /// them.
    pub threads: u32,
    /// Whether the threads stay on one core each.
    pub pin: Pin,
    /// Most paths that a worker of the wavefront engine traces at once, where a pixel's are not more; 0
    /// for what suits it. The image does not depend on it.
    pub wave_size: u32,
    /// How the wavefront engine works, waves included; `None` for its own.
    pub plan: Option<Plan>,
    /// Whether kernels count their work, which costs them some time.
    #[doc(hidden)]
    pub count: bool,
    /// Whether it is kept what each worker did when.
    #[doc(hidden)]
    pub timeline: bool,
    /// How many pixels there may be, and how much memory.
    pub limits: Limits,
}

impl RenderSettings {
    /// The camera and settings that `scene` asks for, seed 1, all threads.
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
            roulette: true,
            clamp: f32::INFINITY,
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

    /// Of this width and height. Where only one is given, the other follows in proportion, rounded.
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

    /// # Errors
    /// [`Error::Usage`] that names the first setting out of range.
    pub fn check(&self) -> Result<()> {
        limits::check_image(self.width, self.height)
            .and_then(|()| self.limits.check(Limit::Pixels, self.image().pixels()))
            .and_then(|()| limits::check_sampling(self.spp, self.depth))
            .and_then(|()| limits::check("wave_size", self.wave_size.max(1), limits::MAX_WAVE))
            .and_then(|()| self.plan.as_ref().map_or(Ok(()), Plan::check))
            .and_then(|()| limits::check("threads", self.threads.max(1), limits::MAX_THREADS))
            .and_then(|()| match self.clamp > 0.0 {
                true => Ok(()),
                false => Err(format!("clamp must be above 0, is {}", self.clamp)),
            })
            .map_err(Error::Usage)
    }

    /// Whether samples with either settings belong to one image. Their number may differ.
    pub(super) fn same_image(&self, other: &Self) -> bool {
        let size =
            |settings: &Self| (settings.width, settings.height, settings.depth, settings.seed);
        let light = |settings: &Self| (settings.sampling, settings.sampler, settings.roulette);
        self.camera == other.camera
            && size(self) == size(other)
            && light(self) == light(other)
            && self.clamp == other.clamp
    }

    /// All pixels.
    #[doc(hidden)]
    pub fn image(&self) -> Tile {
        Tile { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// Paths of the image.
    pub fn paths(&self) -> u64 {
        self.image().pixels() * u64::from(self.spp)
    }

    /// Whether light is looked for by sampling lights.
    pub(super) fn samples_lights(&self, scene: &Scene) -> bool {
        self.sampling != Sampling::Bsdf && scene.lights() > 0
    }
}
