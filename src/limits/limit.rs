//! Limits that the user may raise.

use super::memory;
use super::{MAX_PRIMITIVES, MAX_SIDE};

/// What there may be only so much of, unless the user allows more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// Bytes of a scene file.
    SceneBytes,
    /// How deep the brackets of a scene file are nested.
    Nesting,
    /// Primitives of a scene.
    Primitives,
    /// Bytes of the file of a mesh.
    MeshBytes,
    /// Bytes of a texture in memory, 12 a pixel.
    TextureBytes,
    /// Pixels of an image.
    Pixels,
    /// Bytes of memory altogether, by estimate.
    Memory,
}

impl Limit {
    /// All limits.
    pub const ALL: [Self; 7] = [
        Self::SceneBytes,
        Self::Nesting,
        Self::Primitives,
        Self::MeshBytes,
        Self::TextureBytes,
        Self::Pixels,
        Self::Memory,
    ];

    /// The name in messages and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::SceneBytes => "scene-bytes",
            Self::Nesting => "nesting",
            Self::Primitives => "primitives",
            Self::MeshBytes => "mesh-bytes",
            Self::TextureBytes => "texture-bytes",
            Self::Pixels => "pixels",
            Self::Memory => "memory",
        }
    }

    /// Where the user says nothing.
    fn usual(self) -> u64 {
        match self {
            Self::SceneBytes => 1 << 28,
            Self::Nesting => 32,
            Self::Primitives => 1 << 24,
            Self::MeshBytes => 1 << 32,
            Self::TextureBytes => 1 << 30,
            // 3 GiB of f32 RGB.
            Self::Pixels => 1 << 28,
            Self::Memory => memory::of_process(),
        }
    }

    /// What it can be raised to.
    pub fn most(self) -> u64 {
        match self {
            Self::SceneBytes | Self::MeshBytes | Self::TextureBytes | Self::Memory => u64::MAX,
            // The depth that a parser's stack is safe with.
            Self::Nesting => 127,
            Self::Primitives => MAX_PRIMITIVES as u64,
            Self::Pixels => MAX_SIDE as u64 * MAX_SIDE as u64,
        }
    }
}

/// What a scene or a render was refused for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refused {
    /// It needs more than a limit allows, but not more than the limit can be raised to.
    Beyond(Limit, u64),
    /// The scene names a file outside its folder.
    OutsideFile,
}

/// What error messages tell users to do, in the words of the program that they use.
#[derive(Clone, Copy, Debug)]
struct Advice(fn(Refused) -> String);

/// Limits with other words are the same limits.
impl PartialEq for Advice {
    fn eq(&self, _: &Self) -> bool {
        true
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
    /// The usual ones; of memory, what the process may use.
    fn default() -> Self {
        Self { values: Limit::ALL.map(Limit::usual), outside_files: false, advice: None }
    }
}

impl Limits {
    /// What is allowed.
    pub fn get(&self, limit: Limit) -> u64 {
        self.values[limit as usize]
    }

    /// Allows `value`, but not more than [can be](Limit::most).
    #[must_use]
    pub fn with(mut self, limit: Limit, value: u64) -> Self {
        self.values[limit as usize] = value.min(limit.most());
        self
    }

    /// Whether textures and meshes may be outside the folder of the scene file.
    #[must_use]
    pub fn with_outside_files(self, outside_files: bool) -> Self {
        Self { outside_files, ..self }
    }

    /// Whether textures and meshes may be outside the folder of the scene file.
    pub fn outside_files(&self) -> bool {
        self.outside_files
    }

    /// Ends error messages with what `advice` says, such as `--limit pixels=100 raises it`.
    #[must_use]
    pub fn with_advice(self, advice: fn(Refused) -> String) -> Self {
        Self { advice: Some(Advice(advice)), ..self }
    }

    /// The end of an error message.
    pub(crate) fn advice(&self, refused: Refused) -> String {
        self.advice.map_or_else(String::new, |Advice(advice)| format!(": {}", advice(refused)))
    }

    /// `Err` where an image is of too many pixels, or reading it takes too many bytes of memory.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn check_image(&self, pixels: u64, memory: u64) -> Result<(), String> {
        self.check(Limit::Pixels, pixels).and_then(|()| self.check(Limit::Memory, memory))
    }

    /// Checks `value` against the limit.
    ///
    /// # Errors
    /// A message, if it is beyond the limit.
    pub fn check(&self, limit: Limit, value: u64) -> Result<(), String> {
        let allowed = self.get(limit);
        if value <= allowed {
            return Ok(());
        }
        let name = limit.name();
        // Memory is estimated step by step, and the next may need more.
        let least = if limit == Limit::Memory { "at least " } else { "" };
        let raise = match value <= limit.most() {
            true => self.advice(Refused::Beyond(limit, value)),
            false => String::new(),
        };
        Err(format!("the limit of {name} is {allowed}, this needs {least}{value}{raise}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_limit_and_end_with_advice() {
        let limits = Limits::default().with(Limit::MeshBytes, 100).with(Limit::Memory, 1000);
        assert_eq!(limits.check(Limit::MeshBytes, 100), Ok(()));
        let message = "the limit of mesh-bytes is 100, this needs 101";
        assert_eq!(limits.check(Limit::MeshBytes, 101), Err(message.to_owned()));
        let limits = limits.with_advice(|refused| format!("{refused:?}"));
        let message = "the limit of memory is 1000, this needs at least 2000: Beyond(Memory, 2000)";
        assert_eq!(limits.check(Limit::Memory, 2000), Err(message.to_owned()));
        let raised = limits.with(Limit::Nesting, 1 << 40);
        assert_eq!(raised.get(Limit::Nesting), 127);
        let message = "the limit of nesting is 127, this needs 128";
        assert_eq!(raised.check(Limit::Nesting, 128), Err(message.to_owned()));
        for limit in Limit::ALL {
            assert!((1..=limit.most()).contains(&limit.usual()), "{limit:?}");
            assert_eq!(Limit::ALL[limit as usize], limit);
        }
    }
}
