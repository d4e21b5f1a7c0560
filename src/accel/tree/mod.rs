//! Trees: a binary tree is built once, and the layouts that kernels traverse are made from it.

pub(super) mod binary;
pub(super) mod bvh2;
mod collapse;
mod group;
pub(super) mod pair;
pub(super) mod wide;
