//! Sort: a counting sort of the paths by what shades them.

use super::columns::Columns;
use super::rays::Rays;
use crate::accel::HitBatch;
use crate::scene::Looks;
use crate::simd::{Float, Int, LANES, first_bits};

/// The paths of a wave in the order of their keys. Its size depends on the number of keys only by a few
/// vectors each.
#[derive(Debug)]
pub(super) struct Queues {
    /// Path, distance, primitive.
    rows: Columns<3>,
    /// The key of each ray, in the order of the rays.
    keys: Vec<u8>,
    /// For each key, the first of its rows, a multiple of [`LANES`], and their number.
    spans: Vec<(u32, u32)>,
}

/// The paths of one key.
#[derive(Clone, Copy, Debug)]
pub(super) struct Queue<'a> {
    rows: &'a Columns<3>,
    first: usize,
    len: usize,
}

impl Queues {
    /// Room for `capacity` paths of `keys` keys.
    pub(super) fn new(keys: usize, capacity: usize) -> Self {
        Self {
            rows: Columns::with_capacity(capacity + keys * 2 * LANES),
            keys: vec![0; capacity.next_multiple_of(LANES)],
            spans: vec![(0, 0); keys],
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Queue<'_>> {
        let queue = |&(first, len): &(u32, u32)| Queue {
            rows: &self.rows,
            first: first as usize,
            len: len as usize,
        };
        self.spans.iter().map(queue)
    }
}

impl Queue<'_> {
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Rows `first..`, one a lane; the last is repeated until they fill a vector.
    #[inline(always)]
    pub(super) fn rows(&self, first: usize) -> [Int; 3] {
        self.rows.rows(self.first + first)
    }
}

/// Puts the paths of `rays`, which have hit `hits`, into the queues of their keys.
#[inline(never)]
pub(super) fn sort(rays: &Rays, hits: &HitBatch, looks: &Looks, queues: &mut Queues) {
    let Queues { rows, keys, spans } = queues;
    count(&hits.primitive[..rays.len()], looks, keys, spans);
    begin(spans);
    for first in (0..rays.len()).step_by(LANES) {
        let t = Float::load(&hits.t[first..]).to_bits();
        let row = [rays.paths(first), t, Int::load(&hits.primitive[first..])];
        let these: &[u8; LANES] = keys[first..].first_chunk().expect("a whole vector");
        let lanes = Int::new(these.map(u32::from));
        // Neighbours mostly have few keys between them.
        let mut rest = first_bits(LANES.min(rays.len() - first));
        while rest != 0 {
            let key = these[rest.trailing_zeros() as usize % LANES];
            let bits = lanes.eq(Int::splat(key.into())).bits() & rest;
            let (first, len) = &mut spans[usize::from(key)];
            rows.set((*first + *len) as usize, &row, bits);
            *len += bits.count_ones();
            rest &= !bits;
        }
    }
    for &(first, len) in &*spans {
        rows.pad(first as usize..(first + len) as usize);
    }
}

/// Finds the key of each ray, and how many rays each key has.
#[inline(never)]
fn count(primitives: &[u32], looks: &Looks, keys: &mut [u8], spans: &mut [(u32, u32)]) {
    // Neighbours often have the same key: with one table each count would wait for the last.
    let mut counts = [[0; 256]; 4];
    let (fours, rest) = primitives.as_chunks::<4>();
    for (these, keys) in fours.iter().zip(keys.as_chunks_mut::<4>().0) {
        for (lane, counts) in counts.iter_mut().enumerate() {
            keys[lane] = looks.key(these[lane]);
            counts[usize::from(keys[lane])] += 1;
        }
    }
    for (&primitive, key) in rest.iter().zip(&mut keys[4 * fours.len()..]) {
        *key = looks.key(primitive);
        counts[0][usize::from(*key)] += 1;
    }
    for (key, (_, len)) in spans.iter_mut().enumerate() {
        *len = counts.iter().map(|counts| counts[key]).sum();
    }
}

/// Sets where the rows of each key begin; none of them is there yet.
fn begin(spans: &mut [(u32, u32)]) {
    let mut end = 0;
    for (first, len) in spans {
        // Whole vectors are written: a queue's last may reach beyond it by almost as much.
        *first = (end + LANES as u32 - 1).next_multiple_of(LANES as u32);
        end = *first + *len;
        *len = 0;
    }
}
