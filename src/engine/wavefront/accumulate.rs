//! Accumulate: adds the samples of each pixel, in the order that all engines use.

use glam::Vec3;

use super::Paths;
use super::layer_samples::LayerSamples;
use crate::engine::{ImageSettings, Tally, Task, scale};
use crate::film::{COLOR, UnitSums};

/// Adds the samples of `paths`, which belong to `task`, pixel by pixel.
#[inline(never)]
pub(super) fn accumulate(
    paths: &Paths,
    layers: &LayerSamples,
    task: &Task,
    settings: &ImageSettings,
    tally: &mut Tally,
) -> UnitSums {
    let unit = task.unit;
    let samples = unit.samples() as usize;
    let clamp = settings.clamp.unwrap_or(f32::INFINITY);
    let mut sums = task.open_sums();
    for (pixel, sums) in (0..).zip(sums.chunks_exact_mut(task.channels)) {
        let open = Vec3::from_slice(sums);
        let first = pixel as usize * samples;
        let radiances = paths.radiances(first..first + samples);
        let mut sum = radiances.clone().fold(open, |sum, radiance| sum + radiance);
        // Any non-finite sample makes the sum non-finite, so only such sums need a second look.
        if settings.clamp.is_some() || !sum.is_finite() {
            let (x, y) = unit.tile.pixel(pixel);
            sum = (unit.first..).zip(radiances.clone()).fold(open, |sum, (sample, radiance)| {
                sum + tally.counted(radiance, clamp, (x, y, sample))
            });
        }
        sum.write_to_slice(sums);
        if task.channels > COLOR {
            layers.add_to(&mut sums[COLOR..], first, unit.first..unit.end);
            if layers.have_light {
                for (number, radiance) in (0..).zip(radiances) {
                    let path = first + number as usize;
                    let light = layers.light(path, radiance, paths.weight(path));
                    // Samples that are not finite are black in all layers.
                    if let Some(scale) = scale(radiance, clamp) {
                        layers.layers.add_light(sums, &light, unit.first + number, scale);
                    }
                }
            }
        }
    }
    UnitSums { unit, sums }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::layers::Layers;
    use crate::film::{Tile, Unit};
    use crate::math::Word;
    use crate::math::{Stream, Vector};
    use crate::simd::{Int, Vec3x};

    /// Samples are added to their own pixel. Non-finite samples are counted and left out.
    #[test]
    fn samples_go_to_their_pixels() {
        let tile = Tile { x: 3, y: 5, width: 4, height: 2 };
        let unit = Unit { tile, first: 32, end: 47 };
        let mut random = Stream::new(9);
        let scene = crate::scene::Scene::load("cornell").unwrap();
        let settings = ImageSettings::of(&scene);
        let samples: Vec<Vec3> = (0..8 * 15)
            .map(|i| match i % 37 {
                5 => Vec3::new(1.0, f32::NAN, 0.0),
                6 => Vec3::X * f32::INFINITY,
                _ => Vec3::splat(random.uniform()),
            })
            .collect();
        let mut paths = Paths::new(samples.len(), false, false);
        for (path, sample) in (0..).zip(&samples) {
            let indices = paths.indices(Int::splat(path));
            paths.add_radiance(&indices, <Vec3x as Vector>::splat(*sample), u32::MAX);
        }
        let mut tally = Tally::default();
        let task = Task { unit, open: Vec::new(), channels: COLOR };
        let layers = LayerSamples::new(Layers::default(), samples.len());
        let part = accumulate(&paths, &layers, &task, &settings, &mut tally);
        assert_eq!(part.unit, unit);
        for (got, samples) in part.sums.chunks_exact(COLOR).zip(samples.chunks(15)) {
            let finite = samples.iter().filter(|sample| sample.is_finite());
            assert_eq!(got, finite.fold(Vec3::ZERO, |sum, sample| sum + sample).to_array());
        }
        let wrong = samples.iter().filter(|sample| !sample.is_finite()).count();
        assert_eq!(tally.non_finite.count, wrong as u64);
        assert_eq!(tally.non_finite.first, Some((3, 5, 37)));
    }
}
