//! Tests of the library that depend on the instruction set: images, proofs and kernels. `.ci/run` repeats them for
//! each instruction set, without the proofs and the scenes of other programs.

mod common;
mod determinism;
mod proof;
mod random_scene;
mod scenes;
mod tree;
mod wavefront;
