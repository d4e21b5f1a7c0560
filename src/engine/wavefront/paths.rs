//! The state of paths: one cache line per path, which stays in place for the whole path.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::Ray;
use crate::math::{PathKey, Real, Row};
use crate::shading::Nesting;
use crate::simd::{Float, Indices, Int, LANES, Mask, Vec3x};

/// The paths of a wave, indexed by the number of their sample in the wave.
///
/// A path is a cache line of four rows: origin and time; direction and density; throughput and the
/// first word of the key; radiance and the second word. Vectors of paths are read by transposing
/// rows, which takes one cache line per path in any order of paths.
///
/// The weights of the pixel filter have a list of their own, which only *generate* and *accumulate*
/// touch, and which is empty with the box. They multiply finished samples: the throughput stays
/// positive, as Russian roulette needs it, and the line has no room for them. The bodies that paths are in
/// also have a list of their own, which is empty if no body absorbs light.
#[derive(Debug)]
pub(super) struct Paths {
    lines: Vec<Line>,
    weights: Vec<f32>,
    nestings: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Line([Row; 4]);

/// The current segments of paths, one per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// The ray, with a direction of unit length.
    pub(super) ray: Ray<Float>,
    /// Density with which a surface or a medium sampled the direction, or [`SPECULAR`] if no light
    /// sample could have found the hit.
    ///
    /// [`SPECULAR`]: crate::shading::material::SPECULAR
    pub(super) pdf: Float,
}

/// The state that paths accumulate over their segments, one path per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct History {
    /// Throughput: the factor from radiance along the ray to the sample's radiance.
    pub(super) beta: Vec3x,
    /// Radiance that has arrived at the camera so far.
    pub(super) radiance: Vec3x,
    /// Keys of the random numbers.
    pub(super) keys: PathKey<Int>,
}

impl Paths {
    /// Creates storage for `capacity` paths, which may have weights, and may be in bodies that absorb light.
    pub(super) fn new(capacity: usize, weighted: bool, in_bodies: bool) -> Self {
        // The capacity is rounded up because whole vectors are written.
        let capacity = capacity.next_multiple_of(LANES);
        let weights = vec![1.0; if weighted { capacity } else { 0 }];
        let nestings = vec![0; if in_bodies { capacity } else { 0 }];
        Self { lines: vec![Line([[0; 4]; 4]); capacity], weights, nestings }
    }

    /// Lets all paths begin in the bodies of `nesting`.
    pub(super) fn begin_in(&mut self, nesting: Nesting<f32>) {
        self.nestings.fill(nesting.0);
    }

    /// The bodies that the paths `indices` are in.
    #[inline(always)]
    pub(super) fn nestings(&self, indices: &Indices) -> Nesting<Float> {
        Nesting(Int::new(indices.pick(&self.nestings)))
    }

    /// Sets the bodies that the paths `indices` are in. Lanes with the same path must have the same bodies.
    #[inline(always)]
    pub(super) fn set_nestings(&mut self, indices: &Indices, nestings: Nesting<Float>) {
        for (&path, nesting) in indices.lanes().iter().zip(nestings.0.to_array()) {
            self.nestings[path as usize] = nesting;
        }
    }

    /// Sets the weights of the paths from `first` on, if paths have weights.
    #[inline(always)]
    pub(super) fn set_weights(&mut self, first: usize, weights: Float) {
        if let Some(lanes) = self.weights.get_mut(first..first + LANES) {
            lanes.copy_from_slice(&weights.to_array());
        }
    }

    /// Multiplies the radiance of the first `count` paths by their weights, if paths have weights.
    pub(super) fn apply_weights(&mut self, count: usize) {
        for (Line([.., row]), weight) in self.lines.iter_mut().zip(&self.weights).take(count) {
            row[..3].iter_mut().for_each(|c| *c = (f32::from_bits(*c) * weight).to_bits());
        }
    }

    /// The weight of path number `path`.
    pub(super) fn weight(&self, path: usize) -> f32 {
        self.weights.get(path).copied().unwrap_or(1.0)
    }

    /// Reads row `row` of the paths `indices`: a vector and a number.
    #[inline(always)]
    fn gather(&self, row: usize, indices: &Indices) -> (Vec3x, Float) {
        indices.gather(&self.lines, |line| &line.0[row])
    }

    /// Writes row `row` of the paths `indices`. Lanes with the same path must have the same values.
    #[inline(always)]
    fn scatter(&mut self, row: usize, indices: &Indices, columns: (Vec3x, Float)) {
        indices.scatter(&mut self.lines, |line| &mut line.0[row], columns);
    }

    /// The ray of path number `path`, and the key of its random numbers.
    pub(super) fn ray(&self, path: usize) -> (Ray, PathKey) {
        let Line(rows) = &self.lines[path];
        let vector = |row: usize| Vec3::from_slice(&rows[row].map(f32::from_bits));
        let time = f32::from_bits(rows[0][3]);
        let ray = Ray { origin: vector(0), direction: vector(1), time };
        (ray, PathKey { pixel_word: rows[2][3], sample_word: rows[3][3] })
    }

    /// Multiplies the throughput of path number `path`.
    pub(super) fn weaken(&mut self, path: usize, by: Vec3) {
        let row = &mut self.lines[path].0[2];
        for channel in 0..3 {
            row[channel] = (f32::from_bits(row[channel]) * by[channel]).to_bits();
        }
    }

    /// Creates indices of the paths in `lanes`, which must all exist.
    #[inline(always)]
    pub(super) fn indices(&self, lanes: Int) -> Indices {
        Indices::new(lanes, self.lines.len())
    }

    /// The segments of the paths `indices`.
    #[inline(always)]
    pub(super) fn segments(&self, indices: &Indices) -> Segment {
        let (origin, time) = self.gather(0, indices);
        let (direction, pdf) = self.gather(1, indices);
        Segment { ray: Ray { origin, direction, time }, pdf }
    }

    /// Sets the segments of the paths `indices`. Terminated paths may be overwritten.
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

    /// Sets the radiance of the paths `indices`.
    #[inline(always)]
    pub(super) fn set_radiance(&mut self, indices: &Indices, history: &History) {
        self.scatter(3, indices, (history.radiance, Float::from_bits(history.keys.sample_word)));
    }

    /// The radiance of each path in `range`.
    pub(super) fn radiances(&self, range: Range<usize>) -> impl Iterator<Item = Vec3> + Clone {
        self.lines[range]
            .iter()
            .map(|Line([.., [r, g, b, _]])| Vec3::from_array([*r, *g, *b].map(f32::from_bits)))
    }

    /// Adds `light` to the radiance of those paths in `indices` whose bits are set. Lanes with the
    /// same path must have the same light and bit.
    #[inline(always)]
    pub(super) fn add_radiance(&mut self, indices: &Indices, light: Vec3x, bits: u32) {
        let (radiance, sample_word) = self.gather(3, indices);
        let sum = Mask::from_bits(bits).select(radiance + light, radiance);
        self.scatter(3, indices, (sum, sample_word));
    }
}
