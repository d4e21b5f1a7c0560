//! Rays and their closest hits so far, in the forms that kernels use.

pub(super) mod best;
pub(super) mod one_ray;
pub(super) mod packet;
pub(super) mod ray_group;
pub(super) mod rays;
