//! The plan: how rays are traced. It decides the speed and never the image.

use serde::{Deserialize, Serialize};

use super::Prepared;
use crate::accel::Kernel;
use crate::engine::settings::RenderSettings;
use crate::film::Tiles;
use crate::limits;

/// How the wavefront engine works, found by measuring; given back, it repeats a run with the same
/// work and the same counts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Paths that a worker traces at once, 1 to [`limits::MAX_WAVE`].
    pub wave_size: u32,
    /// Side of the tiles that work is handed out in, 1 to [`limits::MAX_SIDE`].
    pub tile_size: u32,
    /// Of segments 1, 2, …; the last holds for all that follow.
    pub segments: Vec<SegmentPlan>,
}

/// How the rays of a segment are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentPlan {
    /// Whether rays that start near each other and go the same way are put together first. Camera
    /// rays are anyway.
    pub ordered: bool,
    /// Finds their closest hits.
    pub closest: Kernel,
    /// Finds whether the shadow rays from there are occluded.
    pub occluded: Kernel,
}

/// Paths of a wave: with fewer the last segments have too few, with more they leave the caches.
const USUAL_WAVE: u32 = 1 << 14;
/// So that threads end at about the same time.
const LEAST_TILES_A_THREAD: u64 = 4;

impl Plan {
    /// The plan of segment number `segment`, from 1.
    pub fn segment(&self, segment: u32) -> &SegmentPlan {
        let last = self.segments.len() - 1;
        &self.segments[last.min(segment as usize - 1)]
    }

    /// `Err` says which number is out of range.
    ///
    /// # Errors
    /// Where one is.
    pub fn check(&self) -> Result<(), String> {
        limits::check("wave_size", self.wave_size, limits::MAX_WAVE)?;
        limits::check("tile_size", self.tile_size, limits::MAX_SIDE)?;
        limits::check("number of segments", self.segments.len() as u32, limits::MAX_DEPTH)
    }

    /// What is mostly best for so many primitives, on so many threads.
    pub(super) fn usual(prepared: &Prepared<'_>, threads: usize) -> Self {
        let primitives = prepared.scene.geometry().len();
        let [first, later] = match primitives {
            0..20 => [Kernel::Flat, Kernel::Flat],
            20..0x4000 => [Kernel::Beam, Kernel::Packet],
            _ => [Kernel::Beam, Kernel::Single],
        };
        let ordered = later == Kernel::Packet;
        let settings = &prepared.settings;
        let wave_size = if settings.wave_size == 0 { USUAL_WAVE } else { settings.wave_size };
        Self {
            wave_size,
            tile_size: tile_size(settings, wave_size, threads),
            segments: vec![
                SegmentPlan { ordered: false, closest: first, occluded: later },
                SegmentPlan { ordered, closest: later, occluded: later },
            ],
        }
    }
}

/// The side of tiles that have enough paths for a wave.
pub(super) fn tile_size(settings: &RenderSettings, wave_size: u32, threads: usize) -> u32 {
    let RenderSettings { width, height, spp, tile_size, .. } = *settings;
    if tile_size != 0 {
        return tile_size;
    }
    let mut side = 16;
    while side < 256 && side * side * spp.min(wave_size) < wave_size {
        side *= 2;
    }
    let least = LEAST_TILES_A_THREAD * threads as u64;
    while side > 1 && Tiles::new(width, height, side).count() < least {
        side /= 2;
    }
    side
}
