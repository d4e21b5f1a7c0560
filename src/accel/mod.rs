//! Acceleration structures: they decide only where to look, never what is hit.

mod accelerator;
mod batch;
mod beam;
mod binary;
mod blocks;
mod bvh2;
mod collapse;
mod counters;
mod descent;
mod flat;
mod frames;
mod group;
mod huge_pages;
mod job;
mod kernel;
mod octants;
mod one_ray;
mod one_ray_blocks;
mod packet;
mod pair;
mod pair_traversal;
mod probe;
mod rays;
mod setup;
mod single;
mod slab;
mod wide;

pub use accelerator::{Accelerator, Layout};
pub(crate) use batch::RayVector;
pub use batch::{HitBatch, RayBatch};
pub use bvh2::Bvh2;
pub use counters::Counters;
pub use kernel::Kernel;
