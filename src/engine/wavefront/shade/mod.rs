//! Shade: a routine a kind of material, over the paths that have hit it.

mod color;
mod conductor;
mod dielectric;
mod diffuse;
mod direct;
mod emit;
mod metal;
mod phase;
mod rough_dielectric;
mod scatter;
mod vertex;

use super::cells::Cells;
use super::connect::Shadows;
use super::light::LightTable;
use super::materials::{Bin, Kind, Materials};
use super::order::Next;
use super::paths::Paths;
use super::sort::Queues;
use crate::engine::settings::RenderSettings;
use crate::engine::stats::StageWork;
use crate::engine::tally::Endings;
use crate::geometry::lanes::Surfaces;
use crate::scene::{Fresnel, Scene};
use crate::simd::LANES;
use conductor::Conductor;
use dielectric::Dielectric;
use diffuse::Diffuse;
use metal::Metal;
use phase::Media;
use rough_dielectric::RoughDielectric;

/// What all paths of a stage share.
#[derive(Clone, Copy)]
pub(super) struct Shading<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a RenderSettings,
    pub(super) materials: &'a Materials,
    pub(super) lights: &'a LightTable,
    pub(super) surfaces: &'a Surfaces,
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
    /// Shades the queues of all bins. Returns how many paths it took, and in how many lanes.
    #[inline(never)]
    pub(super) fn shade(&self, queues: &Queues, shaded: &mut Shaded<'_>) -> StageWork {
        shaded.next.clear();
        shaded.shadows.clear();
        let (mut paths, mut lanes) = (0, 0);
        for (&bin, queue) in self.materials.bins.iter().zip(queues.iter()) {
            match bin {
                Bin::Background => self.background(queue, shaded),
                Bin::Surface(shape, Kind::Light) => self.light(shape, queue, shaded),
                // The path's last segment: nothing it would scatter to is traced.
                _ if self.segment == self.settings.depth => {
                    shaded.endings.depth += queue.len() as u64;
                    continue;
                }
                Bin::Medium => self.scatter(None, queue, shaded, &Media),
                Bin::Surface(shape, Kind::Diffuse(pattern)) => {
                    self.scatter_colored::<Diffuse<false>>(pattern, shape, queue, shaded);
                }
                Bin::Surface(shape, Kind::Lambertian(pattern)) => {
                    self.scatter_colored::<Diffuse<true>>(pattern, shape, queue, shaded);
                }
                Bin::Surface(shape, Kind::Metal(pattern)) => {
                    self.scatter_colored::<Metal>(pattern, shape, queue, shaded);
                }
                Bin::Surface(shape, Kind::Dielectric(Fresnel::Schlick)) => {
                    self.scatter(Some(shape), queue, shaded, &Dielectric::<false>);
                }
                Bin::Surface(shape, Kind::Dielectric(Fresnel::Exact)) => {
                    self.scatter(Some(shape), queue, shaded, &Dielectric::<true>);
                }
                Bin::Surface(shape, Kind::RoughDielectric) => {
                    self.scatter(Some(shape), queue, shaded, &RoughDielectric);
                }
                Bin::Surface(shape, Kind::Conductor) => {
                    self.scatter(Some(shape), queue, shaded, &Conductor);
                }
            }
            paths += queue.len();
            lanes += queue.len().next_multiple_of(LANES);
        }
        StageWork::in_lanes(paths, lanes)
    }
}
