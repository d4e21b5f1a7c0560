//! Generate: creates paths and their camera rays.

use super::{History, Paths, Segment, WaveRays};
use crate::accel::RayVector;
use crate::engine::ImageSettings;
use crate::film::Unit;
use crate::math::{PixelKey, Real, Word};
use crate::sampler::Randoms;
use crate::shading::CameraFrame;
use crate::shading::material::SPECULAR;
use crate::simd::{Float, Int, LANES, Lanes, Vec3x};

/// Creates the paths of `unit`: pixel by pixel in rows, and all samples of a pixel in sequence.
#[inline(never)]
pub(super) fn generate(
    camera: &CameraFrame,
    settings: &ImageSettings,
    unit: Unit,
    paths: &mut Paths,
    rays: &mut WaveRays,
) {
    // Without choices in the loop, it takes 0.9 of the time.
    match camera.is_plain() {
        true => generate_by::<true>(camera, settings, unit, paths, rays),
        false => generate_by::<false>(camera, settings, unit, paths, rays),
    }
}

fn generate_by<const PLAIN: bool>(
    camera: &CameraFrame,
    settings: &ImageSettings,
    unit: Unit,
    paths: &mut Paths,
    rays: &mut WaveRays,
) {
    let mut samples = Samples::new(settings, unit);
    let count = unit.paths() as usize;
    rays.begin(count);
    for first in (0..count).step_by(LANES) {
        let sampled = samples.next_lanes();
        let keys = settings.sampler.path(sampled.pixel_key, sampled.sample);
        let randoms = Randoms::new(settings.sampler, keys, 0);
        let (x, y) = (sampled.x.to_float(), sampled.y.to_float());
        let (ray, weights) = camera.ray::<Float, PLAIN>(x, y, &randoms);
        let indices = paths.indices(rays.paths(first));
        paths.set_segments(&indices, &Segment { ray, pdf: Float::splat(SPECULAR) });
        let history = History { beta: Vec3x([Float::ONE; 3]), radiance: Vec3x::ZERO, keys };
        paths.set_beta(&indices, &history);
        paths.set_radiance(&indices, &history);
        if !PLAIN {
            paths.set_weights(first, weights);
        }
        rays.batch.extend(&RayVector::unbounded(ray), LANES.min(count - first));
    }
}

/// Iterates over the samples of a unit's pixels.
struct Samples<'a> {
    settings: &'a ImageSettings,
    unit: Unit,
    x: u32,
    y: u32,
    sample: u32,
    key: PixelKey,
}

/// A pixel and a sample per lane.
struct SampleLanes {
    x: Int,
    y: Int,
    sample: Int,
    pixel_key: PixelKey<Int>,
}

impl<'a> Samples<'a> {
    fn new(settings: &'a ImageSettings, unit: Unit) -> Self {
        let (x, y) = (unit.tile.x, unit.tile.y);
        Self { settings, unit, x, y, sample: unit.first, key: PixelKey::new(settings.seed, x, y) }
    }

    #[inline(always)]
    fn next_lanes(&mut self) -> SampleLanes {
        if self.unit.end - self.sample >= LANES as u32 {
            let PixelKey(first, second) = self.key;
            let lanes = SampleLanes {
                x: Int::splat(self.x),
                y: Int::splat(self.y),
                sample: Int::splat(self.sample) + Int::LANE,
                pixel_key: PixelKey(Int::splat(first), Int::splat(second)),
            };
            self.sample += LANES as u32;
            self.next_pixel_at_end();
            return lanes;
        }
        let mut lanes: [Lanes<u32>; 5] = [[0; LANES]; 5];
        for lane in 0..LANES {
            let PixelKey(first, second) = self.key;
            let values = [self.x, self.y, self.sample, first, second];
            for (lanes, value) in lanes.iter_mut().zip(values) {
                lanes[lane] = value;
            }
            self.sample += 1;
            self.next_pixel_at_end();
        }
        let [x, y, sample, first, second] = lanes.map(Int::new);
        SampleLanes { x, y, sample, pixel_key: PixelKey(first, second) }
    }

    fn next_pixel_at_end(&mut self) {
        if self.sample == self.unit.end {
            let tile = self.unit.tile;
            self.sample = self.unit.first;
            self.x += 1;
            if self.x == tile.x + tile.width {
                (self.x, self.y) = (tile.x, self.y + 1);
            }
            self.key = PixelKey::new(self.settings.seed, self.x, self.y);
        }
    }
}
