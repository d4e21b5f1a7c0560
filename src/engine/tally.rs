//! Exact counts of what was rendered, the same for every engine.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::contract::counted;

/// What was traced, and what came of it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tally {
    /// Rays traced.
    pub rays: RayCounts,
    /// How the paths ended.
    pub endings: Endings,
    /// Samples that were not finite, and counted as black.
    pub non_finite: NonFinite,
    /// Samples that were clamped.
    pub clamped: u64,
}

impl Tally {
    /// What a sample of this radiance adds to its pixel, where components above `clamp` are clamped: notes
    /// pixel and sample, `(x, y, sample)`, if it is not finite, and whether it was clamped.
    #[inline]
    pub(super) fn counted(&mut self, radiance: Vec3, clamp: f32, sample: (u32, u32, u32)) -> Vec3 {
        match counted(radiance, clamp) {
            Some((radiance, clamped)) => {
                self.clamped += u64::from(clamped);
                radiance
            }
            None => {
                self.non_finite.note(sample);
                Vec3::ZERO
            }
        }
    }

    /// All numbers in it.
    pub(crate) fn counts(&self) -> impl Iterator<Item = u64> {
        let RayCounts { primary, bounce, shadow } = self.rays;
        let endings = self.endings.each().map(|(_, paths)| paths);
        [primary, bounce, shadow, self.non_finite.count, self.clamped].into_iter().chain(endings)
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.rays.add(other.rays);
        self.endings.add(&other.endings);
        self.non_finite.merge(&other.non_finite);
        self.clamped += other.clamped;
    }
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RayCounts {
    /// From the camera.
    pub primary: u64,
    /// From a surface or out of a medium, for the closest hit.
    pub bounce: u64,
    /// From there to a light.
    pub shadow: u64,
}

impl RayCounts {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.primary + self.bounce + self.shadow
    }

    fn add(&mut self, other: Self) {
        self.primary += other.primary;
        self.bounce += other.bounce;
        self.shadow += other.shadow;
    }
}

/// Samples whose radiance was NaN or infinite.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NonFinite {
    /// How many.
    pub count: u64,
    /// Pixel and sample of the first in the order of the image.
    pub first: Option<(u32, u32, u32)>,
}

impl NonFinite {
    fn note(&mut self, sample: (u32, u32, u32)) {
        self.merge(&Self { count: 1, first: Some(sample) });
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        let order = |&(x, y, sample): &(u32, u32, u32)| (y, x, sample);
        self.first = self.first.into_iter().chain(other.first).min_by_key(order);
    }
}

/// How paths ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Endings {
    /// They left the scene.
    pub background: u64,
    /// At a light.
    pub light: u64,
    /// By a surface that scattered them into itself, or that scatters nothing.
    pub absorbed: u64,
    /// They could add nothing any more: black surfaces and media.
    pub black: u64,
    /// By Russian roulette.
    pub roulette: u64,
    /// At a surface or in a medium, after the last segment that was allowed.
    pub depth: u64,
}

impl Endings {
    /// All paths.
    pub fn total(&self) -> u64 {
        self.each().into_iter().map(|(_, paths)| paths).sum()
    }

    /// Names and numbers.
    pub fn each(&self) -> [(&'static str, u64); 6] {
        let Self { background, light, absorbed, black, roulette, depth } = *self;
        [
            ("background", background),
            ("light", light),
            ("absorbed", absorbed),
            ("black", black),
            ("roulette", roulette),
            ("depth", depth),
        ]
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.background += other.background;
        self.light += other.light;
        self.absorbed += other.absorbed;
        self.black += other.black;
        self.roulette += other.roulette;
        self.depth += other.depth;
    }
}
