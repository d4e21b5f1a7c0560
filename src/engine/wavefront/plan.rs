//! The plan: how rays are traced. It decides the speed and never the image.

use serde::{Deserialize, Serialize};

use super::Prepared;
use crate::accel::Kernel;
use crate::engine::settings::RenderSettings;
use crate::film::Tiles;
use crate::limits;

/// How the wavefront engine works: in large renders found by measuring. Given back, it repeats a run
/// with the same work and the same counts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Most paths that a worker traces at once, 1 to [`limits::MAX_WAVE`].
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

/// Where a plan is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planning {
    /// From the settings.
    Given,
    /// What is mostly best, in renders too small to measure anything.
    Usual,
    /// The fastest of some, by a measurement that may end otherwise another time.
    Measured,
}

impl Planning {
    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Usual => "usual",
            Self::Measured => "measured",
        }
    }
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

    /// Most paths of a tile.
    pub(super) fn tile_paths(&self, settings: &RenderSettings) -> u64 {
        u64::from(self.tile_size).pow(2) * u64::from(settings.spp)
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

impl SegmentPlan {
    /// How its closest hits are found, in words.
    pub(crate) fn closest_by(&self) -> String {
        format!("{}{}", if self.ordered { "ordered " } else { "" }, self.closest.name())
    }
}

/// Paths of each wave, but for the last, of a tile of so many: waves of about equal length, since one
/// of a few paths costs as much as a larger one.
pub(super) fn wave_length(tile_paths: u64, wave_size: u32) -> u64 {
    let waves = tile_paths.div_ceil(u64::from(wave_size)).max(1);
    tile_paths.div_ceil(waves).max(1)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_of_a_tile_are_equal() {
        for wave_size in [1, 7, 100, 16_384] {
            for paths in [0, 1, 6, 8, 99, 100, 101, 25_600, 16_385, 1 << 40] {
                let length = wave_length(paths, wave_size);
                assert!((1..=u64::from(wave_size)).contains(&length), "{paths} {wave_size}");
                // No more waves than needed, and the last lacks less than a path for each.
                let waves = paths.div_ceil(length);
                assert_eq!(waves, paths.div_ceil(u64::from(wave_size)), "{paths} {wave_size}");
                assert!(waves * length - paths < waves.max(1), "{paths} {wave_size}");
            }
        }
    }
}
