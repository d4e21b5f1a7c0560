//! Connect: traces shadow rays and adds the light of those that are not occluded.

use super::columns::Columns;
use super::extend::trace;
use super::paths::Paths;
use crate::accel::{Accelerator, Counters, HitBatch, Kernel, RayBatch, RayVector};
use crate::simd::{Float, Indices, Int, LANES, Vec3x};

/// Shadow rays, and the light that each one adds if it is not occluded.
#[derive(Debug)]
pub(super) struct Shadows {
    pub(super) rays: RayBatch,
    /// Radiance at the camera (3 columns), and path.
    light: Columns<4>,
}

impl Shadows {
    /// Creates an empty list with room for `capacity` shadow rays.
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self { rays: RayBatch::with_capacity(capacity), light: Columns::with_capacity(capacity) }
    }

    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.light.clear();
    }

    /// Appends the shadow rays of the lanes whose bits are set.
    #[inline(always)]
    pub(super) fn append(&mut self, rays: &RayVector, radiance: Vec3x, paths: &Indices, bits: u32) {
        self.rays.append(rays, bits);
        let [r, g, b] = radiance.0.map(Float::to_bits);
        self.light.append(&[r, g, b, Int::new(*paths.lanes())], bits);
    }
}

/// Traces the shadow rays and adds the light of those that are not occluded. There must be at least
/// one shadow ray. Returns the work of the kernel if `count` is set.
#[inline(never)]
pub(super) fn connect(
    accelerator: &Accelerator,
    kernel: Kernel,
    shadows: &mut Shadows,
    hits: &mut HitBatch,
    paths: &mut Paths,
    count: bool,
) -> Counters {
    let Shadows { rays, light } = shadows;
    let counters = trace(accelerator, kernel, true, rays, hits, count);
    // Pad to whole vectors by repeating the last ray.
    light.pad(0..light.len());
    let last = hits.primitive[rays.len() - 1];
    hits.primitive[rays.len()..].fill(last);
    for first in (0..rays.len()).step_by(LANES) {
        let free = Int::load(&hits.primitive[first..]).eq(Int::splat(HitBatch::MISS));
        let [r, g, b, path] = light.rows(first);
        let light = Vec3x([r, g, b].map(Float::from_bits));
        paths.add_radiance(&paths.indices(path), light, free.bits());
    }
    counters
}
