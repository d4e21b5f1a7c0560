//! Acceleration structures: they decide only where to look, never what is hit.

mod accelerator;
mod batch;
mod beam;
mod binary;
mod blocks;
mod bvh2;
mod counters;
mod frames;
mod group;
mod huge_pages;
mod kernel;
mod octants;
mod one_ray;
mod packet;
mod pair;
mod pair_traversal;
mod queues;
mod rays;
mod setup;
mod single;
mod slab;
mod trial;
mod wide;

pub use accelerator::{Accelerator, Layout};
pub use batch::{HitBatch, RayBatch};
pub use bvh2::Bvh2;
pub use counters::Counters;
pub use kernel::Kernel;

/// The axes of [`crate::geometry::PreparedRay`].
#[inline(always)]
fn shear_axes(longest: usize, negative: bool) -> [usize; 3] {
    const NEXT: [usize; 3] = [1, 2, 0];
    const LAST: [usize; 3] = [2, 0, 1];
    if negative {
        [LAST[longest % 3], NEXT[longest % 3], longest % 3]
    } else {
        [NEXT[longest % 3], LAST[longest % 3], longest % 3]
    }
}
