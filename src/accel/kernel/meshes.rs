//! Rays in the object space of an instance, which continue in the tree of its mesh.

use super::enter::next_block;
use super::frames::Frames;
use crate::accel::counters::Count;
use crate::accel::leaf::{Meshes, NoMeshes};
use crate::accel::ray::best::Best;
use crate::accel::ray::one_ray::OneRay;
use crate::accel::ray::rays::Rays;
use crate::accel::tree::wide::WideTree;
use crate::simd::{Int, LANES, Lanes};

/// The trees of the meshes, and room to traverse them.
pub(crate) struct MeshTrees<'a> {
    trees: &'a [WideTree],
    first: u32,
    above: Frames,
    /// The instances of the closest hits of a vector of rays.
    instances: Lanes<u32>,
}

impl<'a> MeshTrees<'a> {
    pub(crate) fn new(tree: &'a WideTree) -> Self {
        let deepest = tree.meshes.iter().map(|mesh| mesh.depth).max().unwrap_or(0);
        Self {
            trees: &tree.meshes,
            first: tree.first,
            above: Frames::with_depth(deepest),
            instances: [0; LANES],
        }
    }
}

impl Meshes for MeshTrees<'_> {
    #[inline(always)]
    fn some(&self) -> bool {
        true
    }

    #[inline(always)]
    fn first(&self) -> u32 {
        self.first
    }

    #[inline(always)]
    fn instance(&mut self, lane: usize) -> &mut u32 {
        &mut self.instances[lane]
    }

    #[inline(always)]
    fn load(&mut self, rays: &Rays) {
        self.instances = rays.instance.to_array();
    }

    #[inline(always)]
    fn store(&self, rays: &mut Rays) {
        rays.instance = Int::new(self.instances);
    }

    #[inline(always)]
    fn trace<const ANY: bool>(
        &mut self,
        mesh: u32,
        one: &OneRay<'_>,
        best: &mut Best,
        count: &mut impl Count,
    ) {
        let (tree, above) = (&self.trees[mesh as usize], &mut self.above);
        above.clear();
        let mut frame = one.enter(tree, 0, best.t, count);
        while let Some(block) =
            next_block(&mut frame, tree, one, best.t, above, tree.is_large, count)
        {
            tree.blocks.test_one::<ANY>(block, one, best, &mut NoMeshes, count);
            if ANY && best.found() {
                return;
            }
        }
    }
}
