//! Leaf blocks: up to [`LANES`] primitives of one shape in structure-of-arrays form.
//!
//! Each shape has a file of its own.

mod instance;
mod moving_sphere;
mod quad;
mod sphere;
mod triangle;

use std::mem::take;

use glam::Vec3;

use super::counters::Count;
use super::ray::best::Best;
use super::ray::one_ray::OneRay;
use super::ray::packet::Packet;
use super::ray::ray_group::{Members, RayGroup};
use crate::geometry::{Geometry, Ray, Shape, match_shape, shapes};
use crate::huge_pages::{reserve, settle};
use crate::simd::{Float, LANES, Lanes, prefetch};

/// A reference to a block: its shape, the number of its primitives, and its index among the blocks
/// of that shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LeafRef(u32);

impl LeafRef {
    /// The bit that distinguishes a reference to a block from the index of a node.
    pub(super) const LEAF: u32 = 1 << 31;
    const SHAPE_SHIFT: u32 = 28;
    const COUNT_SHIFT: u32 = 24;
    /// The shape has 3 bits and the count 4.
    const FITS: () = assert!(Shape::ALL.len() <= 8 && LANES <= 16);

    fn new(shape: Shape, count: usize, index: usize) -> Self {
        let () = Self::FITS;
        assert!(index < 1 << Self::COUNT_SHIFT, "a layout holds at most 2^24 blocks of a shape");
        let count = (count as u32 - 1) << Self::COUNT_SHIFT;
        Self(Self::LEAF | (shape as u32) << Self::SHAPE_SHIFT | count | index as u32)
    }

    /// The reference to the same block in a list in which `blocks` blocks of each shape come first.
    pub(super) fn moved(self, blocks: &[usize; Shape::ALL.len()]) -> Self {
        Self::new(self.shape(), self.count() as usize, self.index() + blocks[self.shape() as usize])
    }

    pub(super) fn bits(self) -> u32 {
        self.0
    }

    /// Returns the reference with these bits, which must include [`LeafRef::LEAF`].
    #[inline(always)]
    pub(super) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    #[inline(always)]
    pub(super) fn shape(self) -> Shape {
        self.shape_of(true)
    }

    /// The shape; if `instances` is false, there must be no instances. The compiler then omits
    /// their code.
    #[inline(always)]
    fn shape_of(self, instances: bool) -> Shape {
        const { assert!(Shape::Instance as u32 == 4) };
        Shape::of_bits(self.0 >> Self::SHAPE_SHIFT & if instances { 7 } else { 3 })
    }

    #[inline(always)]
    pub(super) fn count(self) -> u32 {
        (self.0 >> Self::COUNT_SHIFT & 15) + 1
    }

    /// Bits of the lanes that hold a primitive. These are the first lanes, in the order of the
    /// primitives' indices.
    #[inline(always)]
    pub(super) fn valid(self) -> u32 {
        (2 << (self.0 >> Self::COUNT_SHIFT & 15)) - 1
    }

    #[inline(always)]
    pub(super) fn index(self) -> usize {
        (self.0 & ((1 << Self::COUNT_SHIFT) - 1)) as usize
    }
}

/// Up to this many rays that visit a block together are few: they have little in common, so CPUs cannot
/// predict what they hit. Rays in instances are always alone. Twice this number is as fast on average, but
/// slower in scans.
const FEW: u32 = 8;

/// Up to [`LANES`] primitives of one shape, in structure-of-arrays form.
trait Leaf: Sized {
    /// Creates the block of these primitives. Lanes without a primitive hold NaN.
    fn new(geometry: &Geometry, primitives: &[u32]) -> Self;

    /// Returns the boxes of the primitives, if they are cheaper to test than the primitives.
    #[inline(always)]
    fn bounds(&self) -> Option<[[Float; 3]; 2]> {
        None
    }

    /// Tests one ray against all primitives. `valid` has the bits of their lanes. If `ANY` is set,
    /// any hit suffices. `few` tells that few rays are tested together. It affects only speed.
    fn test_one<const ANY: bool>(
        &self,
        valid: u32,
        few: bool,
        one: &OneRay<'_>,
        best: &mut Best,
        meshes: &mut impl Meshes,
        count: &mut impl Count,
    );

    /// Tests the rays of `packet` against the primitives in `lanes`, one after the other.
    ///
    /// `ALL_MISS` tells that often all rays of the packet miss a primitive, as coherent rays and shadow
    /// rays do, so that a branch on this pays. `SPANNING` tells that no box around the
    /// block was tested first, because most of its primitives are huge. Both affect only speed.
    fn test_packet<const V: usize, const ANY: bool, const ALL_MISS: bool, const SPANNING: bool>(
        &self,
        lanes: u32,
        packet: &mut Packet<V>,
        meshes: &mut impl Meshes,
        count: &mut impl Count,
    );
}

/// The meshes that instances place, and the holes of triangles.
pub(super) trait Meshes {
    /// Whether there can be instances. Kernels are compiled for both cases, because a call that
    /// gets a reference to a packet keeps all of it in memory.
    fn some(&self) -> bool;

    /// The number of the first triangle of a mesh among all primitives.
    fn first(&self) -> u32;

    /// Whether triangles may have holes.
    #[inline(always)]
    fn may_have_holes(&self) -> bool {
        false
    }

    /// Whether a hit of triangle `primitive` at distance `t` along `ray` is in a hole, and does not count.
    #[inline(always)]
    fn is_hole(&self, _primitive: u32, _ray: impl FnOnce() -> Ray, _t: f32) -> bool {
        false
    }

    /// Traces one of the rays of `group`, which are in the object spaces of instances, through the mesh
    /// and the instance of `place`. Primitives are counted from the first triangle of all meshes.
    fn trace<const ANY: bool>(
        &mut self,
        place: (u32, u32),
        group: &mut RayGroup<1>,
        ray: usize,
        count: &mut impl Count,
    );
}

/// The meshes of a layout without instances and holes.
pub(super) struct NoMeshes;

impl Meshes for NoMeshes {
    fn some(&self) -> bool {
        false
    }

    fn first(&self) -> u32 {
        unreachable!("this layout has no instances")
    }

    fn trace<const ANY: bool>(
        &mut self,
        _: (u32, u32),
        _: &mut RayGroup<1>,
        _: usize,
        _: &mut impl Count,
    ) {
        unreachable!("this layout has no instances")
    }
}

macro_rules! blocks {
    ($($name:ident in $module:ident,)*) => {
        /// The blocks of a layout, in one table for each shape.
        #[derive(Clone, Debug, Default)]
        pub(super) struct LeafBlocks {
            $($module: Vec<$module::LeafBlock>,)*
        }

        impl LeafBlocks {
            /// Adds a block of `primitives`, which must be 1 to [`LANES`] of one shape.
            pub(super) fn push(&mut self, geometry: &Geometry, primitives: &mut [u32]) -> LeafRef {
                // Ties go to the lowest index. Sorting puts it into the lowest lane.
                primitives.sort_unstable();
                let shape = geometry.shape(primitives[0]);
                match shape {
                    $(Shape::$name => self.$module.push(Leaf::new(geometry, primitives)),)*
                }
                LeafRef::new(shape, primitives.len(), self.counts()[shape as usize] - 1)
            }

            /// Appends the blocks of `other`. `growth` estimates the ratio of the final number of
            /// blocks to the number after this call.
            pub(super) fn append(&mut self, other: Self, growth: f64) {
                $(
                    reserve(&mut self.$module, other.$module.len(), growth);
                    self.$module.extend(other.$module);
                )*
            }

            /// Moves the blocks to huge pages. Call this after the last block has been added.
            pub(super) fn settle(&mut self) {
                $(self.$module = settle(take(&mut self.$module));)*
            }
        }
    };
}

shapes!(blocks);

impl LeafBlocks {
    /// Adds blocks for any number of `primitives`, whose shapes may be mixed.
    pub(super) fn push_all(&mut self, geometry: &Geometry, primitives: &[u32]) -> Vec<LeafRef> {
        let mut primitives = primitives.to_vec();
        primitives.sort_by_key(|&p| (geometry.shape(p) as u32, p));
        primitives
            .chunk_by_mut(|&a, &b| geometry.shape(a) == geometry.shape(b))
            .flat_map(|run| run.chunks_mut(LANES))
            .map(|block| self.push(geometry, block))
            .collect()
    }

    /// The number of blocks of each shape.
    pub(super) fn counts(&self) -> [usize; Shape::ALL.len()] {
        Shape::ALL.map(|shape| match_shape!(shape, self, |blocks| blocks.len()))
    }

    /// Size in memory.
    pub(super) fn bytes(&self) -> usize {
        let bytes = |shape| match_shape!(shape, self, |blocks| size_of_val(&**blocks));
        Shape::ALL.map(bytes).iter().sum()
    }

    /// Prefetches a block.
    #[inline(always)]
    pub(super) fn prefetch(&self, block: LeafRef) {
        match_shape!(block.shape(), self, |blocks| prefetch(&blocks[block.index()]));
    }

    /// Returns the boxes of a block's primitives, if they are cheaper to test than the primitives.
    #[inline(always)]
    pub(super) fn bounds(&self, block: LeafRef) -> Option<[[Float; 3]; 2]> {
        match_shape!(block.shape(), self, |blocks| blocks[block.index()].bounds())
    }

    /// Tests the `rays` of `group`, one after the other, against all primitives of a block. They
    /// enter its box at a distance of at least `distance`. If `ANY` is set, returns the set of those
    /// that hit.
    #[inline(always)]
    pub(super) fn test_group<const ANY: bool, const V: usize>(
        &self,
        block: LeafRef,
        group: &mut RayGroup<V>,
        rays: u32,
        distance: f32,
        meshes: &mut impl Meshes,
        count: &mut impl Count,
    ) -> u32 {
        let (mut found, valid, few) = (0, block.valid(), rays.count_ones() <= FEW);
        match_shape!(block.shape_of(meshes.some()), self, |blocks| {
            let leaf = &blocks[block.index()];
            for ray in Members(rays) {
                let mut best = group.best(ray);
                if !ANY && distance > best.t {
                    continue;
                }
                count.leaf(LANES as u32, block.count());
                leaf.test_one::<ANY>(valid, few, &group.ray(ray), &mut best, meshes, count);
                group.set_best(ray, best);
                if ANY {
                    found |= u32::from(best.found()) << ray;
                }
            }
        });
        found
    }

    /// Tests the rays of `packet` against those primitives of a block that are in `lanes`. See
    /// [`Leaf::test_packet`].
    #[inline(always)]
    pub(super) fn test_packet<
        const V: usize,
        const ANY: bool,
        const ALL_MISS: bool,
        const SPANNING: bool,
    >(
        &self,
        block: LeafRef,
        lanes: u32,
        packet: &mut Packet<V>,
        meshes: &mut impl Meshes,
        count: &mut impl Count,
    ) {
        match_shape!(block.shape_of(meshes.some()), self, |blocks| {
            let leaf = &blocks[block.index()];
            leaf.test_packet::<V, ANY, ALL_MISS, SPANNING>(lanes, packet, meshes, count);
        });
    }
}

/// Counts the tests of the primitives in `lanes`, each against all rays of `packet`.
#[inline(always)]
fn count_tests<const V: usize>(packet: &Packet<V>, lanes: u32, count: &mut impl Count) {
    for rays in &packet.vectors {
        let looking = rays.looking().count_ones();
        (0..lanes.count_ones()).for_each(|_| count.leaf(LANES as u32, looking));
    }
}

/// Returns the primitive in each lane of a block, `u32::MAX` if the lane is empty.
fn numbers(primitives: &[u32]) -> Lanes<u32> {
    let mut numbers = [u32::MAX; LANES];
    numbers[..primitives.len()].copy_from_slice(primitives);
    numbers
}

fn gather(values: impl Iterator<Item = f32>) -> Lanes {
    let mut lanes = [f32::NAN; LANES];
    lanes.iter_mut().zip(values).for_each(|(lane, value)| *lane = value);
    lanes
}

fn transpose(vectors: impl Iterator<Item = Vec3> + Clone) -> [Lanes; 3] {
    [0, 1, 2].map(|axis| gather(vectors.clone().map(|v| v[axis])))
}
