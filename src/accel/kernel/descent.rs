//! Traversal of the first levels of a wide tree, for all rays of a vector together.
//!
//! At each level, every ray descends to its nearest child, so that the rays' waits for memory and
//! for branches overlap. After these levels, the rays continue one by one ([`super::single`]). Each
//! visits the same nodes as if it had been traced alone from the root.

use super::frames::{Frame, Frames};
use crate::accel::counters::Count;
use crate::accel::ray::one_ray::{OneRay, Table};
use crate::accel::tree::wide::WideTree;
use crate::simd::{Bits, LANES, Lanes};

/// Number of levels that the rays descend together in large trees. In other trees, they share only
/// the root (`profiling/measured.md`).
const LEVELS: usize = 3;

/// The state of each ray after the first levels.
pub(crate) struct Descent {
    /// For each level and lane, the children of the visited node that are still to be visited.
    frames: [[Frame; LANES]; LEVELS],
    /// The deepest level that each ray has reached.
    lowest: [usize; LANES],
}

impl Descent {
    pub(crate) const NONE: Self =
        Self { frames: [[Frame::NONE; LANES]; LEVELS], lowest: [0; LANES] };

    /// Moves the rays of `lanes`, which search for hits up to `limits`, down from the root. Call
    /// this once, on [`Self::NONE`]. It writes in place, since returning large values copies them.
    #[inline(always)]
    pub(crate) fn descend(
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
        if !tree.is_large {
            return;
        }
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

    /// Returns the frame of the deepest node that the ray of `lane` has reached, and pushes the
    /// frames of the nodes above it onto `above`.
    #[inline(always)]
    pub(crate) fn resume(&self, tree: &WideTree, lane: usize, above: &mut Frames) -> Frame {
        let lowest = self.lowest[lane];
        above.clear();
        for frames in &self.frames[..lowest] {
            above.push(&frames[lane], tree, false);
        }
        self.frames[lowest][lane]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::RayBatch;
    use crate::accel::counters::Counters;
    use crate::accel::leaf::BlockRef;
    use crate::accel::setup::{Extent, Setup};
    use crate::accel::tree::binary::BinaryTree;
    use crate::geometry::{Bounds, Geometry, Ray, Sphere};
    use crate::math::random::Stream;
    use crate::simd::first_bits;
    use glam::Vec3;

    /// Returns all nodes and blocks that a ray visits from `frame` on, if it hits nothing.
    fn visits(
        tree: &WideTree,
        one: &OneRay<'_>,
        limit: f32,
        mut frame: Frame,
        above: &mut Frames,
        count: &mut Counters,
    ) -> Vec<u32> {
        let mut visits = Vec::new();
        while let Some(child) = above.next(&mut frame, tree, limit) {
            visits.push(child);
            if child & BlockRef::LEAF == 0 {
                above.push(&frame, tree, false);
                frame = one.enter(tree, child, limit, count);
            }
        }
        visits
    }

    #[test]
    fn rays_visit_the_same_nodes_as_alone() {
        let mut random = Stream::new(23);
        let mut point = |size: f32| Vec3::from_array([(); 3].map(|()| random.between(-size, size)));
        let spheres = (0..LANES.pow(3)).map(|_| Sphere::still(point(1.0), 0.1)).collect();
        let geometry = Geometry { spheres, ..Geometry::default() };
        let boxes = geometry.boxes();
        let all = boxes.iter().fold(Bounds::EMPTY, |all, bounds| all.union(*bounds));
        let primitives: Vec<u32> = (0..geometry.len() as u32).collect();
        let mut tree = WideTree::new(&geometry, &BinaryTree::new(&boxes, &primitives, 1));
        let extent = Extent::new(&geometry, all, all);
        let mut above = Frames::with_depth(tree.depth);
        let mut reached = [0; LEVELS];
        for round in 0..200 {
            tree.is_large = round % 4 > 0;
            let mut batch = RayBatch::default();
            for _ in 0..LANES {
                let ray = Ray { origin: point(1.5), direction: point(1.0), time: 0.0 };
                batch.push(&ray, 0.0, f32::INFINITY);
            }
            let mut setup = Setup::NONE;
            assert_eq!(setup.load(&batch.vector(0), first_bits(LANES), &extent), 0);
            let table = Table::new(&setup);
            let limits: Lanes = std::array::from_fn(|lane| match (lane + round) % 4 {
                0 => f32::NEG_INFINITY,
                1 => 1.0,
                _ => f32::INFINITY,
            });
            let lanes = first_bits(LANES) & !(1 << (round % LANES));
            let (mut together, mut alone) = (Counters::default(), Counters::default());
            let mut descent = Descent::NONE;
            descent.descend(&tree, &table, Bits(lanes), &limits, &mut together);
            for lane in Bits(lanes) {
                let (one, limit) = (OneRay::new(&table, lane), limits[lane]);
                above.clear();
                let root = one.enter(&tree, 0, limit, &mut alone);
                let want = visits(&tree, &one, limit, root, &mut above, &mut alone);
                let lowest = descent.lowest[lane];
                reached[lowest] += 1;
                let frame = descent.resume(&tree, lane, &mut above);
                let rest = visits(&tree, &one, limit, frame, &mut above, &mut together);
                assert_eq!(want[lowest..], rest);
                assert!(want[..lowest].iter().all(|node| node & BlockRef::LEAF == 0));
            }
            assert_eq!(together, alone);
        }
        assert!(reached.iter().all(|&rays| rays > 20), "{reached:?}");
    }
}
