//! Rays in the object space of an instance, which continue in the tree of its mesh.

use super::stream::{Visit, search, visits};
use crate::accel::counters::Count;
use crate::accel::leaf::{Meshes, NoMeshes};
use crate::accel::ray::best::{Best, BestLanes};
use crate::accel::ray::one_ray::OneRay;
use crate::accel::tree::wide::WideTree;

/// The trees of the meshes, and room to traverse them.
pub(crate) struct MeshTrees<'a> {
    trees: &'a [WideTree],
    first: u32,
    open: Vec<Visit>,
}

impl<'a> MeshTrees<'a> {
    pub(crate) fn new(tree: &'a WideTree) -> Self {
        let deepest = tree.meshes.iter().max_by_key(|mesh| mesh.depth);
        let open = deepest.map_or(Vec::new(), visits);
        Self { trees: &tree.meshes, first: tree.first, open }
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
    fn trace<const ANY: bool>(
        &mut self,
        mesh: u32,
        one: &OneRay<'_>,
        best: &mut Best,
        count: &mut impl Count,
    ) {
        let (tree, ray) = (&self.trees[mesh as usize], 1 << one.lane);
        let mut lanes = [BestLanes::NONE];
        lanes[0].set(one.lane, *best);
        let tables = std::array::from_ref(one.table);
        search::<ANY, 1>(tree, tables, &mut lanes, ray, &mut self.open, &mut NoMeshes, count);
        *best = lanes[0].lane(one.lane);
    }
}
