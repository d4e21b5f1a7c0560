//! Leaf blocks: up to [`LANES`] primitives of one kind, structure-of-arrays.

use std::mem::take;

use glam::Vec3;

use super::huge_pages::settle;
use crate::geometry::lanes::{QuadLanes, SpecialQuad};
use crate::geometry::{Geometry, Shape};
use crate::simd::{Float, LANES, Lanes, Vec3x, prefetch};

/// A block: its kind, the number of its primitives, and its index among the blocks of that
/// kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BlockRef(u32);

impl BlockRef {
    /// Set in every reference, so that a node's children can be told from blocks.
    pub(super) const LEAF: u32 = 1 << 31;
    /// For places that no block is in yet.
    pub(super) const NONE: Self = Self(Self::LEAF);
    const KIND_SHIFT: u32 = 29;
    const COUNT_SHIFT: u32 = 25;

    fn new(kind: Shape, count: usize, index: usize) -> Self {
        assert!(index < 1 << Self::COUNT_SHIFT, "more blocks than a reference can name");
        let count = (count as u32 - 1) << Self::COUNT_SHIFT;
        Self(Self::LEAF | (kind as u32) << Self::KIND_SHIFT | count | index as u32)
    }

    pub(super) fn bits(self) -> u32 {
        self.0
    }

    /// The reference with these bits, among them [`BlockRef::LEAF`].
    #[inline(always)]
    pub(super) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    #[inline(always)]
    pub(super) fn kind(self) -> Shape {
        Shape::ALL[(self.0 >> Self::KIND_SHIFT & 3) as usize]
    }

    #[inline(always)]
    pub(super) fn count(self) -> u32 {
        (self.0 >> Self::COUNT_SHIFT & 15) + 1
    }

    /// The lanes that hold a primitive: the first ones, by ascending index.
    #[inline(always)]
    pub(super) fn valid(self) -> u32 {
        (2 << (self.0 >> Self::COUNT_SHIFT & 15)) - 1
    }

    #[inline(always)]
    pub(super) fn index(self) -> usize {
        (self.0 & ((1 << Self::COUNT_SHIFT) - 1)) as usize
    }
}

/// Still spheres. Lanes without a primitive hold NaN, here and below.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct SphereBlock {
    pub(super) center: [Lanes; 3],
    pub(super) radius: Lanes,
    pub(super) primitive: Lanes<u32>,
}

/// Moving spheres.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct MovingSphereBlock {
    pub(super) still: SphereBlock,
    pub(super) motion: [Lanes; 3],
}

/// Quads.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct QuadBlock {
    q: [Lanes; 3],
    normal: [Lanes; 3],
    dual_u: [Lanes; 3],
    dual_v: [Lanes; 3],
    pub(super) primitive: Lanes<u32>,
}

/// Triangles.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct TriangleBlock {
    pub(super) vertices: [[Lanes; 3]; 3],
    pub(super) primitive: Lanes<u32>,
}

impl QuadBlock {
    /// A quad in each lane.
    #[inline(always)]
    pub(super) fn lanes(&self) -> QuadLanes {
        self.with(Vec3x::of_lanes)
    }

    /// One quad in every lane.
    #[inline(always)]
    pub(super) fn splat(&self, lane: usize) -> QuadLanes {
        self.with(|lanes| Vec3x::splat_lane(lanes, lane))
    }

    #[inline(always)]
    fn with(&self, vector: impl Fn(&[Lanes; 3]) -> Vec3x) -> QuadLanes {
        QuadLanes {
            q: vector(&self.q),
            normal: vector(&self.normal),
            dual_u: vector(&self.dual_u),
            dual_v: vector(&self.dual_v),
        }
    }
}

impl MovingSphereBlock {
    /// Centres at `time`, of the sphere in each lane.
    #[inline(always)]
    pub(super) fn centers(&self, time: Float) -> Vec3x {
        Vec3x::of_lanes(&self.still.center) + Vec3x::of_lanes(&self.motion) * time
    }
}

/// The blocks of a layout.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    pub(super) spheres: Vec<SphereBlock>,
    pub(super) moving_spheres: Vec<MovingSphereBlock>,
    pub(super) quads: Vec<QuadBlock>,
    /// For each block of quads those that need less work, for packets: single rays have no use
    /// for them, and should not wait for their memory.
    pub(super) special: Vec<[Option<SpecialQuad>; LANES]>,
    pub(super) triangles: Vec<TriangleBlock>,
}

impl Blocks {
    /// Adds a block of `primitives`: 1 to [`LANES`], of one kind.
    pub(super) fn push(&mut self, geometry: &Geometry, primitives: &mut [u32]) -> BlockRef {
        // Ties go to the lowest index, and so to the lowest lane.
        primitives.sort_unstable();
        let mut primitive = [u32::MAX; LANES];
        primitive[..primitives.len()].copy_from_slice(primitives);
        let kind = Shape::of(geometry.get(primitives[0]));
        let spheres = || primitives.iter().map(|&p| &geometry.spheres[p as usize]);
        let index = match kind {
            Shape::Sphere => {
                self.spheres.push(SphereBlock {
                    // 0 + −0 is 0, as where a motion of 0 is added.
                    center: transpose(spheres().map(|s| s.center + Vec3::ZERO)),
                    radius: gather(spheres().map(|s| s.radius)),
                    primitive,
                });
                self.spheres.len() - 1
            }
            Shape::MovingSphere => {
                self.moving_spheres.push(MovingSphereBlock {
                    still: SphereBlock {
                        center: transpose(spheres().map(|s| s.center)),
                        radius: gather(spheres().map(|s| s.radius)),
                        primitive,
                    },
                    motion: transpose(spheres().map(|s| s.motion())),
                });
                self.moving_spheres.len() - 1
            }
            Shape::Quad => {
                let first = geometry.spheres.len();
                let quads = || primitives.iter().map(|&p| &geometry.quads[p as usize - first]);
                self.quads.push(QuadBlock {
                    q: transpose(quads().map(|quad| quad.q)),
                    normal: transpose(quads().map(|quad| quad.normal)),
                    dual_u: transpose(quads().map(|quad| quad.duals()[0])),
                    dual_v: transpose(quads().map(|quad| quad.duals()[1])),
                    primitive,
                });
                let mut special = [const { None }; LANES];
                special.iter_mut().zip(quads()).for_each(|(to, quad)| *to = SpecialQuad::new(quad));
                self.special.push(special);
                self.quads.len() - 1
            }
            Shape::Triangle => {
                let first = geometry.spheres.len() + geometry.quads.len();
                let vertex = |i: usize| {
                    let of = |&p: &u32| geometry.triangles[p as usize - first].vertices[i];
                    transpose(primitives.iter().map(of))
                };
                let vertices = [vertex(0), vertex(1), vertex(2)];
                self.triangles.push(TriangleBlock { vertices, primitive });
                self.triangles.len() - 1
            }
        };
        BlockRef::new(kind, primitives.len(), index)
    }

    /// Adds blocks of `primitives` in any number and mixture.
    pub(super) fn push_all(&mut self, geometry: &Geometry, primitives: &[u32]) -> Vec<BlockRef> {
        let mut primitives = primitives.to_vec();
        primitives.sort_by_key(|&p| (Shape::of(geometry.get(p)) as u32, p));
        primitives
            .chunk_by_mut(|&a, &b| Shape::of(geometry.get(a)) == Shape::of(geometry.get(b)))
            .flat_map(|run| run.chunks_mut(LANES))
            .map(|block| self.push(geometry, block))
            .collect()
    }

    /// To be called when all blocks are there.
    pub(super) fn settle(&mut self) {
        self.spheres = settle(take(&mut self.spheres));
        self.moving_spheres = settle(take(&mut self.moving_spheres));
        self.quads = settle(take(&mut self.quads));
        self.special = settle(take(&mut self.special));
        self.triangles = settle(take(&mut self.triangles));
    }

    /// Asks for the memory of a block.
    #[inline(always)]
    pub(super) fn prefetch(&self, block: BlockRef) {
        match block.kind() {
            Shape::Sphere => prefetch(&self.spheres[block.index()]),
            Shape::MovingSphere => prefetch(&self.moving_spheres[block.index()]),
            Shape::Quad => prefetch(&self.quads[block.index()]),
            Shape::Triangle => prefetch(&self.triangles[block.index()]),
        }
    }

    /// Size in memory.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.spheres)
            + size_of_val(&*self.moving_spheres)
            + size_of_val(&*self.quads)
            + size_of_val(&*self.special)
            + size_of_val(&*self.triangles)
    }
}

fn gather(values: impl Iterator<Item = f32>) -> Lanes {
    let mut lanes = [f32::NAN; LANES];
    lanes.iter_mut().zip(values).for_each(|(lane, value)| *lane = value);
    lanes
}

fn transpose(vectors: impl Iterator<Item = Vec3> + Clone) -> [Lanes; 3] {
    [0, 1, 2].map(|axis| gather(vectors.clone().map(|v| v[axis])))
}
