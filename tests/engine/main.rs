//! Library tests that depend on the instruction set: images, proofs and kernels.
//!
//! `.ci/run` repeats them for each instruction set, except the proofs and the comparisons with other programs.

mod common;
mod determinism;
mod proof;
mod random_scene;
mod scenes;
mod tree;
mod wavefront;
