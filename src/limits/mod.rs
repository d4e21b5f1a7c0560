//! Limits on inputs, which are checked before memory is allocated for them.

mod budget;
mod limit;
mod memory;

pub(crate) use budget::Budget;
pub use limit::{Limit, Limits, Refused};

/// Largest width or height of an image, in pixels.
pub(crate) const MAX_SIDE: u32 = 65_536;
/// Largest number of samples per pixel.
pub(crate) const MAX_SPP: u32 = 1 << 24;
/// Largest number of segments of a path.
pub(crate) const MAX_DEPTH: u32 = 1 << 16;
/// Largest number of primitives that can be requested from a generated scene.
pub(crate) const MAX_GENERATED: u32 = 1 << 24;
/// Largest number of primitives of a scene. `LeafRef` stores the index of a block in 24 bits, and
/// blocks of large scenes hold several primitives.
pub(crate) const MAX_PRIMITIVES: usize = 1 << 25;
/// Largest number of media of a scene.
pub(crate) const MAX_MEDIA: usize = 64;
/// Largest size in bytes of the record of a bench, or of the manifest of a ray set.
pub(crate) const MAX_JSON: u64 = 1 << 24;
/// Largest size in bytes of a plan file, or of the record of a render that contains a plan.
pub(crate) const MAX_PLAN: u64 = 1 << 20;
/// Largest number of rays of each kind in a ray set: 12 GB of files per kind.
pub(crate) const MAX_RAYS: u64 = 1 << 28;
/// Largest number of paths in a wave.
pub(crate) const MAX_WAVE: u32 = 1 << 18;
/// Largest number of threads.
pub(crate) const MAX_THREADS: u32 = 4096;

/// Checks the size of an image. The error names the side that is out of range.
pub(crate) fn check_image(width: u32, height: u32) -> Result<(), String> {
    check("width", width, MAX_SIDE)?;
    check("height", height, MAX_SIDE)
}

/// Checks that `value` is at least 1 and at most `most`.
pub(crate) fn check(name: &str, value: u32, most: u32) -> Result<(), String> {
    if (1..=most).contains(&value) {
        Ok(())
    } else {
        Err(format!("{name} must be in 1 to {most}, is {value}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_limited() {
        assert!(check_image(1, 1).is_ok() && check_image(65_536, 4096).is_ok());
        assert!(check_image(0, 9).unwrap_err().starts_with("width must be in 1 to 65536"));
        assert!(check_image(9, 1_000_000_000).unwrap_err().starts_with("height"));
        assert!(check("spp", 0, MAX_SPP).unwrap_err().starts_with("spp must be in 1 to"));
    }
}
