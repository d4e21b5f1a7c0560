//! Limits on scenes and renders that the user can raise.

use super::memory;
use super::{MAX_PRIMITIVES, MAX_SIDE};

/// A quantity with a limit that the user can raise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// Size of a scene file in bytes.
    SceneBytes,
    /// Number of primitives of a scene.
    Primitives,
    /// Size of a mesh file in bytes.
    MeshBytes,
    /// Size of a texture in memory in bytes: 4 per pixel if its channels have 8 bits, else 16.
    TextureBytes,
    /// Number of pixels of an image.
    Pixels,
    /// Estimated total memory in bytes.
    Memory,
}

names! {
    pub Limit:
    SceneBytes = "scene-bytes",
    Primitives = "primitives",
    MeshBytes = "mesh-bytes",
    TextureBytes = "texture-bytes",
    Pixels = "pixels",
    Memory = "memory",
}

impl Limit {
    /// `value` as text, bytes with a unit. `round` rounds numbers of tenths of a unit.
    pub(crate) fn amount(self, value: u64, round: fn(f64) -> f64) -> String {
        let units = ["KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
        match self {
            Self::Primitives | Self::Pixels => value.to_string(),
            _ if value < 1 << 10 => format!("{value} bytes"),
            _ => {
                let unit = (value.ilog2() / 10) as usize;
                let tenths = round(10.0 * value as f64 / (1u64 << (10 * unit)) as f64);
                format!("{:.1} {}", tenths / 10.0, units[unit - 1])
            }
        }
    }

    /// The default value.
    fn usual(self) -> u64 {
        match self {
            Self::SceneBytes => 1 << 28,
            Self::Primitives => 1 << 24,
            Self::MeshBytes => 1 << 32,
            Self::TextureBytes => 1 << 30,
            // 3 GiB of f32 RGB.
            Self::Pixels => 1 << 28,
            Self::Memory => memory::of_process(),
        }
    }

    /// The largest value that the limit can be raised to.
    pub fn most(self) -> u64 {
        match self {
            Self::SceneBytes | Self::MeshBytes | Self::TextureBytes | Self::Memory => u64::MAX,
            Self::Primitives => MAX_PRIMITIVES as u64,
            Self::Pixels => MAX_SIDE as u64 * MAX_SIDE as u64,
        }
    }
}

/// Why a scene or a render was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refused {
    /// The scene or render needs this amount of a quantity. The amount exceeds the limit, but the
    /// user can raise the limit to this amount.
    Beyond(Limit, u64),
    /// The scene names a file outside its folder.
    OutsideFile,
}

/// Advice at the end of error messages. The program supplies the advice, so that it can name
/// the options of that program.
#[derive(Clone, Copy, Debug)]
struct Advice(fn(Refused) -> String);

impl PartialEq for Advice {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::fn_addr_eq(self.0, other.0)
    }
}

impl Eq for Advice {}

/// All limits, and whether a scene may read files from outside its folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    values: [u64; Limit::ALL.len()],
    outside_files: bool,
    advice: Option<Advice>,
}

impl Default for Limits {
    /// The default limits. The limit on memory is the amount that the process may use.
    fn default() -> Self {
        Self { values: Limit::ALL.map(Limit::usual), outside_files: false, advice: None }
    }
}

impl Limits {
    /// The value of `limit`.
    pub fn get(&self, limit: Limit) -> u64 {
        self.values[limit as usize]
    }

    /// Sets `limit` to `value`, or to its [largest value](Limit::most) if `value` is larger.
    #[must_use]
    pub fn with(mut self, limit: Limit, value: u64) -> Self {
        self.values[limit as usize] = value.min(limit.most());
        self
    }

    /// Sets whether textures and meshes may be outside the folder of the scene file.
    #[must_use]
    pub fn with_outside_files(self, outside_files: bool) -> Self {
        Self { outside_files, ..self }
    }

    /// Whether textures and meshes may be outside the folder of the scene file.
    pub fn outside_files(&self) -> bool {
        self.outside_files
    }

    /// Appends advice to error messages, such as `--limit pixels=100 raises it`.
    #[must_use]
    pub fn with_advice(self, advice: fn(Refused) -> String) -> Self {
        Self { advice: Some(Advice(advice)), ..self }
    }

    /// The end of an error message: a colon and the advice, or nothing.
    pub(crate) fn advice(&self, refused: Refused) -> String {
        self.advice.map_or_else(String::new, |Advice(advice)| format!(": {}", advice(refused)))
    }

    /// Checks the number of pixels of an image, and the bytes of memory that reading it takes.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn check_image(&self, pixels: u64, memory: u64) -> Result<(), String> {
        self.check(Limit::Pixels, pixels).and_then(|()| self.check(Limit::Memory, memory))
    }

    /// Checks `value` against the limit.
    ///
    /// # Errors
    /// A message if `value` exceeds the limit.
    pub fn check(&self, limit: Limit, value: u64) -> Result<(), String> {
        let allowed = self.get(limit);
        if value <= allowed {
            return Ok(());
        }
        // Memory is estimated step by step, and later steps may need more.
        let (least, most) = match limit {
            Limit::Memory => ("at least ", memory::of_process()),
            // An image takes at least 12 bytes per pixel.
            Limit::Pixels => ("", limit.most().min(memory::of_process() / 12)),
            _ => ("", limit.most()),
        };
        let raise = match value <= most {
            true => self.advice(Refused::Beyond(limit, value)),
            false => String::new(),
        };
        // Rounded apart, so that the two amounts never look equal.
        let (allowed, needed) = (limit.amount(allowed, f64::floor), limit.amount(value, f64::ceil));
        let name = limit.name();
        Err(format!("the limit of {name} is {allowed}, this needs {least}{needed}{raise}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_limit_and_end_with_advice() {
        let limits = Limits::default().with(Limit::MeshBytes, 100).with(Limit::Memory, 1000);
        assert_eq!(limits.check(Limit::MeshBytes, 100), Ok(()));
        let message = "the limit of mesh-bytes is 100 bytes, this needs 101 bytes";
        assert_eq!(limits.check(Limit::MeshBytes, 101), Err(message.to_owned()));
        let limits = limits.with_advice(|refused| format!("{refused:?}"));
        let message =
            "the limit of memory is 1000 bytes, this needs at least 2.0 KiB: Beyond(Memory, 2000)";
        assert_eq!(limits.check(Limit::Memory, 2000), Err(message.to_owned()));
        let message = limits.check(Limit::Memory, 1 << 60).unwrap_err();
        assert!(message.ends_with("this needs at least 1.0 EiB"), "{message}");
        let raised = limits.with(Limit::Primitives, 1 << 40);
        assert_eq!(raised.get(Limit::Primitives), MAX_PRIMITIVES as u64);
        let message = "the limit of primitives is 33554432, this needs 33554433";
        assert_eq!(raised.check(Limit::Primitives, 33_554_433), Err(message.to_owned()));
        for limit in Limit::ALL {
            assert!((1..=limit.most()).contains(&limit.usual()), "{limit:?}");
            assert_eq!(Limit::ALL[limit as usize], limit);
        }
    }
}
