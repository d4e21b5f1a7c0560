//! Connect: the light that reaches surfaces directly.

use super::columns::Columns;
use super::extend::trace;
use super::paths::Paths;
use crate::accel::{Accelerator, Counters, HitBatch, Kernel, RayBatch, RayVector};
use crate::simd::{Float, Indices, Int, LANES, Vec3x};

/// Ways to lights, and what arrives if they are free.
#[derive(Debug)]
pub(super) struct Shadows {
    pub(super) rays: RayBatch,
    /// Radiance at the camera (3), path.
    light: Columns<4>,
}

impl Shadows {
    /// None, and room for `capacity`.
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self { rays: RayBatch::with_capacity(capacity), light: Columns::with_capacity(capacity) }
    }

    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.light.clear();
    }

    /// Adds the lanes whose bits are set.
    #[inline(always)]
    pub(super) fn append(&mut self, rays: &RayVector, radiance: Vec3x, paths: &Indices, bits: u32) {
        self.rays.append(rays, bits);
        let [r, g, b] = radiance.0.map(Float::to_bits);
        self.light.append(&[r, g, b, Int::new(*paths.lanes())], bits);
    }
}

/// Traces the shadow rays, of which there are some, and adds the light of those that nothing occludes.
/// Returns the work, if it is to `count` it.
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
    // Whole vectors: the last ray stands in for those that are missing.
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
