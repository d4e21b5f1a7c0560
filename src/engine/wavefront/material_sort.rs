//! Sort: a counting sort of the paths by key, which selects the kernel that shades them.

use super::{Columns, WaveRays};
use crate::accel::HitBatch;
use crate::math::{Real, Word};
use crate::shading::Looks;
use crate::simd::{Float, Int, LANES, first_bits};

/// The paths of a wave, sorted by key. Each key needs room for only two additional vectors.
#[derive(Debug)]
pub(super) struct Queues {
    /// Columns: path, distance, primitive.
    rows: Columns<3>,
    /// The instances, in scenes that have any.
    instances: Option<Columns<1>>,
    /// The key of each ray, in the order of the rays.
    keys: Vec<u8>,
    /// For each key, the index of its first row, a multiple of [`LANES`], and its number of rows.
    spans: Vec<(u32, u32)>,
}

/// The paths with one key.
#[derive(Clone, Copy, Debug)]
pub(super) struct Queue<'a> {
    rows: &'a Columns<3>,
    instances: Option<&'a Columns<1>>,
    first: usize,
    len: usize,
}

impl Queues {
    /// Creates queues for `capacity` paths with `keys` different keys. `instanced` is set if the
    /// scene has instances.
    pub(super) fn new(keys: usize, capacity: usize, instanced: bool) -> Self {
        let rows = capacity + keys * 2 * LANES;
        Self {
            rows: Columns::with_capacity(rows),
            instances: instanced.then(|| Columns::with_capacity(rows)),
            keys: vec![0; capacity.next_multiple_of(LANES)],
            spans: vec![(0, 0); keys],
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Queue<'_>> {
        let queue = |&(first, len): &(u32, u32)| Queue {
            rows: &self.rows,
            instances: self.instances.as_ref(),
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

    /// The rows from `first` on, one per lane. Lanes beyond the last row repeat it.
    #[inline(always)]
    pub(super) fn rows(&self, first: usize) -> [Int; 3] {
        self.rows.rows(self.first + first)
    }

    /// The instances of these rows.
    #[inline(always)]
    pub(super) fn instances(&self, first: usize) -> Int {
        let instances = self.instances.expect("a scene with instances has this column");
        instances.rows(self.first + first)[0]
    }
}

/// Puts the paths of `rays`, whose hits are `hits`, into the queues of their keys.
#[inline(never)]
pub(super) fn sort(rays: &WaveRays, hits: &HitBatch, looks: &Looks, queues: &mut Queues) {
    let Queues { rows, instances, keys, spans } = queues;
    match looks.key_words::<Float>() {
        Some(key_of) => count_vectors(&hits.primitive, rays.len(), key_of, keys, spans),
        None => count(&hits.primitive[..rays.len()], looks, keys, spans),
    }
    distribute(rays.len(), keys, spans, rows, |first| {
        let t = Float::load(&hits.t[first..]).to_bits();
        [rays.paths(first), t, Int::load(&hits.primitive[first..])]
    });
    if let Some(instances) = instances {
        distribute(rays.len(), keys, spans, instances, |first| {
            [Int::load(&hits.instance[first..])]
        });
    }
}

/// Puts the rows of `len` rays into the columns of their queues. `row_of` returns the rows of a
/// vector of rays.
#[inline(always)]
fn distribute<const N: usize>(
    len: usize,
    keys: &[u8],
    spans: &mut [(u32, u32)],
    rows: &mut Columns<N>,
    row_of: impl Fn(usize) -> [Int; N],
) {
    begin(spans);
    for first in (0..len).step_by(LANES) {
        let row = row_of(first);
        let these: &[u8; LANES] =
            keys[first..].first_chunk().expect("`keys` is padded to whole vectors");
        let lanes = Int::new(these.map(u32::from));
        // Neighbouring rays mostly share a few keys.
        let mut rest = first_bits(LANES.min(len - first));
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

/// Does the same as [`count`], for `len` rays and few keys, which `key_of` finds for a vector of rays
/// at once. Whole renders of meshes are up to 4% faster.
#[inline(never)]
fn count_vectors(
    primitives: &[u32],
    len: usize,
    key_of: impl Fn(Int) -> Int,
    keys: &mut [u8],
    spans: &mut [(u32, u32)],
) {
    spans.iter_mut().for_each(|(_, len)| *len = 0);
    for first in (0..len).step_by(LANES) {
        let here = key_of(Int::load(&primitives[first..]));
        keys[first..first + LANES].copy_from_slice(&here.to_array().map(|key| key as u8));
        let present = first_bits(LANES.min(len - first));
        for (key, (_, len)) in spans.iter_mut().enumerate() {
            *len += (here.eq(Int::splat(key as u32)).bits() & present).count_ones();
        }
    }
}

/// Finds the key of each ray, and how many rays each key has.
#[inline(never)]
fn count(primitives: &[u32], looks: &Looks, keys: &mut [u8], spans: &mut [(u32, u32)]) {
    // Neighbours often have the same key. With only one table, each increment would wait for the
    // previous one.
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

/// Computes the first row of each key from the numbers of rows, and resets these to 0.
fn begin(spans: &mut [(u32, u32)]) {
    let mut end = 0;
    for (first, len) in spans {
        // Whole vectors are written, so a queue's last vector may extend past its end by almost a
        // vector.
        *first = (end + LANES as u32 - 1).next_multiple_of(LANES as u32);
        end = *first + *len;
        *len = 0;
    }
}
