//! Russian roulette: the probability with which a path survives, and how `auto` finds it.

use super::{ImageSettings, Layers};
use crate::math::{Real, max_element, min};
use crate::sampler::Sampler;
use crate::scene::{Roulette, Sampling};

/// Rows and samples of the picture whose paths decide the rule of `auto`: some thousand paths.
const ROWS: u32 = 24;
const SAMPLES: u32 = 2;
/// Largest number of segments of its paths.
const DEPTH: u32 = 32;

/// Throughput per mean number of bounces below which `auto` may end paths, and the range of that throughput.
///
/// Ending a path saves its other bounces, and adds variance: the more bounces there are to save, the more that is
/// worth. See `profiling/measured.md`.
const WEIGHT_PER_BOUNCE: f32 = 1.0 / 24.0;
const WEIGHTS: [f32; 2] = [1.0 / 24.0, 0.5];

/// Which paths must survive Russian roulette, and their probability of survival: their throughput divided by
/// `weight`, but at most `most`. Survivors carry on with a throughput of `weight`, or more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Survival {
    /// The first segment that paths reach only if they survive.
    first: u32,
    /// 1 / weight.
    scale: f32,
    most: f32,
}

impl Survival {
    /// All paths survive.
    pub(super) const ALWAYS: Self = Self { first: u32::MAX, scale: 1.0, most: 1.0 };

    /// From segment `first` on, paths survive with a probability of their throughput.
    fn from(first: u32) -> Self {
        Self { first, scale: 1.0, most: 0.95 }
    }

    /// The rule for a scene whose paths have this mean number of bounces.
    pub(super) fn of_bounces(bounces: f32) -> Self {
        let [least, most] = WEIGHTS;
        let weight = (bounces * WEIGHT_PER_BOUNCE).clamp(least, most);
        Self { first: 2, scale: 1.0 / weight, most: 1.0 }
    }

    /// The rule of `roulette`; `None` for `auto`, whose rule depends on the scene.
    pub(super) fn fixed(roulette: Roulette) -> Option<Self> {
        match roulette {
            Roulette::Auto => None,
            Roulette::Off => Some(Self::ALWAYS),
            Roulette::From(first) => Some(Self::from(first)),
        }
    }

    /// Whether a path must survive to reach segment number `segment`.
    #[inline(always)]
    pub(super) fn applies(self, segment: u32) -> bool {
        segment >= self.first
    }

    /// The probability that a path of throughput `beta` survives.
    #[inline(always)]
    pub(super) fn probability<R: Real>(self, beta: R::Vec3) -> R {
        min(max_element(beta) * R::splat(self.scale), R::splat(self.most))
    }
}

/// The settings of the picture whose paths decide the rule of `auto` for `settings`. They do not depend on the seed,
/// and hardly on the number of pixels, by which the aspect of the image is rounded.
pub(super) fn pilot(settings: &ImageSettings) -> ImageSettings {
    let ImageSettings { width, height, .. } = *settings;
    let columns = f64::from(ROWS) * f64::from(width) / f64::from(height);
    ImageSettings {
        width: (columns.round() as u32).clamp(1, 4 * ROWS),
        height: ROWS,
        spp: SAMPLES,
        depth: settings.depth.min(DEPTH),
        seed: 0,
        // Shadow rays decide nothing.
        sampling: Sampling::Bsdf,
        sampler: Sampler::Sobol,
        roulette: Roulette::Off,
        clamp: None,
        transparent: false,
        layers: Layers::default(),
        ..settings.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{ComputeSettings, Engine, Renderer};
    use crate::scene::Scene;

    #[test]
    fn roulette_begins_at_its_segment() {
        let from = Survival::from(3);
        assert_eq!([2, 3, 4].map(|segment| from.applies(segment)), [false, true, true]);
        assert!(!Survival::ALWAYS.applies(crate::limits::MAX_DEPTH));
    }

    /// Paths survive as long as they weigh enough, and the survivors weigh the same.
    #[test]
    fn auto_is_a_threshold() {
        let survival = |bounces: f32, weight: f32| {
            Survival::of_bounces(bounces).probability::<f32>(glam::Vec3::new(0.0, weight, 0.0))
        };
        assert_eq!([0.6, 0.5, 0.25].map(|weight| survival(100.0, weight)), [1.0, 1.0, 0.5]);
        assert_eq!([0.6, 0.25, 0.125].map(|weight| survival(6.0, weight)), [1.0, 1.0, 0.5]);
        assert_eq!(survival(0.0, 1.0 / 48.0), 0.5);
    }

    /// The rule depends neither on the engine, nor on the seed, the size or the threads.
    #[test]
    fn the_rule_of_auto_is_that_of_the_scene_and_its_camera() {
        let scene = Scene::load("cornell").unwrap();
        let base = ImageSettings { roulette: Roulette::Auto, ..ImageSettings::of(&scene) };
        let rule = |settings: ImageSettings, engine, threads| {
            let compute = ComputeSettings { threads, ..ComputeSettings::from(engine) };
            let renderer = Renderer::new(&scene, settings, compute).unwrap();
            renderer.survival()
        };
        let known = rule(base.clone(), Engine::Wavefront, 1);
        let other = ImageSettings { seed: 9, spp: 1, clamp: Some(0.1), ..base.clone() };
        let other = other.with_size(Some(800), None);
        for (settings, engine) in [(base.clone(), Engine::Scalar), (other, Engine::Wavefront)] {
            assert_eq!(rule(settings, engine, 2), known, "{engine:?}");
        }
        let short = rule(ImageSettings { depth: 2, ..base }, Engine::Wavefront, 1);
        assert!(short.scale > known.scale, "{short:?} {known:?}");
    }
}
