//! Exact counts of the work that kernels do, free where nobody counts.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

/// Is told what a kernel does. `()` is nobody: its calls compile to nothing.
pub(crate) trait Count {
    /// A node was visited for `active` of `issued` lanes: rays or children.
    fn node(&mut self, issued: u32, active: u32);
    /// A primitive was tested against rays in `issued` lanes, or a ray against primitives, of which
    /// `active` mattered.
    fn leaf(&mut self, issued: u32, active: u32);
    /// The boxes of a block's primitives were tested against a beam.
    fn boxes(&mut self, issued: u32, active: u32);
    /// So many rays were left to the reference.
    fn left(&mut self, rays: usize);
}

impl Count for () {
    #[inline(always)]
    fn node(&mut self, _: u32, _: u32) {}
    #[inline(always)]
    fn leaf(&mut self, _: u32, _: u32) {}
    #[inline(always)]
    fn boxes(&mut self, _: u32, _: u32) {}
    #[inline(always)]
    fn left(&mut self, _: usize) {}
}

/// How often what was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Counters {
    /// Nodes visited: by the reference with both children.
    pub node_visits: u64,
    /// Primitives tested against a vector of rays, or vectors of primitives against a ray. Rays that
    /// go along different axes are tested against a triangle one axis after the other.
    pub leaf_tests: u64,
    /// Lanes of both, and of the boxes in blocks that a beam was tested against.
    pub lanes_issued: u64,
    /// Lanes that were of use: where a ray or a beam entered a box, where a ray was looking when
    /// the test of a leaf began, where a primitive was.
    pub lanes_active: u64,
    /// Rays that a kernel left to the reference, whose work is counted as well: those too wild
    /// for its box test; for [`Kernel::Scalar`](super::Kernel::Scalar) every ray.
    pub scalar_rays: u64,
}

impl Count for Counters {
    fn node(&mut self, issued: u32, active: u32) {
        self.node_visits += 1;
        self.lanes_issued += u64::from(issued);
        self.lanes_active += u64::from(active);
    }

    fn leaf(&mut self, issued: u32, active: u32) {
        self.leaf_tests += 1;
        self.lanes_issued += u64::from(issued);
        self.lanes_active += u64::from(active);
    }

    fn boxes(&mut self, issued: u32, active: u32) {
        self.lanes_issued += u64::from(issued);
        self.lanes_active += u64::from(active);
    }

    fn left(&mut self, rays: usize) {
        self.scalar_rays += rays as u64;
    }
}

impl AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.node_visits += other.node_visits;
        self.leaf_tests += other.leaf_tests;
        self.lanes_issued += other.lanes_issued;
        self.lanes_active += other.lanes_active;
        self.scalar_rays += other.scalar_rays;
    }
}
