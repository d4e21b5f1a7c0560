//! The binary bounding volume hierarchy of the scalar engine.

use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;

use super::group::Groups;
use super::slab::{Planes, SlabRay};
use crate::geometry::{Bounds, Geometry, Hit, PreparedRay, Ray};
use crate::math::max;
use crate::math::random::Stream;

/// A binary tree of boxes over the primitives of a scene, built by obvhs.
#[derive(Clone, Debug)]
pub struct Bvh2 {
    /// The root first; an inner node's children are neighbours.
    nodes: Vec<Node>,
    /// Primitives in the order of the leaves.
    primitives: Vec<u32>,
    bounds: Bounds,
    /// Inner nodes on the longest way down: what the stack must hold.
    depth: usize,
    /// Largest [`Quad::condition`](crate::geometry::Quad::condition), at least 1.
    condition: f32,
}

/// 32 bytes, so that two children share a cache line.
#[derive(Clone, Copy, Debug)]
struct Node {
    planes: Planes,
    /// First child, or first place in `Bvh2::primitives`.
    first: u32,
    /// Number of primitives; 0 for an inner node.
    count: u32,
}

/// Leaves hold at most 4 primitives and are worth splitting when that saves one box test.
const BUILD: BvhBuildParams = BvhBuildParams {
    pre_split: false,
    max_prims_per_leaf: 4,
    collapse_traversal_cost: 1.0,
    ..BvhBuildParams::very_slow_build()
};

/// A box a little larger than `b`, by an amount that differs from primitive to primitive.
///
/// obvhs merges boxes that are each other's nearest (PLOC). Among boxes that are all equally
/// near, as in a row of equal spheres, it finds few pairs a round, in quadratic time: rows of
/// 4000, 8000 and 16 000 spheres took 0.2, 0.6 and 1.7 s.
fn unequal(index: usize, b: Bounds) -> Aabb {
    let random = Stream::new(index as u64).uniform();
    let margin = (b.max - b.min) * (1e-4 * random);
    let b = Bounds { min: b.min - margin, max: b.max + margin }.widened((random * 8.0) as u32);
    Aabb { min: b.min.into(), max: b.max.into() }
}

/// Largest number of inner nodes on a way from the root down.
fn depth(nodes: &[Node]) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0, 0)];
    while let Some((index, above)) = open.pop() {
        let node = &nodes[index as usize];
        if node.count == 0 {
            open.extend([(node.first, above + 1), (node.first + 1, above + 1)]);
        }
        deepest = deepest.max(above);
    }
    deepest
}

/// Trees up to this depth need no allocation a ray.
const USUAL_DEPTH: usize = 64;

impl Bvh2 {
    /// A tree whose boxes hold every primitive over all times of `shutter`.
    pub fn new(geometry: &Geometry, shutter: (f32, f32)) -> Self {
        let boxes: Vec<Bounds> = (0..geometry.len() as u32)
            .map(|primitive| geometry.get(primitive).bounds(shutter.0, shutter.1))
            .collect();
        let bounds = boxes.iter().fold(Bounds::EMPTY, |union, b| union.union(*b));
        if boxes.is_empty() {
            return Self {
                nodes: Vec::new(),
                primitives: Vec::new(),
                bounds,
                depth: 0,
                condition: 1.0,
            };
        }
        let groups = Groups::new(&boxes);
        let group_box = |group: usize| {
            let members = groups.members(group).iter();
            let union = members.fold(Bounds::EMPTY, |union, &p| union.union(boxes[p as usize]));
            unequal(group, union)
        };
        let group_boxes: Vec<Aabb> = (0..groups.len()).map(group_box).collect();
        let tree = build_bvh2(&group_boxes, BUILD, &mut Duration::default());
        let mut primitives = Vec::with_capacity(boxes.len());
        let nodes = tree.nodes.iter().map(|node| {
            let (mut first, mut count) = (node.first_index, 0);
            if node.prim_count > 0 {
                let leaf = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                first = primitives.len() as u32;
                for &group in &tree.primitive_indices[leaf] {
                    primitives.extend_from_slice(groups.members(group as usize));
                }
                count = primitives.len() as u32 - first;
            }
            let (low, high) = (node.aabb().min, node.aabb().max);
            Node { planes: [low.x, low.y, low.z, high.x, high.y, high.z], first, count }
        });
        let nodes: Vec<Node> = nodes.collect();
        let depth = depth(&nodes);
        let condition = geometry.quads.iter().fold(1.0, |most, quad| max(most, quad.condition()));
        Self { nodes, primitives, bounds, depth, condition }
    }

    /// The closest hit in the open interval `(t_min, t_max)`; ties go to the lowest index.
    pub fn closest(&self, geometry: &Geometry, ray: &Ray, t_min: f32, t_max: f32) -> Option<Hit> {
        let prepared = PreparedRay::new(ray);
        let mut best = None;
        self.traverse(ray, t_min, t_max, |primitive, limit| {
            // A hit at the very limit still counts where its index is lower.
            let (limit_or_tie, best_primitive) = match best {
                Some(Hit { t, primitive }) => (f32::next_up(t), primitive),
                None => (limit, u32::MAX),
            };
            match geometry.get(primitive).intersect(&prepared, t_min, limit_or_tie) {
                Some(t) if t < limit || primitive < best_primitive => {
                    best = Some(Hit { t, primitive });
                    t
                }
                _ => limit,
            }
        });
        best
    }

    /// Whether anything is hit in the open interval `(t_min, t_max)`.
    pub fn occluded(&self, geometry: &Geometry, ray: &Ray, t_min: f32, t_max: f32) -> bool {
        let prepared = PreparedRay::new(ray);
        let mut occluded = false;
        self.traverse(ray, t_min, t_max, |primitive, limit| {
            occluded |= geometry.get(primitive).intersect(&prepared, t_min, t_max).is_some();
            // No box is entered before −∞: the traversal ends.
            if occluded { f32::NEG_INFINITY } else { limit }
        });
        occluded
    }

    /// Calls `visit` with the primitives in boxes that the ray enters within the limit,
    /// nearer boxes first. `visit` returns the new limit.
    #[inline]
    fn traverse(&self, ray: &Ray, t_min: f32, t_max: f32, mut visit: impl FnMut(u32, f32) -> f32) {
        // NaN and infinite rays hit nothing; they must not visit every leaf to find out.
        if self.nodes.is_empty() || !ray.origin.is_finite() || !ray.direction.is_finite() {
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
                for &primitive in &self.primitives[first..first + node.count as usize] {
                    limit = visit(primitive, limit);
                }
            } else {
                let children = (node.first, node.first + 1);
                let left = enter(&self.nodes[children.0 as usize], limit);
                let right = enter(&self.nodes[children.1 as usize], limit);
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
                // Pruned only when its entry is strictly beyond the limit.
                if entry <= limit {
                    next = Some(index);
                }
            }
        }
    }
}
