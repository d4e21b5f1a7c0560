//! Accumulate: samples become pixels, in the order that every engine keeps.

use std::ops::Range;

use glam::Vec3;

use super::paths::Paths;
use crate::engine::renderer::TileResult;
use crate::film::{PixelSum, Tile};

/// Adds the samples of `paths`, which are number `range` of `tile`, to the pixel that `sum` is at, and
/// to those that follow.
pub(super) fn accumulate(
    paths: &Paths,
    tile: Tile,
    range: Range<u64>,
    spp: u32,
    sum: &mut PixelSum,
    result: &mut TileResult,
) {
    let (mut pixel, mut sample) =
        ((range.start / u64::from(spp)) as u32, (range.start % u64::from(spp)) as u32);
    let (mut first, count) = (0, (range.end - range.start) as usize);
    while first < count {
        let end = count.min(first + (spp - sample) as usize);
        let radiances = paths.radiances(first..end);
        if radiances.clone().all(|radiance| radiance.is_finite()) {
            sum.add_all(radiances);
        } else {
            let (x, y) = tile.pixel(pixel);
            for (sample, radiance) in (sample..).zip(radiances) {
                let finite = radiance.is_finite();
                sum.add(if finite { radiance } else { Vec3::ZERO });
                if !finite {
                    result.non_finite.note(x, y, sample);
                }
            }
        }
        sample += (end - first) as u32;
        if sample == spp {
            result.pixels.push(sum.take_mean().to_array());
            (pixel, sample) = (pixel + 1, 0);
        }
        first = end;
    }
}
