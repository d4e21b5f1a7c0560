//! References to leaf blocks, as nodes of trees store them.

use crate::geometry::Shape;
use crate::simd::LANES;

/// A reference to a block: its shape, the number of its primitives, and its index among the blocks
/// of that shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::accel) struct LeafRef(u32);

impl LeafRef {
    /// The bit that distinguishes a reference to a block from the index of a node.
    pub(in crate::accel) const LEAF: u32 = 1 << 31;
    const SHAPE_SHIFT: u32 = 28;
    const COUNT_SHIFT: u32 = 24;
    /// The shape has 3 bits and the count 4.
    const FITS: () = assert!(Shape::ALL.len() <= 8 && LANES <= 16);

    pub(super) fn new(shape: Shape, count: usize, index: usize) -> Self {
        let () = Self::FITS;
        assert!(index < 1 << Self::COUNT_SHIFT, "a layout holds at most 2^24 blocks of a shape");
        let count = (count as u32 - 1) << Self::COUNT_SHIFT;
        Self(Self::LEAF | (shape as u32) << Self::SHAPE_SHIFT | count | index as u32)
    }

    /// The reference to the same block in a list in which `blocks` blocks of each shape come first.
    pub(in crate::accel) fn moved(self, blocks: &[usize; Shape::ALL.len()]) -> Self {
        Self::new(self.shape(), self.count() as usize, self.index() + blocks[self.shape() as usize])
    }

    pub(in crate::accel) fn bits(self) -> u32 {
        self.0
    }

    /// Returns the reference with these bits, which must include [`LeafRef::LEAF`].
    #[inline(always)]
    pub(in crate::accel) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    #[inline(always)]
    pub(in crate::accel) fn shape(self) -> Shape {
        self.shape_of(true)
    }

    /// The shape; if `instances` is false, there must be no instances. The compiler then omits
    /// their code.
    #[inline(always)]
    pub(super) fn shape_of(self, instances: bool) -> Shape {
        const { assert!(Shape::Instance as u32 == 4) };
        Shape::of_bits(self.0 >> Self::SHAPE_SHIFT & if instances { 7 } else { 3 })
    }

    #[inline(always)]
    pub(in crate::accel) fn count(self) -> u32 {
        (self.0 >> Self::COUNT_SHIFT & 15) + 1
    }

    /// Bits of the lanes that hold a primitive. These are the first lanes, in the order of the
    /// primitives' indices.
    #[inline(always)]
    pub(in crate::accel) fn valid(self) -> u32 {
        (2 << (self.0 >> Self::COUNT_SHIFT & 15)) - 1
    }

    #[inline(always)]
    pub(in crate::accel) fn index(self) -> usize {
        (self.0 & ((1 << Self::COUNT_SHIFT) - 1)) as usize
    }
}
