//! Sort: paths go to the queue of what they have hit.

use super::columns::Columns;
use super::materials::Materials;
use super::rays::Rays;
use crate::accel::HitBatch;
use crate::simd::{Float, Int, LANES, first_bits};

/// Paths that are shaded together: path, distance, primitive.
pub(super) type Queue = Columns<3>;

/// Puts the paths of `rays`, which have hit `hits`, into the queues of [`Materials::bins`].
#[inline(never)]
pub(super) fn sort(rays: &Rays, hits: &HitBatch, materials: &Materials, queues: &mut [Queue]) {
    queues.iter_mut().for_each(Queue::clear);
    for first in (0..rays.len()).step_by(LANES) {
        let present = first_bits(rays.len() - first);
        let t = Float::load(&hits.t[first..]).to_bits();
        let primitive = Int::load(&hits.primitive[first..]);
        let row = [rays.paths(first), t, primitive];
        let bins = Int::new(primitive.to_array().map(|p| u32::from(materials.bin(p))));
        for (bin, queue) in queues.iter_mut().enumerate() {
            let bits = bins.eq(Int::splat(bin as u32)).bits() & present;
            // No branch on whether there is any: no CPU could foretell it.
            queue.append(&row, bits);
        }
    }
    queues.iter_mut().for_each(Queue::pad);
}
