//! Estimates the memory of a render, so that it is checked before anything is allocated.

use std::ops::Range;

use super::{ComputeSettings, Event, ImageSettings, MOST_EVENTS, pool};
use crate::accel::MAX_CLUSTER;
use crate::error::{Error, Result};
use crate::film::{COLOR, Film};
use crate::limits::Limit;
use crate::scene::{LIGHT_BYTES, Scene};
use crate::simd::LANES;

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

/// Bytes per path of a wave with layers, besides 4 per channel: parts of light, and padding to whole vectors.
const LAYERS: u64 = 26 + 4 * LANES as u64;

/// A film, whose memory is estimated.
pub(crate) struct FilmOf<'a>(pub(crate) &'a ImageSettings, pub(crate) Range<u32>);

impl FilmOf<'_> {
    /// Bytes of the film and, for its layers, of `paths` paths; and the layers' share of both.
    fn bytes(&self, paths: u64) -> (u64, u64) {
        let Self(settings, samples) = self;
        let film = |channels| Film::memory(settings.image(), samples.clone(), channels);
        let channels = settings.stored_layers().channels();
        let waves = if channels > COLOR { paths * (LAYERS + 4 * channels as u64) } else { 0 };
        // The layers of the image.
        let image = 12 * settings.layers.iter().count() as u64 * settings.image().pixels();
        let all = film(channels) + waves + image;
        (all, all - film(COLOR))
    }
}

impl ComputeSettings {
    /// Checks the estimated memory of a render of `scene` against the limit, with its film if there is one yet.
    ///
    /// # Errors
    /// If the estimate exceeds the limit, returns [`Error::Usage`], which names the limit.
    pub(crate) fn check_memory(&self, scene: &Scene, film: Option<FilmOf<'_>>) -> Result<()> {
        let given = self.plan.given().map_or(self.wave_size, |plan| plan.wave_size);
        let threads = pool::threads_for(self.threads) as u64;
        let paths = PATHS.max(given.into()) * threads;
        let geometry = scene.geometry();
        let primitives = geometry.all_primitives();
        let events = if self.timeline { MOST_EVENTS * size_of::<Event>() } else { 0 };
        let (film, layers) = film.map_or((0, 0), |film| film.bytes(paths));
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
        scene.limits().check(Limit::Memory, memory).map_err(|message| match layers {
            0 => Error::Usage(message),
            _ => Error::Usage(format!(
                "{message} (layers: {})",
                Limit::Memory.amount(layers, f64::ceil)
            )),
        })
    }
}
