//! The meshes of a scene, and their instances.

use std::ops::Range;
use std::sync::{Arc, LazyLock};

use super::Geometry;
use crate::geometry::instance::Placement;
use crate::geometry::{Bounds, Hit, Holes, Instance, PreparedRay, Ray, Triangles};
use crate::math::Real;

/// Meshes in spaces of their own, and their instances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instances {
    /// The triangles of all meshes; `None` if there are no meshes.
    triangles: Option<Arc<Geometry>>,
    meshes: Vec<MeshRange>,
    list: Vec<Instance>,
}

/// A mesh: a range of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MeshRange {
    /// One past its last triangle.
    end: u32,
    bounds: Bounds,
}

impl Instances {
    /// Adds a mesh, which must have a triangle, and returns its index.
    pub fn add_mesh(&mut self, triangles: Triangles) -> u32 {
        let bounds = Bounds::of(triangles.iter().flat_map(|triangle| triangle.vertices));
        let all = &mut Arc::make_mut(self.triangles.get_or_insert_default()).triangles;
        if all.is_empty() {
            *all = triangles;
        } else {
            all.append(&triangles);
        }
        let end = all.len();
        self.meshes.push(MeshRange { end: end as u32, bounds });
        self.meshes.len() as u32 - 1
    }

    /// Adds an instance.
    ///
    /// # Panics
    /// If its mesh does not exist.
    pub fn push(&mut self, instance: Instance) {
        assert!(instance.mesh() < self.meshes.len(), "an instance needs an existing mesh");
        self.list.push(instance);
    }

    /// Number of instances.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are no instances.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// All instances.
    pub(crate) fn list(&self) -> &[Instance] {
        &self.list
    }

    /// Number of meshes.
    pub(crate) fn meshes(&self) -> usize {
        self.meshes.len()
    }

    /// The triangles of mesh `mesh`, as primitives of [`Instances::triangles`].
    pub(crate) fn range(&self, mesh: usize) -> Range<u32> {
        let begin = mesh.checked_sub(1).map_or(0, |before| self.meshes[before].end);
        begin..self.meshes[mesh].end
    }

    /// The box of mesh `mesh` in object space.
    pub(crate) fn mesh_bounds(&self, mesh: usize) -> Bounds {
        self.meshes[mesh].bounds
    }

    /// The triangles of all meshes, in object space.
    pub(crate) fn triangles(&self) -> &Arc<Geometry> {
        static NONE: LazyLock<Arc<Geometry>> = LazyLock::new(Arc::default);
        self.triangles.as_ref().unwrap_or(&NONE)
    }

    /// Number of triangles of all meshes. Each counts once, however often it is placed.
    pub fn triangle_count(&self) -> usize {
        self.meshes.last().map_or(0, |mesh| mesh.end as usize)
    }

    /// Sets which triangles of the meshes may have holes.
    pub fn set_holes(&mut self, holes: Holes) {
        if let Some(triangles) = &mut self.triangles {
            Arc::make_mut(triangles).holes = holes;
        }
    }

    /// [`Geometry::settle`] of the meshes.
    pub(super) fn settle(&mut self) {
        if let Some(triangles) = &mut self.triangles {
            Arc::make_mut(triangles).triangles.settle();
        }
    }

    /// Size in memory.
    pub(in crate::geometry) fn bytes(&self) -> u64 {
        let triangles = self.triangles.as_ref().map_or(0, |triangles| triangles.bytes());
        triangles + (size_of_val(&*self.meshes) + size_of_val(&*self.list)) as u64
    }

    /// The box of each instance in world space.
    pub(in crate::geometry) fn boxes(&self) -> impl Iterator<Item = Bounds> {
        self.list.iter().map(|instance| instance.bounds(self.mesh_bounds(instance.mesh())))
    }

    /// The smallest box around the origins of all object spaces.
    pub(crate) fn centers(&self) -> Bounds {
        Bounds::of(self.list.iter().map(|instance| instance.world_to_object().center))
    }

    /// Finds a hit that is closer than `best`, testing every triangle of every instance. `first` is
    /// the number of the first triangle of a mesh among all primitives.
    pub(in crate::geometry) fn closest_by_brute_force(
        &self,
        ray: &Ray,
        (t_min, t_max): (f32, f32),
        first: u32,
        mut best: Option<Hit>,
    ) -> Option<Hit> {
        let triangles = self.triangles();
        for (index, instance) in self.list.iter().enumerate() {
            let ray = instance.world_to_object().ray(ray);
            if !ray.is_finite() {
                continue;
            }
            let ray = PreparedRay::new(&ray);
            for triangle in self.range(instance.mesh()) {
                let limit = best.map_or(t_max, |hit| hit.t);
                let instance = index as u32;
                if let Some(t) = triangles.intersect(triangle, instance, &ray, t_min, limit) {
                    best = Some(Hit { t, primitive: first + triangle, instance });
                }
            }
        }
        best
    }

    /// The maps of the instances `index`.
    #[inline(always)]
    pub(in crate::geometry) fn placement<R: Real>(&self, index: R::Word) -> Placement<R> {
        Placement::gather(&self.list, R::index(index, self.list.len()))
    }
}
