//! Leaf blocks: up to [`LANES`] primitives of one shape in structure-of-arrays form.
//!
//! Each shape has a file of its own.

mod instance;
mod meshes;
mod moving_sphere;
mod quad;
mod reference;
mod sphere;
mod triangle;

use std::mem::take;

use glam::Vec3;

pub(super) use self::meshes::{Meshes, NoMeshes};
pub(super) use self::reference::LeafRef;
use super::Count;
use super::ray::{Best, Members, OneRay, Packet, RayGroup};
use crate::geometry::{Geometry, Shape, match_shape, shapes};
use crate::huge_pages::{reserve, settle};
use crate::simd::{Float, LANES, Lanes, prefetch};

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
    /// any hit suffices. `few` is set if few rays are tested together. It affects only speed.
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
    /// `ALL_MISS` is set if often all rays of the packet miss a primitive, as coherent rays and shadow
    /// rays do, so that a branch on this pays. `SPANNING` is set if no box around the block was tested
    /// first, because most of its primitives are huge. Both affect only speed.
    fn test_packet<const V: usize, const ANY: bool, const ALL_MISS: bool, const SPANNING: bool>(
        &self,
        lanes: u32,
        packet: &mut Packet<V>,
        meshes: &mut impl Meshes,
        count: &mut impl Count,
    );
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
