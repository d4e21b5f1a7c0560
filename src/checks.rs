//! Range checks of the values in a scene file, with errors that name the place.

use std::path::{Path, PathBuf};

use glam::Vec3;

use crate::error::{Error, Result};
use crate::input::path_within;
use crate::limits::Limits;

/// Largest absolute coordinate. Beyond it, the products in the primitive tests could overflow.
pub(crate) const MAX_COORDINATE: f32 = 1e9;

/// Largest absolute coordinate of the point of a file that becomes the origin.
pub(crate) const MAX_ORIGIN: f64 = 1e12;

/// Largest radiance. The sum of 2^24 samples with this radiance is still finite.
pub(crate) const MAX_RADIANCE: f32 = 1e30;

/// An upper bound, as error messages write it.
pub(crate) fn limit(most: f32) -> String {
    if most == MAX_RADIANCE { "1e30".to_owned() } else { most.to_string() }
}

/// One element of a file, for error messages while its values are checked.
pub(crate) struct Location<'a> {
    pub(crate) file: &'a str,
    pub(crate) place: String,
    pub(crate) kind: &'a str,
}

impl Location<'_> {
    pub(crate) fn error(&self, message: impl std::fmt::Display) -> Error {
        Error::input(self.file, self.place.clone(), format!("{}: {message}", self.kind))
    }

    /// The path of `file`, which must be within `folder` unless the limits allow others.
    pub(crate) fn path_within(
        &self,
        folder: &Path,
        file: &str,
        limits: &Limits,
    ) -> Result<PathBuf> {
        path_within(folder, file, limits).map_err(|error| self.error(error))
    }

    pub(crate) fn check(
        &self,
        ok: bool,
        name: &str,
        range: &str,
        value: impl std::fmt::Debug,
    ) -> Result<()> {
        if ok { Ok(()) } else { Err(self.error(format!("{name} must be {range}, is {value:?}"))) }
    }

    pub(crate) fn point(&self, name: &str, value: [f32; 3]) -> Result<Vec3> {
        let ok = value.iter().all(|c| c.abs() <= MAX_COORDINATE);
        self.check(ok, name, "finite and within ±1e9", value)?;
        Ok(Vec3::from_array(value))
    }

    /// Checks the corners of a box.
    pub(crate) fn bounds(&self, min: [f32; 3], max: [f32; 3]) -> Result<()> {
        self.point("min", min)?;
        self.point("max", max)?;
        let ok = min.iter().zip(max).all(|(min, max)| *min < max);
        self.check(ok, "max", &format!("above min {min:?} on every axis"), max)
    }

    pub(crate) fn rotation(&self, degrees: [f32; 3]) -> Result<()> {
        let ok = degrees.iter().all(|angle| angle.abs() <= 1e6);
        self.check(ok, "rotation", "finite, within ±1e6 degrees", degrees)
    }

    pub(crate) fn color(&self, name: &str, value: [f32; 3], most: f32) -> Result<Vec3> {
        let range = format!("in [0, {}]", limit(most));
        let ok = value.iter().all(|c| (0.0..=most).contains(c));
        self.check(ok, name, &range, value)?;
        Ok(Vec3::from_array(value))
    }
}
