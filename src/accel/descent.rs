//! The first levels of a wide tree, for all rays of a vector together: each goes on to its nearest
//! child, level by level, so that none waits for another's memory, or for a branch that no CPU
//! could foretell. From there rays go alone ([`super::single`]), and visit what they would have
//! visited.

use super::counters::Count;
use super::frames::{Frame, Frames};
use super::one_ray::{OneRay, Table};
use super::wide::WideTree;
use crate::simd::{Bits, LANES, Lanes};

/// Levels in large trees; in others the root alone (`profiling/`).
const LEVELS: usize = 3;

/// Where each ray is.
pub(super) struct Descent {
    /// By level, what is left of the node's children.
    frames: [[Frame; LANES]; LEVELS],
    /// The lowest level that each ray has reached.
    lowest: [usize; LANES],
}

impl Descent {
    pub(super) const NONE: Self =
        Self { frames: [[Frame::NONE; LANES]; LEVELS], lowest: [0; LANES] };

    /// Takes the rays of `lanes`, which look for hits up to `limits`, down from the root. In place:
    /// large values that are returned are copied.
    #[inline(always)]
    pub(super) fn descend(
        &mut self,
        tree: &WideTree,
        table: &Table,
        lanes: Bits,
        limits: &Lanes,
        count: &mut impl Count,
    ) {
        let Self { frames, lowest } = self;
        for lane in lanes {
            frames[0][lane] = OneRay::new(table, lane).enter(tree, 0, limits[lane], count);
            if tree.is_large {
                tree.prefetch(frames[0][lane].nearest(tree));
            }
        }
        if tree.is_large {
            for level in 1..LEVELS {
                for lane in lanes {
                    if lowest[lane] + 1 == level
                        && let Some(node) = frames[level - 1][lane].take_node(tree, limits[lane])
                    {
                        let one = OneRay::new(table, lane);
                        frames[level][lane] = one.enter(tree, node, limits[lane], count);
                        lowest[lane] = level;
                        tree.prefetch(frames[level][lane].nearest(tree));
                    }
                }
            }
        }
    }

    /// The frame where the ray of `lane` is; those before it come to lie `above`.
    #[inline(always)]
    pub(super) fn resume(&self, tree: &WideTree, lane: usize, above: &mut Frames) -> Frame {
        let lowest = self.lowest[lane];
        above.clear();
        for frames in &self.frames[..lowest] {
            above.push(&frames[lane], tree, false);
        }
        self.frames[lowest][lane]
    }
}
