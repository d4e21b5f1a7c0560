//! Exact counts of the work that kernels do, at no cost when counting is off.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

/// Counts the work that a kernel does. The implementation for `()` counts nothing, and calls to it
/// compile to nothing.
pub(crate) trait Count {
    /// Counts a visit of a node. Each lane tests a ray or a beam against a box, which it enters in
    /// `active` of the `issued` lanes.
    fn node(&mut self, issued: u32, active: u32);
    /// Counts a test of a primitive against a vector of rays, or of a ray against a vector of
    /// primitives, in which `active` of the `issued` lanes matter.
    fn leaf(&mut self, issued: u32, active: u32);
    /// Counts a test of a beam against the boxes of a block's primitives.
    fn boxes(&mut self, issued: u32, active: u32);
    /// Counts rays that were left to the reference.
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

/// Counts of the work that kernels did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Counters {
    /// Nodes visited. The reference tests both children of a node in one visit.
    pub node_visits: u64,
    /// Tests of a primitive against a vector of rays, or of a vector of primitives against a ray. A
    /// vector of rays that run along different axes takes one test of a triangle for each axis.
    pub leaf_tests: u64,
    /// Lanes used by node visits, by leaf tests, and by tests of beams against the boxes in blocks.
    pub lanes_issued: u64,
    /// Lanes among them that did useful work: those in which a ray or a beam entered a box, a ray
    /// was still active when the test of a leaf began, or a primitive was present.
    pub lanes_active: u64,
    /// Rays that a kernel left to the reference, because their values are too large or too small
    /// for its box test. [`Kernel::Scalar`](super::Kernel::Scalar) leaves every ray to it. The work
    /// of the reference is included in the other counts.
    pub scalar_rays: u64,
}

impl Count for Counters {
    fn node(&mut self, issued: u32, active: u32) {
        self.node_visits += 1;
        self.boxes(issued, active);
    }

    fn leaf(&mut self, issued: u32, active: u32) {
        self.leaf_tests += 1;
        self.boxes(issued, active);
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
