//! Library tests that depend on the instruction set: images, proofs and kernels.
//!
//! `.ci/run` repeats them for each instruction set, except those in `proof` and `scenes`.

mod common;
mod determinism;
mod flat;
mod layers;
mod proof;
mod random_scene;
mod scenes;
mod session;
mod tree;
mod wavefront;
