//! Estimates the memory of a render, so that it is checked before anything is allocated.

use super::{ComputeSettings, Event, MOST_EVENTS, pool};
use crate::accel::MAX_CLUSTER;
use crate::error::{Error, Result};
use crate::limits::Limit;
use crate::scene::{LIGHT_BYTES, Scene};

/// Bytes of the program itself.
const PROGRAM: u64 = 16 << 20;
/// Bytes of trees per primitive: up to 180 were measured.
const PRIMITIVE: u64 = 200;
/// Bytes of the tree of a mesh that instances place, besides those of its triangles.
const MESH: u64 = 1400;
/// Bytes per primitive of a cluster while a thread builds its tree: up to 120 were measured.
const BUILD: u64 = 180;
/// Number of paths of the largest waves, usual ones and in trials.
const PATHS: u64 = 1 << 14;
/// Bytes per path of a wave, in scenes with many kinds of materials.
const PATH: u64 = 380;

impl ComputeSettings {
    /// Checks the estimated memory of a render of `scene` against the limit. The film takes `film`
    /// bytes.
    ///
    /// # Errors
    /// If the estimate exceeds the limit, returns [`Error::Usage`], which names the limit.
    pub(crate) fn check_memory(&self, scene: &Scene, film: u64) -> Result<()> {
        let given = self.plan.as_ref().map_or(self.wave_size, |plan| plan.wave_size);
        let threads = pool::threads(self.threads) as u64;
        let paths = PATHS.max(given.into()) * threads;
        let geometry = scene.geometry();
        let primitives = (geometry.elements() + geometry.instances.triangle_count()) as u64;
        let events = if self.timeline { MOST_EVENTS * size_of::<Event>() } else { 0 };
        let memory = PROGRAM
            + geometry.bytes()
            + PRIMITIVE * primitives
            + MESH * geometry.instances.meshes() as u64
            + BUILD * primitives.min(MAX_CLUSTER as u64 * threads)
            + LIGHT_BYTES * u64::from(scene.lights())
            + scene.world().texture_bytes()
            + PATH * paths
            + events as u64
            + film;
        scene.limits().check(Limit::Memory, memory).map_err(Error::Usage)
    }
}
