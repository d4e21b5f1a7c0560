//! Accumulate: samples become pixels, in the order that every engine keeps.

use std::ops::Range;

use glam::Vec3;

use super::paths::Paths;
use crate::engine::contract::counted;
use crate::engine::renderer::TileResult;
use crate::engine::settings::RenderSettings;
use crate::film::{PixelSum, Tile};

/// Adds the samples of `paths`, which are number `range` of `tile`, to the pixel that `sum` is at, and
/// to those that follow.
#[inline(never)]
pub(super) fn accumulate(
    paths: &Paths,
    tile: Tile,
    range: Range<u64>,
    settings: &RenderSettings,
    sum: &mut PixelSum,
    result: &mut TileResult,
) {
    let RenderSettings { spp, clamp, .. } = *settings;
    let (mut pixel, mut sample) =
        ((range.start / u64::from(spp)) as u32, (range.start % u64::from(spp)) as u32);
    let (mut first, count) = (0, (range.end - range.start) as usize);
    while first < count {
        let end = count.min(first + (spp - sample) as usize);
        let radiances = paths.radiances(first..end);
        // Nearly always.
        if clamp == f32::INFINITY && radiances.clone().all(|radiance| radiance.is_finite()) {
            sum.add_all(radiances);
        } else {
            let (x, y) = tile.pixel(pixel);
            for (sample, radiance) in (sample..).zip(radiances) {
                let counted = counted(radiance, clamp);
                let (radiance, clamped) = counted.unwrap_or((Vec3::ZERO, false));
                sum.add(radiance);
                result.tally.clamped += u64::from(clamped);
                if counted.is_none() {
                    result.tally.non_finite.note(x, y, sample);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;
    use crate::simd::{Int, Vec3x};

    /// Waves that begin and end within pixels, and samples that are not finite.
    #[test]
    fn samples_go_to_their_pixels() {
        let tile = Tile { x: 3, y: 5, width: 4, height: 2 };
        let (spp, mut random) = (21u32, Stream::new(9));
        let scene = crate::scene::Scene::load("cornell").unwrap();
        let settings = RenderSettings { spp, ..RenderSettings::of(&scene) };
        let samples: Vec<Vec3> = (0..8 * spp)
            .map(|i| match i % 37 {
                5 => Vec3::new(1.0, f32::NAN, 0.0),
                6 => Vec3::X * f32::INFINITY,
                _ => Vec3::splat(random.uniform()),
            })
            .collect();
        let (mut sum, mut result) = (PixelSum::default(), TileResult::default());
        for range in [0..5u64, 5..60, 60..63, 63..168] {
            let mut paths = Paths::new(168);
            for (path, sample) in (0..).zip(&samples[range.start as usize..range.end as usize]) {
                let indices = paths.indices(Int::splat(path));
                paths.add_radiance(&indices, Vec3x::splat(*sample), u32::MAX);
            }
            accumulate(&paths, tile, range, &settings, &mut sum, &mut result);
        }
        let mut want = PixelSum::default();
        for (pixel, samples) in samples.chunks(spp as usize).enumerate() {
            for sample in samples {
                want.add(if sample.is_finite() { *sample } else { Vec3::ZERO });
            }
            assert_eq!(result.pixels[pixel], want.take_mean().to_array(), "pixel {pixel}");
        }
        let wrong = samples.iter().filter(|sample| !sample.is_finite()).count();
        assert_eq!(result.tally.non_finite.count, wrong as u64);
        assert_eq!(result.tally.non_finite.first, Some((3, 5, 5)));
    }
}
