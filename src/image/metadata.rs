//! Text entries of the headers of image files.

/// The metadata key of the number of samples, used only for pictures of unfinished renders.
const PARTIAL: &str = "ptfast:partial";

/// Text entries of a file's header. Equal renders have equal entries.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata(pub Vec<(String, String)>);

impl Metadata {
    /// Metadata that names the program and its version.
    pub fn of_program() -> Self {
        Self::default().with("Software", concat!("ptfast ", env!("CARGO_PKG_VERSION")))
    }

    /// Metadata of the picture of an unfinished render that has `samples` samples.
    pub(crate) fn of_partial(samples: u64) -> Self {
        Self::of_program().with(PARTIAL, samples)
    }

    /// Whether the file is the picture of an unfinished render.
    pub(crate) fn is_partial(&self) -> bool {
        self.get(PARTIAL).is_some()
    }

    /// Adds one entry.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl ToString) -> Self {
        self.0.push((key.to_owned(), value.to_string()));
        self
    }

    /// The value of the entry `key`.
    pub fn get(&self, key: &str) -> Option<&str> {
        let entry = self.0.iter().find(|(name, _)| name == key);
        entry.map(|(_, value)| value.as_str())
    }
}
