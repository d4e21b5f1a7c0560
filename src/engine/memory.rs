//! Memory of a render, by estimate: told before it is allocated.

use super::pool;
use super::rendering::MOST_EVENTS;
use super::settings::RenderSettings;
use super::timeline::Event;
use crate::error::{Error, Result};
use crate::limits::Limit;
use crate::scene::{LIGHT_BYTES, Scene};

/// The program itself.
const PROGRAM: u64 = 16 << 20;
/// Bytes for each primitive, trees and their making included: 350 were measured.
const PRIMITIVE: u64 = 400;
/// Paths of the largest waves that are tried.
const PATHS: u64 = 1 << 15;
/// Bytes for each path of a wave where there are many kinds of materials.
const PATH: u64 = 320;

impl RenderSettings {
    /// Refuses a render of `scene` for which there is not enough memory, with a film that takes so many bytes:
    /// the limit is named.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub(crate) fn check_memory(&self, scene: &Scene, film: u64) -> Result<()> {
        let given = self.plan.as_ref().map_or(self.wave_size, |plan| plan.wave_size);
        let paths = PATHS.max(given.into()) * pool::threads(self.threads) as u64;
        let events = if self.timeline { MOST_EVENTS * size_of::<Event>() } else { 0 };
        let memory = PROGRAM
            + PRIMITIVE * scene.geometry().len() as u64
            + LIGHT_BYTES * u64::from(scene.lights())
            + 12 * scene.texels()
            + PATH * paths
            + events as u64
            + film;
        self.limits.check(Limit::Memory, memory).map_err(Error::Usage)
    }
}
