//! The arguments that decide the value of a sample.

use clap::Args;

use super::{CameraArgs, IMAGE, SceneArg, named};
use crate::engine::ImageSettings;
use crate::error::Result;
use crate::limits::{MAX_DEPTH, MAX_SIDE};
use crate::sampler::Sampler;
use crate::scene::{Roulette, Sampling, Scene};

/// The arguments that decide the value of each sample.
#[derive(Clone, Debug, Args)]
pub(crate) struct SampleArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
    /// Width in pixels [default: the scene's, or in proportion to --height]
    #[arg(long, value_name = "PIXELS", help_heading = IMAGE, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SIDE)))]
    pub(crate) width: Option<u32>,
    /// Height in pixels [default: the scene's, or in proportion to --width]
    #[arg(long, value_name = "PIXELS", help_heading = IMAGE, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SIDE)))]
    pub(crate) height: Option<u32>,
    /// Maximum number of segments of a path [default: the scene's]
    #[arg(long, value_name = "N", help_heading = IMAGE, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_DEPTH)))]
    pub(crate) depth: Option<u32>,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", help_heading = IMAGE, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Sampling of light: by materials, by lights, or both [default: the scene's, or mis if it has lights, else
    /// bsdf]
    #[arg(long, value_name = "SAMPLING", help_heading = IMAGE, value_parser = named(&Sampling::ALL, Sampling::name))]
    pub(crate) sampling: Option<Sampling>,
    /// Source of random numbers
    #[arg(long, value_name = "SAMPLER", help_heading = IMAGE, default_value = Sampler::default().name(), value_parser = named(&Sampler::ALL, Sampler::name))]
    pub(crate) sampler: Sampler,
    /// Russian roulette ends paths of low throughput at random, without bias. N: from this segment on; auto: as it
    /// suits the lengths of the scene's paths [default: the scene's]
    #[arg(long, value_name = "N|off|auto", help_heading = IMAGE, value_parser = roulette)]
    pub(crate) roulette: Option<Roulette>,
}

fn roulette(text: &str) -> std::result::Result<Roulette, String> {
    let parsed = text.parse().ok().filter(|roulette: &Roulette| roulette.check().is_ok());
    parsed.ok_or_else(|| format!("must be auto, off or a number from 1 to {MAX_DEPTH}"))
}

impl SampleArgs {
    /// The size of the picture, if both sides are given.
    pub(crate) fn size(&self) -> Option<(u32, u32)> {
        self.width.zip(self.height)
    }

    /// These settings, and the scene's defaults for the others.
    ///
    /// # Errors
    /// As [`CameraArgs::camera`].
    pub(crate) fn settings(&self, scene: &Scene) -> Result<ImageSettings> {
        let defaults = ImageSettings::of(scene).with_size(self.width, self.height);
        Ok(ImageSettings {
            camera: Some(self.camera.camera(scene)?),
            depth: self.depth.unwrap_or(defaults.depth),
            seed: self.seed,
            sampling: self.sampling.unwrap_or(defaults.sampling),
            sampler: self.sampler,
            roulette: self.roulette.unwrap_or(defaults.roulette),
            ..defaults
        })
    }
}
