//! Exact counts of rays, path endings and unusual samples, identical for all engines.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::counted;

/// Counts of rays, path endings, and samples that were non-finite or clamped.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tally {
    /// Numbers of traced rays.
    pub rays: RayCounts,
    /// Numbers of paths by how they ended.
    pub endings: Endings,
    /// Non-finite samples, which are replaced by black.
    pub non_finite: NonFinite,
    /// Number of clamped samples.
    pub clamped: u64,
}

impl Tally {
    /// Returns the radiance that a sample adds to its pixel: `radiance`, scaled down if a component
    /// exceeds `clamp`, or black if it is non-finite. Counts clamped and non-finite samples.
    /// `sample` is `(x, y, sample)`.
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

    /// All counts.
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

/// Numbers of rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RayCounts {
    /// Rays from the camera.
    pub primary: u64,
    /// Rays from a surface or from within a medium, traced for the closest hit.
    pub bounce: u64,
    /// Rays from a surface or from within a medium to a light.
    pub shadow: u64,
}

impl RayCounts {
    /// Number of all rays.
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
    /// Number of these samples.
    pub count: u64,
    /// Pixel and sample, `(x, y, sample)`, of the first one in image order.
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

/// Numbers of paths by how they ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Endings {
    /// Paths that left the scene.
    pub background: u64,
    /// Paths that hit a light.
    pub light: u64,
    /// Paths that a surface absorbed, because it scattered them into itself or not at all.
    pub absorbed: u64,
    /// Paths whose throughput became zero, at black surfaces or in black media.
    pub black: u64,
    /// Paths that Russian roulette terminated.
    pub roulette: u64,
    /// Paths that hit a surface or a medium at the end of the last allowed segment.
    pub depth: u64,
}

impl Endings {
    /// Number of all paths.
    pub fn total(&self) -> u64 {
        self.each().into_iter().map(|(_, paths)| paths).sum()
    }

    /// The name and count of each ending.
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
