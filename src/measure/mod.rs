//! What measures rather than renders: benches, recorded rays, convergence, the report's figures, and their statistics.

pub(crate) mod bench;
pub(crate) mod converge;
pub(crate) mod dashboard;
pub(crate) mod figures;
pub(crate) mod machine;
pub(crate) mod rayset;
pub(crate) mod settings;
pub(crate) mod statistics;
