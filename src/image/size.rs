//! The size of image files, which is checked before they are decoded.

/// The size of an image file, which is known before its pixels are decoded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    /// Number of pixels.
    pub(crate) pixels: u64,
    /// Whether channels have more than 8 bits.
    pub(crate) deep: bool,
    /// Bytes of memory that decoding the file takes.
    pub(crate) memory: u64,
}

/// Checks the size of an image file. Its message is reported as an error.
pub(super) type Allow<'a> = &'a dyn Fn(Size) -> Result<(), String>;
