//! Tests of the program, its files and its sources. It is enough to run them on one instruction
//! set.

mod bad_input;
mod bench;
mod cli;
mod common;
mod converge;
mod corpus;
mod dashboard;
mod denoise;
mod faults;
mod frames;
mod hostile;
mod images;
mod import;
mod instances;
mod keep;
mod layering;
mod mesh;
mod mtl;
#[cfg(target_os = "linux")]
mod oidn;
mod references;
mod view;
