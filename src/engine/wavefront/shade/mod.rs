//! Shade: a routine a kind of material, over the paths that have hit it.

mod color;
mod dielectric;
mod diffuse;
mod direct;
mod emit;
mod metal;
mod scatter;
mod vertex;

use super::cells::Cells;
use super::connect::Shadows;
use super::materials::{Bin, Kind, Materials};
use super::paths::Paths;
use super::rays::Next;
use super::sort::Queue;
use crate::engine::settings::RenderSettings;
use crate::engine::stats::Endings;
use crate::geometry::lanes::Surfaces;
use crate::scene::Scene;

/// What all paths of a stage share.
#[derive(Clone, Copy)]
pub(super) struct Shading<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a RenderSettings,
    pub(super) materials: &'a Materials,
    pub(super) surfaces: &'a Surfaces<'a>,
    pub(super) cells: &'a Cells,
    /// The segment that has been traced, from 1.
    pub(super) segment: u32,
}

/// What comes of shading.
pub(super) struct Shaded<'a> {
    pub(super) paths: &'a mut Paths,
    /// Those that go on.
    pub(super) next: &'a mut Next,
    /// Light that may reach the surfaces.
    pub(super) shadows: &'a mut Shadows,
    /// How the others ended.
    pub(super) endings: &'a mut Endings,
}

impl Shading<'_> {
    /// Shades the queues of all bins.
    pub(super) fn shade(&self, queues: &[Queue], shaded: &mut Shaded<'_>) {
        shaded.next.clear();
        shaded.shadows.clear();
        for (&bin, queue) in self.materials.bins.iter().zip(queues) {
            let (shape, kind) = match bin {
                Bin::Background => {
                    self.background(queue, shaded);
                    continue;
                }
                Bin::Surface(shape, kind) => (shape, kind),
            };
            match kind {
                Kind::Light => self.light(shape, queue, shaded),
                // The path's last segment: nothing it would scatter to is traced.
                _ if self.segment == self.settings.depth => {
                    shaded.endings.depth += queue.len() as u64;
                }
                Kind::Diffuse(pattern) => self.diffuse::<false>(pattern, shape, queue, shaded),
                Kind::Lambertian(pattern) => self.diffuse::<true>(pattern, shape, queue, shaded),
                Kind::Metal(pattern) => self.metal(pattern, shape, queue, shaded),
                Kind::Dielectric => self.dielectric(shape, queue, shaded),
            }
        }
    }
}
