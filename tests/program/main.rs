//! Tests of the program, its files and its sources, which need to run on one instruction set only.

mod bad_input;
mod bench;
mod cli;
mod common;
mod converge;
mod corpus;
mod dashboard;
mod faults;
mod hostile;
mod keep;
mod layering;
mod mesh;
