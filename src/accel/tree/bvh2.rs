//! The binary bounding volume hierarchy of the scalar engine, which tests one ray against two boxes
//! at each step.

use glam::Vec3;

use super::binary::{Below, BinaryTree};
use crate::accel::counters::Count;
use crate::accel::slab::{Planes, SlabRay, planes};
use crate::geometry::{Bounds, Geometry, Hit, PreparedRay, Ray};

/// A binary tree of boxes over the primitives of a scene, built by obvhs.
#[derive(Clone, Debug)]
pub struct Bvh2 {
    /// The root is first, and the two children of an inner node are adjacent.
    nodes: Vec<Node>,
    /// Primitives in the order of the leaves.
    primitives: Vec<u32>,
    bounds: Bounds,
    /// Number of inner nodes on the longest path from the root, which is the stack size required.
    depth: usize,
    /// Largest [`Quad::condition`](crate::geometry::Quad::condition), at least 1.
    condition: f32,
}

/// 32 bytes, so that two children share a cache line.
#[derive(Clone, Copy, Debug)]
struct Node {
    planes: Planes,
    /// Index of the first child, or of the first primitive in `Bvh2::primitives`.
    first: u32,
    /// Number of primitives; 0 for an inner node.
    count: u32,
}

impl Node {
    const UNKNOWN: Self = Self { planes: [0.0; 6], first: 0, count: 0 };
}

/// Largest number of primitives in a leaf.
const LEAF: u32 = 4;

/// Returns the number of inner nodes on the longest path from the root.
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

/// Largest depth for which tracing a ray needs no allocation.
const USUAL_DEPTH: usize = 64;

impl Bvh2 {
    /// Builds a tree whose boxes contain every primitive at all times, on `threads` threads.
    pub fn new(geometry: &Geometry, threads: usize) -> Self {
        let boxes = geometry.boxes();
        let each: Vec<u32> = (0..boxes.len() as u32).collect();
        Self::of(geometry, &BinaryTree::new(&boxes, &each, threads))
    }

    /// Lays out `tree`, assuming that visiting a node costs as much as testing a primitive.
    pub(crate) fn of(geometry: &Geometry, tree: &BinaryTree) -> Self {
        let bounds = tree.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds);
        let leaf = tree.leaves(1.0, LEAF, |_| ());
        let mut layout = Self {
            nodes: Vec::new(),
            primitives: Vec::new(),
            bounds,
            depth: 0,
            condition: geometry.condition(),
        };
        if tree.nodes.is_empty() {
            return layout;
        }
        layout.nodes.push(Node::UNKNOWN);
        let mut open = vec![(0, 0)];
        while let Some((slot, index)) = open.pop() {
            let node = &tree.nodes[index as usize];
            let (first, count) = match node.below {
                Below::Children(first) if !leaf[index as usize] => {
                    let slot = layout.nodes.len();
                    layout.nodes.extend([Node::UNKNOWN; 2]);
                    open.extend([(slot + 1, first + 1), (slot, first)]);
                    (slot as u32, 0)
                }
                _ => {
                    let members = tree.primitives(index);
                    let first = layout.primitives.len() as u32;
                    layout.primitives.extend_from_slice(&members);
                    (first, members.len() as u32)
                }
            };
            layout.nodes[slot] = Node { planes: planes(&node.bounds), first, count };
        }
        layout.depth = depth(&layout.nodes);
        layout
    }

    /// Returns the closest hit in the open interval `(t_min, t_max)`; ties go to the lowest index.
    pub fn closest(&self, geometry: &Geometry, ray: &Ray, t_min: f32, t_max: f32) -> Option<Hit> {
        self.count_closest(geometry, ray, t_min, t_max, &mut ())
    }

    /// Returns whether the ray hits anything in the open interval `(t_min, t_max)`.
    pub fn occluded(&self, geometry: &Geometry, ray: &Ray, t_min: f32, t_max: f32) -> bool {
        self.count_occluded(geometry, ray, t_min, t_max, &mut ())
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
        let prepared = PreparedRay::new(ray);
        let mut best = None;
        self.traverse(ray, (t_min, t_max), count, |primitive, limit| {
            // A hit exactly at the limit still counts if its index is lower.
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

    /// Size in memory.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.primitives)
    }

    /// Does the same as [`Self::occluded`], and records the work in `count`.
    #[inline]
    pub(crate) fn count_occluded(
        &self,
        geometry: &Geometry,
        ray: &Ray,
        t_min: f32,
        t_max: f32,
        count: &mut impl Count,
    ) -> bool {
        let prepared = PreparedRay::new(ray);
        let mut occluded = false;
        self.traverse(ray, (t_min, t_max), count, |primitive, limit| {
            occluded |= geometry.get(primitive).intersect(&prepared, t_min, t_max).is_some();
            // With the limit −∞ no box is entered, which ends the traversal.
            if occluded { f32::NEG_INFINITY } else { limit }
        });
        occluded
    }

    /// Calls `visit` for each primitive in the boxes that the ray enters up to the limit, nearer
    /// boxes first. `visit` returns the new limit.
    #[inline]
    fn traverse(
        &self,
        ray: &Ray,
        (t_min, t_max): (f32, f32),
        count: &mut impl Count,
        mut visit: impl FnMut(u32, f32) -> f32,
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
                for &primitive in &self.primitives[first..first + node.count as usize] {
                    count.leaf(1, 1);
                    limit = visit(primitive, limit);
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
