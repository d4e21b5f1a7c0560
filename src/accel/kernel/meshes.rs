//! Rays in the object space of an instance, which continue in the tree of its mesh.

use super::search::search;
use super::visits::Visits;
use crate::accel::counters::Count;
use crate::accel::leaf::{Meshes, NoMeshes};
use crate::accel::ray::group::Group;
use crate::accel::tree::wide::WideTree;

/// The trees of the meshes, and room to traverse them.
pub(crate) struct MeshTrees<'a> {
    trees: &'a [WideTree],
    first: u32,
    visits: Visits,
}

impl<'a> MeshTrees<'a> {
    pub(crate) fn new(tree: &'a WideTree) -> Self {
        let deepest = tree.meshes.iter().max_by_key(|mesh| mesh.depth);
        let visits = deepest.map_or(Visits::default(), Visits::for_tree);
        Self { trees: &tree.meshes, first: tree.first, visits }
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
        group: &mut Group<1>,
        ray: usize,
        count: &mut impl Count,
    ) {
        let tree = &self.trees[mesh as usize];
        search::<ANY, 1>(tree, group, 1 << ray, &mut self.visits, &mut NoMeshes, count);
    }
}
