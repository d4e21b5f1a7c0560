//! Generate: camera rays.

use super::paths::{History, Paths, Segment};
use super::rays::Rays;
use crate::accel::RayVector;
use crate::engine::dimension::{Dimension, Randoms};
use crate::engine::settings::RenderSettings;
use crate::film::Unit;
use crate::math::random::PixelKey;
use crate::scene::CameraFrame;
use crate::simd::random::PathKeys;
use crate::simd::warp::uniform_disk;
use crate::simd::{Float, Int, LANES, Lanes, Vec3x};

/// Makes the paths of `unit`, whose pixels go row by row with their samples.
#[inline(never)]
pub(super) fn generate(
    camera: &CameraFrame,
    settings: &RenderSettings,
    unit: Unit,
    paths: &mut Paths,
    rays: &mut Rays,
) {
    let mut samples = Samples::new(settings, unit);
    let count = unit.paths() as usize;
    rays.begin(count);
    for first in (0..count).step_by(LANES) {
        let sampled = samples.next_lanes();
        let keys = settings.sampler.paths(sampled.pixel_key, sampled.sample);
        let randoms = Randoms::new(settings.sampler, keys, 0);
        let made = camera_rays(camera, sampled.x, sampled.y, &randoms);
        let RayVector { origin, direction, time, .. } = made;
        let pdf = Float::splat(Segment::SPECULAR);
        let beta = Vec3x([Float::splat(1.0); 3]);
        let indices = paths.indices(rays.paths(first));
        paths.set_segments(&indices, &Segment { origin, time, direction, pdf });
        let history = History { beta, radiance: Vec3x::ZERO, keys };
        paths.set_beta(&indices, &history);
        paths.set_radiance(&indices, &history);
        rays.batch.extend(&made, LANES.min(count - first));
    }
}

/// [`CameraFrame::ray`] a lane.
#[inline(always)]
fn camera_rays(camera: &CameraFrame, x: Int, y: Int, randoms: &Randoms<PathKeys>) -> RayVector {
    let (dx, dy) = randoms.two(Dimension::PIXEL);
    let (right, down) = camera.pixel_steps;
    let target = Vec3x::splat(camera.corner)
        + Vec3x::splat(right) * (x.to_float() + dx)
        + Vec3x::splat(down) * (y.to_float() + dy);
    let lens = match camera.lens {
        None => Vec3x::ZERO,
        Some((u, v)) => {
            let (a, b) = randoms.two(Dimension::LENS);
            let (a, b) = uniform_disk(a, b);
            Vec3x::splat(u) * a + Vec3x::splat(v) * b
        }
    };
    let moment = Float::splat(camera.shutter_duration) * randoms.one(Dimension::TIME);
    RayVector {
        origin: Vec3x::splat(camera.origin) + lens,
        direction: (target - lens).normalize(),
        time: Float::splat(camera.shutter_open) + moment,
        t_min: Float::ZERO,
        t_max: Float::INFINITY,
    }
}

/// Goes through the samples of a unit's pixels.
struct Samples<'a> {
    settings: &'a RenderSettings,
    unit: Unit,
    x: u32,
    y: u32,
    sample: u32,
    key: PixelKey,
}

/// Pixel and sample, one a lane.
struct SampleLanes {
    x: Int,
    y: Int,
    sample: Int,
    /// Words of the pixel's key.
    pixel_key: (Int, Int),
}

impl<'a> Samples<'a> {
    fn new(settings: &'a RenderSettings, unit: Unit) -> Self {
        let (x, y) = (unit.tile.x, unit.tile.y);
        Self { settings, unit, x, y, sample: unit.first, key: PixelKey::new(settings.seed, x, y) }
    }

    #[inline(always)]
    fn next_lanes(&mut self) -> SampleLanes {
        if self.unit.end - self.sample >= LANES as u32 {
            let (first, second) = self.key.words();
            let lanes = SampleLanes {
                x: Int::splat(self.x),
                y: Int::splat(self.y),
                sample: Int::splat(self.sample) + Int::LANE,
                pixel_key: (Int::splat(first), Int::splat(second)),
            };
            self.sample += LANES as u32;
            self.next_pixel_at_end();
            return lanes;
        }
        let mut lanes: [Lanes<u32>; 5] = [[0; LANES]; 5];
        for lane in 0..LANES {
            let (first, second) = self.key.words();
            let values = [self.x, self.y, self.sample, first, second];
            for (lanes, value) in lanes.iter_mut().zip(values) {
                lanes[lane] = value;
            }
            self.sample += 1;
            self.next_pixel_at_end();
        }
        let [x, y, sample, first, second] = lanes.map(Int::new);
        SampleLanes { x, y, sample, pixel_key: (first, second) }
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
