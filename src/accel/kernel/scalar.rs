//! The kernel `scalar`, which takes one ray through a binary tree and tests it against two boxes at each step. It is the
//! reference for the others.

use glam::Vec3;

use crate::accel::tree::bvh2::{Bvh2, Node};
use crate::accel::{Count, SlabRay};
use crate::geometry::{Geometry, Hit, PreparedRay, Ray};

/// Largest depth for which tracing a ray needs no allocation.
const USUAL_DEPTH: usize = 64;

impl Bvh2 {
    /// Returns the closest hit in the open interval `(t_min, t_max)`; ties go to the lowest index.
    pub fn closest(&self, geometry: &Geometry, ray: &Ray, t_min: f32, t_max: f32) -> Option<Hit> {
        self.count_closest(geometry, ray, t_min, t_max, &mut ())
    }

    /// Returns whether the ray hits anything in the open interval `(t_min, t_max)`.
    pub fn occluded(&self, geometry: &Geometry, ray: &Ray, t_min: f32, t_max: f32) -> bool {
        self.any_occluded(geometry, 0, ray, (t_min, t_max), &mut ())
    }

    /// Does the same as [`Self::closest`], and records the work in `count`.
    #[inline]
    pub(crate) fn count_closest(
        &self,
        geometry: &Geometry,
        ray: &Ray,
        t_min: f32,
        t_max: f32,
        count: &mut impl Count,
    ) -> Option<Hit> {
        if self.meshes.is_empty() {
            return self.closest_primitive(geometry, 0, ray, (t_min, t_max), count);
        }
        let (prepared, first) = (PreparedRay::new(ray), geometry.len() as u32);
        let mut best: Option<Hit> = None;
        self.traverse(ray, (t_min, t_max), count, |element, limit, count| {
            // A hit exactly at the limit still counts if its index is lower.
            let limit_or_tie = best.map_or(limit, |best| best.t.next_up());
            let hit = match element.checked_sub(first) {
                None => {
                    let t = geometry.intersect(element, 0, &prepared, t_min, limit_or_tie);
                    t.map(|t| Hit::of(element, t))
                }
                Some(instance) => {
                    let (tree, triangles, ray) = self.enter(geometry, instance, ray);
                    let range = (t_min, limit_or_tie);
                    let hit = tree.closest_primitive(triangles, instance, &ray, range, count);
                    hit.map(|hit| Hit { primitive: first + hit.primitive, instance, ..hit })
                }
            };
            // Triangles of meshes come after all other primitives, whose instance is 0.
            let rank = |hit: &Hit| (hit.instance, hit.primitive);
            match hit {
                Some(hit) if hit.t < limit || best.is_none_or(|best| rank(&hit) < rank(&best)) => {
                    best = Some(hit);
                    hit.t
                }
                _ => limit,
            }
        });
        best
    }

    /// Finds the closest hit in a tree without instances, which may be that of instance `instance`.
    #[inline(never)]
    fn closest_primitive(
        &self,
        geometry: &Geometry,
        instance: u32,
        ray: &Ray,
        (t_min, t_max): (f32, f32),
        count: &mut impl Count,
    ) -> Option<Hit> {
        let prepared = PreparedRay::new(ray);
        let mut best: Option<(f32, u32)> = None;
        self.traverse(ray, (t_min, t_max), count, |primitive, limit, _| {
            // A hit exactly at the limit still counts if its index is lower.
            let (limit_or_tie, best_primitive) = match best {
                Some((t, primitive)) => (t.next_up(), primitive),
                None => (limit, u32::MAX),
            };
            match geometry.intersect(primitive, instance, &prepared, t_min, limit_or_tie) {
                Some(t) if t < limit || primitive < best_primitive => {
                    best = Some((t, primitive));
                    t
                }
                _ => limit,
            }
        });
        best.map(|(t, primitive)| Hit::of(primitive, t))
    }

    /// The tree of an instance's mesh, its triangles, and the ray in its object space.
    fn enter<'a>(
        &'a self,
        geometry: &'a Geometry,
        instance: u32,
        ray: &Ray,
    ) -> (&'a Self, &'a Geometry, Ray) {
        let instances = &geometry.instances;
        let placed = &instances.list()[instance as usize];
        let (tree, ray) = (&self.meshes[placed.mesh()], placed.world_to_object().ray(ray));
        (tree, instances.triangles(), ray)
    }

    /// Does the same as [`Self::occluded`], and records the work in `count`. In a tree without
    /// instances, the geometry may be that of instance `instance`.
    ///
    /// Not inlined, for there are 18 copies of the function that calls it: one for each kind of
    /// material, of scalar engine or of recording.
    #[inline(never)]
    pub(crate) fn any_occluded(
        &self,
        geometry: &Geometry,
        instance: u32,
        ray: &Ray,
        (t_min, t_max): (f32, f32),
        count: &mut impl Count,
    ) -> bool {
        let (prepared, first) = (PreparedRay::new(ray), geometry.len() as u32);
        let mut occluded = false;
        self.traverse(ray, (t_min, t_max), count, |element, limit, count| {
            occluded |= if self.meshes.is_empty() || element < first {
                geometry.intersect(element, instance, &prepared, t_min, t_max).is_some()
            } else {
                let instance = element - first;
                let (tree, triangles, ray) = self.enter(geometry, instance, ray);
                tree.any_occluded(triangles, instance, &ray, (t_min, t_max), count)
            };
            // With the limit −∞ no box is entered, which ends the traversal.
            if occluded { f32::NEG_INFINITY } else { limit }
        });
        occluded
    }

    /// Calls `visit` for each element in the boxes that the ray enters up to the limit, nearer boxes
    /// first. `visit` returns the new limit.
    #[inline]
    fn traverse<C: Count>(
        &self,
        ray: &Ray,
        (t_min, t_max): (f32, f32),
        count: &mut C,
        mut visit: impl FnMut(u32, f32, &mut C) -> f32,
    ) {
        // Non-finite rays hit nothing. Without this check they might visit every leaf.
        if self.nodes.is_empty() || !ray.is_finite() || ray.direction == Vec3::ZERO {
            return;
        }
        let slab = SlabRay::new(ray, &self.bounds, self.condition);
        let enter = |node: &Node, limit| slab.enter(&node.planes, t_min, limit);
        let mut limit = t_max;
        let (mut usual, mut deep) = ([(0, 0.0); USUAL_DEPTH], Vec::new());
        let stack = if self.depth <= USUAL_DEPTH {
            &mut usual[..]
        } else {
            deep.resize(self.depth, (0, 0.0));
            &mut deep[..]
        };
        let mut top = 0;
        let mut next = enter(&self.nodes[0], limit).map(|_| 0);
        while let Some(index) = next {
            let node = &self.nodes[index as usize];
            next = None;
            if node.count > 0 {
                let first = node.first as usize;
                for &element in &self.elements[first..first + node.count as usize] {
                    count.leaf(1, 1);
                    limit = visit(element, limit, count);
                }
            } else {
                let children = (node.first, node.first + 1);
                let left = enter(&self.nodes[children.0 as usize], limit);
                let right = enter(&self.nodes[children.1 as usize], limit);
                count.node(2, u32::from(left.is_some()) + u32::from(right.is_some()));
                next = match (left, right) {
                    (Some(l), Some(r)) if l <= r => {
                        stack[top] = (children.1, r);
                        top += 1;
                        Some(children.0)
                    }
                    (Some(l), Some(_)) => {
                        stack[top] = (children.0, l);
                        top += 1;
                        Some(children.1)
                    }
                    (Some(_), None) => Some(children.0),
                    (None, Some(_)) => Some(children.1),
                    (None, None) => None,
                };
            }
            while next.is_none() {
                if top == 0 {
                    return;
                }
                top -= 1;
                let (index, entry) = stack[top];
                // A node is pruned only if its entry is strictly beyond the limit.
                if entry <= limit {
                    next = Some(index);
                }
            }
        }
    }
}
