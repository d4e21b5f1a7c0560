//! Acceleration structures, which make finding hits faster and never change a hit.

mod accelerator;
mod batch;
mod counters;
mod extent;
mod kernel;
mod leaf;
mod probe;
mod quality;
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
use counters::Count;
pub use counters::Counters;
use extent::{Extent, ExtentLanes};
pub use kernel::Kernel;
use leaf::{LeafBlocks, LeafRef, Meshes, NoMeshes};
pub use quality::TreeQuality;
use setup::{Setup, Shear, SlabLanes};
use slab::SlabRay;
pub use tree::bvh2::Bvh2;
pub(crate) use tree::partition::MAX_CLUSTER;
