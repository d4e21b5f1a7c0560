//! Homogeneous media.

use glam::Vec3;

use super::description::MediumFile;
use super::place::{Element, MAX_COORDINATE, angles};
use crate::error::Result;
use crate::geometry::Volume;
use crate::math::precise::rotate;

/// A medium that scatters light to all sides alike. Its boundary is invisible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// What it fills.
    pub volume: Volume,
    /// Extinction coefficient: collisions a unit of length.
    pub density: f32,
    /// The share of the light that a collision does not absorb.
    pub albedo: Vec3,
}

impl Medium {
    /// Checks what a file says of one.
    pub(super) fn new(e: &Element<'_>, file: &MediumFile) -> Result<Self> {
        let (volume, density, albedo) = match file {
            MediumFile::Sphere { center, radius, density, albedo } => {
                let center = e.point("center", *center)?;
                let ok = *radius > 0.0 && *radius <= MAX_COORDINATE;
                e.check(ok, "radius", "above 0 and at most 1e9", radius)?;
                (Volume::Sphere { center, radius: *radius }, density, albedo)
            }
            MediumFile::Box { min, max, rotation, density, albedo } => {
                e.bounds(*min, *max)?;
                e.rotation(*rotation)?;
                (turned_box(*min, *max, *rotation), density, albedo)
            }
        };
        let ok = *density > 0.0 && *density <= 1e6;
        e.check(ok, "density", "above 0 and at most 1e6", density)?;
        Ok(Self { volume, density: *density, albedo: e.color("albedo", *albedo, 1.0)? })
    }
}

/// The box from `min` to `max`, turned about its middle as the primitive is.
fn turned_box(min: [f32; 3], max: [f32; 3], rotation: [f32; 3]) -> Volume {
    let at = |f: fn(f64, f64) -> f64| {
        let both = |axis: usize| f(f64::from(min[axis]), f64::from(max[axis])) as f32;
        Vec3::new(both(0), both(1), both(2))
    };
    let turns = angles(rotation);
    let axis = |axis: usize| {
        let mut unit = [0.0; 3];
        unit[axis] = 1.0;
        Vec3::from_array(rotate(unit, turns).map(|c| c as f32))
    };
    Volume::Box {
        center: at(|min, max| (min + max) * 0.5),
        axes: [axis(0), axis(1), axis(2)],
        half: at(|min, max| (max - min) * 0.5),
    }
}
