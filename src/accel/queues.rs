//! Rays that go down the same axes share packets: they wait in queues, one for each octant.

use super::batch::{HitBatch, RayVector};
use super::counters::Count;
use super::packet::{Job, Packet};
use super::pair_traversal::VECTORS;
use crate::simd::{Bits, Float, Int, LANES, Vec3x, axes, first_bits, places};

/// Rays that wait until they fill a packet, and room for a vector more.
struct Queue {
    numbers: [[f32; ROOM]; 9],
    /// Which of the job's rays they are.
    indices: [u32; ROOM],
    len: usize,
}

/// Rays in a packet.
const FULL: usize = VECTORS * LANES;
const ROOM: usize = FULL + LANES;

impl Queue {
    const EMPTY: Self = Self { numbers: [[f32::NAN; ROOM]; 9], indices: [0; ROOM], len: 0 };

    /// Adds the lanes of `rays` whose bits are set.
    #[inline(always)]
    fn push(&mut self, rays: &RayVector, indices: Int, bits: u32) {
        let places = places(bits);
        // Known to the compiler, no place is checked.
        let at = self.len.min(FULL);
        let put = |lanes: Float, numbers: &mut [f32; ROOM]| {
            lanes.shuffled(places).store(&mut numbers[at..]);
        };
        let [ox, oy, oz, dx, dy, dz, time, t_min, t_max] = &mut self.numbers;
        put(rays.origin[0], ox);
        put(rays.origin[1], oy);
        put(rays.origin[2], oz);
        put(rays.direction[0], dx);
        put(rays.direction[1], dy);
        put(rays.direction[2], dz);
        put(rays.time, time);
        put(rays.t_min, t_min);
        put(rays.t_max, t_max);
        indices.shuffled(places).store(&mut self.indices[at..]);
        self.len = at + bits.count_ones() as usize;
    }

    /// A vector of the rays.
    #[inline(always)]
    fn vector(&self, first: usize) -> RayVector {
        let load = |i: usize| Float::load(&self.numbers[i][first..]);
        RayVector {
            origin: Vec3x([load(0), load(1), load(2)]),
            direction: Vec3x([load(3), load(4), load(5)]),
            time: load(6),
            t_min: load(7),
            t_max: load(8),
        }
    }

    /// Takes off a packet, of which there is one.
    #[inline(always)]
    fn pop(&mut self) {
        for numbers in &mut self.numbers {
            Float::load(&numbers[FULL..]).store(numbers);
        }
        Int::load(&self.indices[FULL..]).store(&mut self.indices);
        self.len -= FULL;
    }
}

/// The octant of the first ray in `rays`, and those that share it. For each axis, `down` has the
/// bits of rays that go down.
#[inline(always)]
fn octant_of_first(rays: u32, down: [u32; 3]) -> (usize, u32) {
    let lane = rays.trailing_zeros();
    // All bits where the first ray goes down, else none.
    let [x, y, z] = axes(|axis| 0u32.wrapping_sub(down[axis] >> lane & 1));
    let alike = rays & !(down[0] ^ x) & !(down[1] ^ y) & !(down[2] ^ z);
    ((x & 1 | y & 2 | z & 4) as usize, alike)
}

impl Job<'_> {
    /// As [`Job::trace`], but packets are of rays of one octant, as far as there are enough.
    #[inline(always)]
    pub(super) fn trace_by_octant<const ANY: bool, C: Count>(
        &self,
        hits: &mut HitBatch,
        count: &mut C,
        mut search: impl FnMut(&mut Packet<VECTORS>, &mut C),
    ) -> Vec<usize> {
        let (first, end) = self.ends;
        let mut queues = [const { Queue::EMPTY }; 8];
        let mut wild = Vec::new();
        let mut packet = Packet::<VECTORS>::NONE;
        let mut trace = |queue: &mut Queue, hits: &mut HitBatch, count: &mut C| {
            for (v, vector) in packet.vectors.iter_mut().enumerate() {
                let first = v * LANES;
                let present = first_bits(queue.len.saturating_sub(first));
                let wild_bits = vector.load(&queue.vector(first), present, self.extent);
                wild.extend(Bits(wild_bits).map(|lane| queue.indices[first + lane] as usize));
            }
            self.search_all::<ANY, VECTORS, C>(&mut packet, count, &mut search);
            packet.scatter::<ANY>(&queue.indices, hits);
        };
        for first in (first..end).step_by(LANES) {
            let rays = self.rays.vector(first);
            let indices = Int::LANE + Int::splat(first as u32);
            let down = axes(|axis| rays.direction[axis].lt(Float::ZERO).bits());
            let mut left = first_bits(LANES.min(end - first));
            while left != 0 {
                let (octant, alike) = octant_of_first(left, down);
                left &= !alike;
                let queue = &mut queues[octant];
                queue.push(&rays, indices, alike);
                if queue.len >= FULL {
                    trace(queue, hits, count);
                    queue.pop();
                }
            }
        }
        // What is left makes packets of mixed octants.
        let [all, others @ ..] = &mut queues;
        for other in others {
            for first in (0..other.len).step_by(LANES) {
                let indices = Int::load(&other.indices[first..]);
                let present = first_bits(LANES.min(other.len - first));
                all.push(&other.vector(first), indices, present);
                if all.len >= FULL {
                    trace(all, hits, count);
                    all.pop();
                }
            }
        }
        if all.len > 0 {
            trace(all, hits, count);
        }
        wild
    }
}
