//! Acceleration structures, which make finding hits faster and never change a hit.

mod accelerator;
mod batch;
mod counters;
mod extent;
mod kernel;
mod leaf;
mod probe;
mod ray;
mod setup;
mod slab;
mod threads;
mod tree;

pub use accelerator::Accelerator;
#[cfg(feature = "cli")]
pub(crate) use accelerator::Layout;
pub(crate) use batch::RayVector;
pub use batch::{HitBatch, RayBatch};
pub use counters::Counters;
pub use kernel::Kernel;
pub use tree::bvh2::Bvh2;
pub(crate) use tree::partition::MAX_CLUSTER;
