//! Packets: vectors of rays against one box, and against one primitive.

use super::batch::{HitBatch, RayBatch};
use super::blocks::{BlockRef, Blocks, Kind};
use super::counters::Count;
use super::pair::PairTree;
use super::setup::{Extent, Setup};
use super::shear_axes;
use super::slab::Planes;
use crate::geometry::lanes::{self, HitLanes};
use crate::simd::{Bits, Float, Int, LANES, Lanes, Mask, Vec3x, axes, first_bits};

/// Vectors of rays in the packets of this kernel: 8 rays, or 32 with AVX-512.
pub(super) const VECTORS: usize = LANES / 8;

/// A vector of rays and their closest hits so far.
#[derive(Clone, Copy)]
pub(super) struct Rays {
    pub(super) setup: Setup,
    views: Views,
    /// Distance of the closest hit, at first the end of the interval; −∞ for rays that look
    /// for nothing (more).
    pub(super) t: Float,
    /// Its primitive; [`HitBatch::MISS`] before there is one.
    pub(super) primitive: Int,
}

/// Rays that look along the same axis, as triangle tests see it.
#[derive(Clone, Copy)]
struct View {
    axes: [usize; 3],
    rays: u32,
}

/// The views of a vector's rays.
#[derive(Clone, Copy)]
struct Views {
    views: [View; 6],
    count: usize,
}

impl Views {
    const NONE: Self = Self { views: [View { axes: [0; 3], rays: 0 }; 6], count: 0 };

    #[inline(always)]
    fn new(setup: &Setup) -> Self {
        let mut views = Self::NONE;
        let negative = setup.shear.negative.bits();
        for longest in 0..3 {
            let along = setup.shear.longest[longest].bits() & setup.active;
            for (is_negative, rays) in [(false, along & !negative), (true, along & negative)] {
                if rays != 0 {
                    views.views[views.count] =
                        View { axes: shear_axes(longest, is_negative), rays };
                    views.count += 1;
                }
            }
        }
        views
    }
}

/// A packet on its way.
pub(super) struct Packet<const V: usize> {
    vectors: [Rays; V],
}

impl<const V: usize> Packet<V> {
    const NONE: Self = Self { vectors: [Rays::NONE; V] };

    /// Takes rays `first..`, up to a packet's and below `end`. Adds the rays that it leaves to
    /// others to `wild`.
    #[inline(always)]
    fn load(
        &mut self,
        rays: &RayBatch,
        first: usize,
        end: usize,
        extent: &Extent,
        wild: &mut Vec<usize>,
    ) {
        for (v, vector) in self.vectors.iter_mut().enumerate() {
            *vector = Rays::load(rays, end.min(first + v * LANES), end, extent, wild);
        }
    }

    /// Writes what was hit. Rays that hit nothing are left as they are.
    #[inline(always)]
    pub(super) fn store<const ANY: bool>(&self, first: usize, end: usize, hits: &mut HitBatch) {
        for (vector, rays) in self.vectors.iter().enumerate() {
            let first = end.min(first + vector * LANES);
            let (old_t, old) = (&mut hits.t[first..end], &mut hits.primitive[first..end]);
            let miss = rays.primitive.eq(Int::splat(HitBatch::MISS));
            let (t, found) =
                if ANY { (Float::ZERO, Int::splat(0)) } else { (rays.t, rays.primitive) };
            if old.len() >= LANES {
                Int::select(miss, Int::load(old), found).store(old);
                miss.select(Float::load(old_t), t).store(old_t);
            } else {
                let (t, primitive) = (t.to_array(), found.to_array());
                for lane in Bits(!miss.bits() & first_bits(old.len())) {
                    old_t[lane] = t[lane];
                    old[lane] = primitive[lane];
                }
            }
        }
    }

    /// Tests the primitives in the lanes of a block whose bits are set, one after the other.
    #[inline(always)]
    pub(super) fn test<const ANY: bool>(
        &mut self,
        blocks: &Blocks,
        block: BlockRef,
        lanes: u32,
        count: &mut impl Count,
    ) {
        for rays in &self.vectors {
            let looking = rays.t.ge(Float::ZERO).bits().count_ones();
            (0..lanes.count_ones()).for_each(|_| count.leaf(LANES as u32, looking));
        }
        match block.kind() {
            Kind::Sphere => {
                let block = &blocks.spheres[block.place()];
                for lane in Bits(lanes) {
                    let center = Vec3x::splat_lane(&block.center, lane);
                    let radius = Float::splat(block.radius[lane]);
                    for rays in &mut self.vectors {
                        let hits = lanes::filtered_sphere(&rays.setup.ray, center, radius);
                        rays.offer::<ANY>(hits, block.primitive[lane]);
                    }
                }
            }
            Kind::MovingSphere => {
                let block = &blocks.moving_spheres[block.place()];
                for lane in Bits(lanes) {
                    let center = Vec3x::splat_lane(&block.still.center, lane);
                    let motion = Vec3x::splat_lane(&block.motion, lane);
                    let radius = Float::splat(block.still.radius[lane]);
                    for rays in &mut self.vectors {
                        let ray = &rays.setup.ray;
                        let hits = lanes::filtered_sphere(ray, center + motion * ray.time, radius);
                        rays.offer::<ANY>(hits, block.still.primitive[lane]);
                    }
                }
            }
            Kind::Quad => {
                let block = &blocks.quads[block.place()];
                for lane in Bits(lanes) {
                    let quad = block.splat(lane);
                    for rays in &mut self.vectors {
                        let hits = lanes::quad(&rays.setup.ray, &quad, rays.t);
                        rays.offer::<ANY>(hits, block.primitive[lane]);
                    }
                }
            }
            Kind::Triangle => {
                let block = &blocks.triangles[block.place()];
                for lane in Bits(lanes) {
                    for rays in &mut self.vectors {
                        rays.test_triangle::<ANY>(&block.vertices, lane, block.primitive[lane]);
                    }
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn vectors(&self) -> &[Rays; V] {
        &self.vectors
    }

    #[inline(always)]
    pub(super) fn vectors_mut(&mut self) -> &mut [Rays; V] {
        &mut self.vectors
    }

    /// The largest distance, times the rays' scales, that a ray still looks at: in every lane.
    #[inline(always)]
    pub(super) fn farthest(&self, scales: &[Float; V]) -> Float {
        let mut farthest = Float::splat(f32::NEG_INFINITY);
        for (rays, scale) in self.vectors.iter().zip(scales) {
            farthest = (rays.t * *scale).max(farthest);
        }
        farthest.most()
    }
}

/// What a beam asks of its rays.
impl Rays {
    /// The axis on which the first ray that is there goes fastest; `None` where none is.
    #[inline(always)]
    pub(super) fn longest_axis_of_first(&self) -> Option<usize> {
        let lane = Bits(self.setup.active).next()?;
        let speed = axes(|axis| self.setup.ray.direction[axis].to_array()[lane].abs());
        let most = if speed[0] > speed[1] { 0 } else { 1 };
        Some(if speed[2] > speed[most] { 2 } else { most })
    }

    /// How fast the rays go along `axis`, above 0; 1 for those that are not there.
    #[inline(always)]
    pub(super) fn scale(&self, axis: usize) -> Float {
        let one = Float::splat(1.0);
        self.only(one / self.setup.slab.inverse[axis].abs(), one)
    }

    /// `value` of the rays that are there, else `none`.
    #[inline(always)]
    pub(super) fn only(&self, value: Float, none: Float) -> Float {
        Mask::from_bits(self.setup.active).select(value, none)
    }

    #[inline(always)]
    pub(super) fn t_min(&self) -> Float {
        self.setup.ray.t_min
    }

    #[inline(always)]
    pub(super) fn inverse(&self, axis: usize) -> Float {
        self.setup.slab.inverse[axis]
    }

    /// Origins on an axis of direction `sign`, ahead by the slack and back by it.
    #[inline(always)]
    pub(super) fn slab_origins(&self, axis: usize, sign: Float) -> (Float, Float) {
        let origin = self.setup.ray.origin[axis] * sign;
        let slack = self.setup.slab.slack;
        (origin + slack, origin - slack)
    }
}

impl Rays {
    const NONE: Self =
        Self { setup: Setup::NONE, views: Views::NONE, t: Float::ZERO, primitive: Int::ZERO };

    #[inline(always)]
    fn load(
        rays: &RayBatch,
        first: usize,
        end: usize,
        extent: &Extent,
        wild: &mut Vec<usize>,
    ) -> Self {
        let (setup, wild_lanes) = Setup::load(rays, first, end, extent);
        wild.extend(Bits(wild_lanes).map(|lane| first + lane));
        let active = Mask::from_bits(setup.active);
        let t = active.select(setup.t_max, Float::splat(f32::NEG_INFINITY));
        let views = if extent.triangles { Views::new(&setup) } else { Views::NONE };
        Self { setup, views, t, primitive: Int::splat(HitBatch::MISS) }
    }

    /// Tests a triangle, the rays that look along one axis after the other: mostly there is one.
    #[inline(always)]
    fn test_triangle<const ANY: bool>(
        &mut self,
        vertices: &[[Lanes; 3]; 3],
        lane: usize,
        primitive: u32,
    ) {
        let (mut t, mut hit) = ([0.0; LANES], 0);
        for view in &self.views.views[..self.views.count] {
            let origin = axes(|axis| self.setup.ray.origin[view.axes[axis]]);
            let vertices = axes(|i| axes(|axis| Float::splat(vertices[i][view.axes[axis]][lane])));
            let sheared = lanes::shear_triangles(origin, self.setup.shear.shear, vertices);
            let candidates = sheared.candidates(view.rays);
            if candidates != 0 {
                sheared.decide(candidates, |lane, distance| t[lane] = distance);
                hit |= candidates;
            }
        }
        if hit != 0 {
            let t = Float::new(t);
            let hit = Mask::from_bits(hit) & t.gt(self.setup.ray.t_min);
            self.offer::<ANY>(Some(HitLanes { t, hit }), primitive);
        }
    }

    /// Keeps the hits that are closer than the closest so far, or as close with a lower index.
    #[inline(always)]
    fn offer<const ANY: bool>(&mut self, hits: Option<HitLanes>, primitive: u32) {
        let Some(HitLanes { t, hit }) = hits else { return };
        let closer = hit & t.lt(self.t);
        if ANY {
            if closer.any() {
                self.t = closer.select(Float::splat(f32::NEG_INFINITY), self.t);
                self.primitive = Int::select(closer, Int::splat(0), self.primitive);
            }
            return;
        }
        let ties = (hit & t.eq(self.t)).bits();
        if ties != 0 {
            let mut best = self.primitive.to_array();
            for lane in Bits(ties) {
                if best[lane] != HitBatch::MISS {
                    best[lane] = best[lane].min(primitive);
                }
            }
            self.primitive = Int::new(best);
        }
        self.t = closer.select(t, self.t);
        self.primitive = Int::select(closer, Int::splat(primitive), self.primitive);
    }
}

/// The signs of the rays' directions as box tests need them.
pub(super) struct Octants {
    /// Whether they differ from ray to ray on some axis.
    pub(super) mixed: bool,
    /// Where a ray (where they differ: the first) goes down an axis.
    pub(super) negative: [bool; 3],
    /// Which of a box's planes it meets first, and last.
    pub(super) near: [usize; 3],
    pub(super) far: [usize; 3],
}

impl Octants {
    #[inline(always)]
    pub(super) fn new<const V: usize>(packet: &Packet<V>) -> Self {
        let first = packet.vectors.iter().find(|rays| rays.setup.active != 0);
        let first = first.unwrap_or(&packet.vectors[0]);
        let lane = first.setup.active.trailing_zeros() % 32;
        let down = |rays: &Rays, axis: usize| rays.setup.slab.inverse[axis].lt(Float::ZERO).bits();
        let negative = axes(|axis| down(first, axis) >> lane & 1 == 1);
        let differs = |axis: usize| {
            let as_first = if negative[axis] { u32::MAX } else { 0 };
            packet
                .vectors
                .iter()
                .fold(0, |bits, rays| bits | (down(rays, axis) ^ as_first) & rays.setup.active)
                != 0
        };
        Self {
            mixed: differs(0) || differs(1) || differs(2),
            negative,
            near: axes(|axis| axis + 3 * usize::from(negative[axis])),
            far: axes(|axis| axis + 3 * usize::from(!negative[axis])),
        }
    }
}

impl Rays {
    /// Where the rays enter a box: +∞ for those that do not up to their closest hit.
    #[inline(always)]
    fn enter<const MIXED: bool>(&self, planes: &Planes, octants: &Octants) -> (Float, bool) {
        let slab = &self.setup.slab;
        let meet = |axis: usize, plane: usize| {
            Float::splat(planes[plane % 6])
                .free_mul_sub(slab.inverse[axis], slab.offsets[plane % 6])
        };
        let (mut entry, mut exit) = (self.setup.ray.t_min, self.t);
        for axis in 0..3 {
            let (near, far) = if MIXED {
                let (low, high) = (meet(axis, axis), meet(axis, axis + 3));
                (low.min(high), low.max(high))
            } else {
                (meet(axis, octants.near[axis]), meet(axis, octants.far[axis]))
            };
            (entry, exit) = (near.max(entry), far.min(exit));
        }
        let entered = entry.le(exit);
        (entered.select(entry, Float::INFINITY), entered.any())
    }
}

impl<const V: usize> Packet<V> {
    #[inline(always)]
    fn enter<const MIXED: bool>(&self, planes: &Planes, octants: &Octants) -> ([Float; V], bool) {
        let (mut entries, mut some) = ([Float::ZERO; V], false);
        for (rays, entry) in self.vectors.iter().zip(&mut entries) {
            let any;
            (*entry, any) = rays.enter::<MIXED>(planes, octants);
            some |= any;
        }
        (entries, some)
    }

    /// Visits the leaves in boxes that any ray enters, nearer boxes first.
    #[inline(always)]
    fn traverse<const ANY: bool, const MIXED: bool>(
        &mut self,
        tree: &PairTree,
        root: u32,
        octants: &Octants,
        stack: &mut [(u32, [Float; V])],
        count: &mut impl Count,
    ) {
        let (mut top, mut next) = (0, root);
        loop {
            if let Some(block) = PairTree::block(next) {
                self.test::<ANY>(&tree.blocks, block, block.valid(), count);
            } else {
                let node = &tree.nodes[next as usize];
                let (left, enter_left) = self.enter::<MIXED>(&node.planes[0], octants);
                let (right, enter_right) = self.enter::<MIXED>(&node.planes[1], octants);
                let entered = |entries: [Float; V]| {
                    let lanes = |entry: Float| entry.lt(Float::INFINITY).bits().count_ones();
                    entries.iter().map(|entry| lanes(*entry)).sum::<u32>()
                };
                count.node(2 * (V * LANES) as u32, entered(left) + entered(right));
                match (enter_left, enter_right) {
                    (true, true) => {
                        let first = usize::from(octants.negative[node.axis as usize % 3]);
                        let far = if first == 1 { left } else { right };
                        stack[top] = (node.children[1 - first], far);
                        top += 1;
                        next = node.children[first];
                        continue;
                    }
                    (true, false) => {
                        next = node.children[0];
                        continue;
                    }
                    (false, true) => {
                        next = node.children[1];
                        continue;
                    }
                    (false, false) => {}
                }
            }
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let (reference, entries) = &stack[top];
                // Pruned only when its entry is strictly beyond the best distance.
                if (0..V).any(|v| entries[v].le(self.vectors[v].t).any()) {
                    next = *reference;
                    break;
                }
            }
        }
    }
}

/// Rays to be traced, and what every one of them is tested against.
pub(super) struct Job<'a> {
    pub(super) rays: &'a RayBatch,
    /// The first of the rays, and the end.
    pub(super) ends: (usize, usize),
    pub(super) extent: &'a Extent,
    /// Blocks that every ray is tested against before the tree.
    pub(super) blocks: &'a Blocks,
    pub(super) spanning: &'a [BlockRef],
}

impl Job<'_> {
    /// Tests the rays, packet by packet, against the spanning blocks, then calls `search`.
    /// Returns the rays that it leaves to others, which are too wild for the box test.
    #[inline(always)]
    pub(super) fn trace<const ANY: bool, const V: usize, C: Count>(
        &self,
        hits: &mut HitBatch,
        count: &mut C,
        mut search: impl FnMut(&mut Packet<V>, &mut C),
    ) -> Vec<usize> {
        let (first, end) = self.ends;
        let mut wild = Vec::new();
        // Loaded in place: large values that move are copied.
        let mut packet = Packet::<V>::NONE;
        for first in (first..end).step_by(V * LANES) {
            packet.load(self.rays, first, end, self.extent, &mut wild);
            for &block in self.spanning {
                packet.test::<ANY>(self.blocks, block, block.valid(), count);
            }
            search(&mut packet, count);
            packet.store::<ANY>(first, end, hits);
        }
        wild
    }
}

/// Takes packets through the tree, if there is one. Returns the rays that it leaves to others.
pub(super) fn trace<const ANY: bool, C: Count>(
    tree: Option<&PairTree>,
    job: &Job<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    let depth = tree.map_or(0, |tree| tree.stack);
    let mut stack = vec![(0, [Float::ZERO; VECTORS]); depth];
    job.trace::<ANY, VECTORS, C>(hits, count, |packet, count| {
        let Some((tree, root)) = tree.and_then(|tree| Some((tree, tree.root?))) else { return };
        let octants = Octants::new(packet);
        if octants.mixed {
            packet.traverse::<ANY, true>(tree, root, &octants, &mut stack, count);
        } else {
            packet.traverse::<ANY, false>(tree, root, &octants, &mut stack, count);
        }
    })
}
