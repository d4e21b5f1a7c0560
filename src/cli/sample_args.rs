//! The arguments that decide a sample.

use clap::{Args, ValueEnum};

use super::limits::LimitArgs;
use super::named::named;
use crate::engine::{Pin, RenderSettings};
use crate::limits::{MAX_DEPTH, MAX_SIDE};
use crate::sampler::Sampler;
use crate::scene::{Sampling, Scene};

/// What decides a sample.
#[derive(Debug, Args)]
pub(super) struct SampleArgs {
    /// Built-in scene (spheres, spacetime, checker, cornell, cloud:N, mesh:N) or path of a .ron,
    /// .json or .txt file
    #[arg(long, value_name = "NAME|FILE")]
    pub(super) scene: String,
    /// Width in pixels [default: the scene's, or in proportion to --height]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SIDE)))]
    pub(super) width: Option<u32>,
    /// Height in pixels [default: the scene's, or in proportion to --width]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SIDE)))]
    pub(super) height: Option<u32>,
    /// Largest number of segments of a path [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_DEPTH)))]
    pub(super) depth: Option<u32>,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
    /// How light is found [default: the scene's, or mis where it has lights, else bsdf]
    #[arg(long, value_name = "SAMPLING", value_parser = named(&Sampling::ALL, Sampling::name))]
    pub(super) sampling: Option<Sampling>,
    /// Where random numbers are from
    #[arg(long, value_name = "SAMPLER", default_value = Sampler::default().name(), value_parser = named(&Sampler::ALL, Sampler::name))]
    pub(super) sampler: Sampler,
    /// Whether paths of little weight end early at random, without bias
    #[arg(long, value_enum, default_value_t = Switch::On)]
    pub(super) roulette: Switch,
    #[command(flatten)]
    pub(super) limits: LimitArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Switch {
    On,
    Off,
}

impl SampleArgs {
    /// The scene's settings where these say nothing.
    pub(super) fn settings(&self, scene: &Scene) -> RenderSettings {
        let defaults = RenderSettings::of(scene).with_size(self.width, self.height);
        RenderSettings {
            depth: self.depth.unwrap_or(defaults.depth),
            seed: self.seed,
            sampling: self.sampling.unwrap_or(defaults.sampling),
            sampler: self.sampler,
            roulette: self.roulette == Switch::On,
            pin: Pin::Auto,
            ..defaults
        }
    }
}
