//! Trees: a binary tree that is built once, and the layouts for kernels that are built from it.

mod assembly;
pub(super) mod binary;
mod binned;
pub(super) mod bvh2;
mod collapse;
mod concentric;
pub(super) mod pair;
pub(super) mod partition;
mod subtree;
pub(super) mod wide;
