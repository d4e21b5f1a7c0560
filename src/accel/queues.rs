//! Rays that go down the same axes share packets: they wait in queues, one for each octant.

use super::batch::{HitBatch, RayVector};
use super::counters::Count;
use super::job::Job;
use super::packet::{Packet, VECTORS};
use crate::simd::{Bits, Float, Int, LANES, axes, first_bits, places};

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
    const EMPTY: Self = Self { numbers: [[0.0; ROOM]; 9], indices: [0; ROOM], len: 0 };

    /// Adds the lanes of `rays` whose bits are set.
    #[inline(always)]
    fn push(&mut self, rays: &RayVector, indices: Int, bits: u32) {
        let places = places(bits);
        debug_assert!(self.len < FULL, "a full packet is taken off at once");
        // Known to the compiler, no place is checked.
        let at = self.len.min(FULL);
        for (number, numbers) in rays.numbers().into_iter().zip(&mut self.numbers) {
            number.shuffled(places).store(&mut numbers[at..]);
        }
        indices.shuffled(places).store(&mut self.indices[at..]);
        self.len = at + bits.count_ones() as usize;
    }

    /// A vector of the rays.
    #[inline(always)]
    fn vector(&self, first: usize) -> RayVector {
        let mut numbers = [Float::ZERO; 9];
        for (number, from) in numbers.iter_mut().zip(&self.numbers) {
            *number = Float::load(&from[first..]);
        }
        RayVector::of(numbers)
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
            let down = axes(|axis| rays.direction[axis].sign_bits());
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    #[test]
    fn rays_of_one_octant_are_found() {
        let mut random = Stream::new(12);
        for _ in 0..1000 {
            let down = [(); 3].map(|()| random.bits() as u32 & first_bits(LANES));
            let octant = |lane: usize| (0..3).map(|axis| (down[axis] >> lane & 1) << axis).sum();
            let rays = random.bits() as u32 & first_bits(LANES) | 1;
            let first: u32 = octant(Bits(rays).next().unwrap());
            let alike = Bits(rays).filter(|&lane| octant(lane) == first).map(|lane| 1 << lane);
            assert_eq!(octant_of_first(rays, down), (first as usize, alike.sum()));
        }
    }
}
