//! Rays and their closest hits so far, in the forms that kernels use.

mod best;
mod one_ray;
mod packet;
mod ray_group;
mod rays;

pub(super) use best::{Best, BestLanes};
pub(super) use one_ray::OneRay;
pub(super) use packet::{Packet, VECTORS};
pub(super) use ray_group::{Members, RayGroup};
pub(super) use rays::Rays;
