//! Rays in the object space of an instance, which continue in the tree of its mesh, and holes.

use super::search::search;
use super::visits::Visits;
use crate::accel::ray::RayGroup;
use crate::accel::tree::wide::WideTree;
use crate::accel::{Count, Meshes, NoMeshes};
use crate::geometry::{Geometry, Ray};

/// The trees of the meshes, room to traverse them, and the holes of triangles.
pub(crate) struct MeshTrees<'a> {
    trees: &'a [WideTree],
    first: u32,
    visits: Visits,
    /// The geometry, if its triangles or those of the meshes may have holes.
    holes: Option<&'a Geometry>,
}

impl<'a> MeshTrees<'a> {
    pub(crate) fn new(tree: &'a WideTree) -> Self {
        let deepest = tree.meshes.iter().max_by_key(|mesh| mesh.depth);
        let visits = deepest.map_or(Visits::default(), Visits::for_tree);
        Self { trees: &tree.meshes, first: tree.first, visits, holes: tree.holes.as_deref() }
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
    fn may_have_holes(&self) -> bool {
        self.holes.is_some()
    }

    #[inline(always)]
    fn is_hole(&self, primitive: u32, ray: impl FnOnce() -> Ray, t: f32) -> bool {
        self.holes.is_some_and(|geometry| geometry.is_hole(primitive, 0, &ray(), t))
    }

    #[inline(always)]
    fn trace<const ANY: bool>(
        &mut self,
        (mesh, instance): (u32, u32),
        group: &mut RayGroup<1>,
        ray: usize,
        count: &mut impl Count,
    ) {
        let tree = &self.trees[mesh as usize];
        let holes = self.holes.map(|geometry| &**geometry.instances.triangles());
        let mut within = WithinInstance { holes, instance };
        self.visits.start(1 << ray);
        search::<ANY, 1>(tree, group, 1 << ray, &mut self.visits, &mut within, count);
    }
}

/// The holes of the triangles of an instance. They contain no other instances.
struct WithinInstance<'a> {
    holes: Option<&'a Geometry>,
    instance: u32,
}

impl Meshes for WithinInstance<'_> {
    #[inline(always)]
    fn some(&self) -> bool {
        false
    }

    fn first(&self) -> u32 {
        NoMeshes.first()
    }

    #[inline(always)]
    fn may_have_holes(&self) -> bool {
        self.holes.is_some()
    }

    #[inline(always)]
    fn is_hole(&self, primitive: u32, ray: impl FnOnce() -> Ray, t: f32) -> bool {
        self.holes.is_some_and(|geometry| geometry.is_hole(primitive, self.instance, &ray(), t))
    }

    fn trace<const ANY: bool>(
        &mut self,
        mesh: (u32, u32),
        group: &mut RayGroup<1>,
        ray: usize,
        count: &mut impl Count,
    ) {
        NoMeshes.trace::<ANY>(mesh, group, ray, count);
    }
}
