//! Library tests that depend on the instruction set: images, proofs and kernels.
//!
//! `profiling/proofs` repeats them for each instruction set.

mod common;
mod denoise;
mod determinism;
mod flat;
mod layers;
mod proof;
mod random_scene;
mod scenes;
mod session;
mod tree;
mod wavefront;
