//! Acceleration structures: they decide only where to look, never what is hit.

mod bvh2;
mod group;
mod slab;

pub use bvh2::Bvh2;
