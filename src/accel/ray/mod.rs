//! Rays as kernels hold them, and their closest hits so far.

pub(super) mod best;
pub(super) mod one_ray;
pub(super) mod packet;
pub(super) mod rays;
