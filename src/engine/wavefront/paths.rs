//! The state of paths: a cache line each, in one place from the camera to the end.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::Ray;
use crate::math::Row;
use crate::math::random::PathKey;
use crate::simd::{Float, Indices, Int, LANES, Mask, Vec3x};

/// The paths of a wave, by the number of their sample in it.
///
/// A path is a cache line of four rows: origin and time; direction and density; throughput and the
/// first word of the key; radiance and the second. Vectors of paths from anywhere are read by turning
/// rows into columns: one cache line a path, whatever their order.
#[derive(Debug)]
pub(super) struct Paths(Vec<Line>);

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Line([Row; 4]);

/// The segments that paths trace, one a lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// Directions are of unit length.
    pub(super) ray: Ray<Float>,
    /// Density with which a surface or medium chose the direction; [`SPECULAR`] where no light sample
    /// could have found what the path hits.
    ///
    /// [`SPECULAR`]: crate::scene::material::SPECULAR
    pub(super) pdf: Float,
}

/// What paths have been through, one a lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct History {
    /// Throughput: what a unit of radiance here adds to the pixel.
    pub(super) beta: Vec3x,
    /// What has arrived at the camera.
    pub(super) radiance: Vec3x,
    /// Of the random numbers.
    pub(super) keys: PathKey<Int>,
}

impl Paths {
    /// Room for `capacity` paths.
    pub(super) fn new(capacity: usize) -> Self {
        // Whole vectors are written.
        Self(vec![Line([[0; 4]; 4]); capacity.next_multiple_of(LANES)])
    }

    /// Row `row` of the paths `indices`: a vector and a number.
    #[inline(always)]
    fn gather(&self, row: usize, indices: &Indices) -> (Vec3x, Float) {
        indices.gather(&self.0, |line| &line.0[row])
    }

    /// Sets it. Lanes with the same path must have the same row.
    #[inline(always)]
    fn scatter(&mut self, row: usize, indices: &Indices, columns: (Vec3x, Float)) {
        indices.scatter(&mut self.0, |line| &mut line.0[row], columns);
    }

    /// The paths in `lanes`, all of which must be there.
    #[inline(always)]
    pub(super) fn indices(&self, lanes: Int) -> Indices {
        Indices::new(lanes, self.0.len())
    }

    /// The segments of the paths `indices`.
    #[inline(always)]
    pub(super) fn segments(&self, indices: &Indices) -> Segment {
        let (origin, time) = self.gather(0, indices);
        let (direction, pdf) = self.gather(1, indices);
        Segment { ray: Ray { origin, direction, time }, pdf }
    }

    /// Gives new segments to the paths `indices`. Those that have ended may be overwritten.
    #[inline(always)]
    pub(super) fn set_segments(&mut self, indices: &Indices, segments: &Segment) {
        let Segment { ray: Ray { origin, direction, time }, pdf } = *segments;
        self.scatter(0, indices, (origin, time));
        self.scatter(1, indices, (direction, pdf));
    }

    /// The histories of the paths `indices`.
    #[inline(always)]
    pub(super) fn histories(&self, indices: &Indices) -> History {
        let (beta, pixel_word) = self.gather(2, indices);
        let (radiance, sample_word) = self.gather(3, indices);
        let keys = PathKey { pixel_word: pixel_word.to_bits(), sample_word: sample_word.to_bits() };
        History { beta, radiance, keys }
    }

    /// The keys of the paths `indices`.
    #[inline(always)]
    pub(super) fn keys(&self, indices: &Indices) -> PathKey<Int> {
        self.histories(indices).keys
    }

    /// Sets the throughputs of the paths `indices`.
    #[inline(always)]
    pub(super) fn set_beta(&mut self, indices: &Indices, history: &History) {
        self.scatter(2, indices, (history.beta, Float::from_bits(history.keys.pixel_word)));
    }

    /// Sets what has arrived along the paths `indices`.
    #[inline(always)]
    pub(super) fn set_radiance(&mut self, indices: &Indices, history: &History) {
        self.scatter(3, indices, (history.radiance, Float::from_bits(history.keys.sample_word)));
    }

    /// What has arrived at the camera along each of the paths `range`.
    pub(super) fn radiances(&self, range: Range<usize>) -> impl Iterator<Item = Vec3> + Clone {
        self.0[range]
            .iter()
            .map(|Line([.., [r, g, b, _]])| Vec3::from_array([*r, *g, *b].map(f32::from_bits)))
    }

    /// Adds `light` to what has arrived along those of the paths `indices` whose bits are set. Lanes
    /// with the same path must have the same light and bit.
    #[inline(always)]
    pub(super) fn add_radiance(&mut self, indices: &Indices, light: Vec3x, bits: u32) {
        let (radiance, sample_word) = self.gather(3, indices);
        let sum = Mask::from_bits(bits).select(radiance + light, radiance);
        self.scatter(3, indices, (sum, sample_word));
    }
}
