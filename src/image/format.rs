//! The formats of image files, by their extensions.

use std::path::Path;

use crate::error::{Error, Result};

/// The image formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// 8-bit PNG.
    Png,
    /// OpenEXR of 32-bit floats, with run-length coding.
    Exr,
    /// Radiance RGBE.
    Hdr,
    /// Portable float map: the linear values as they are.
    Pfm,
}

impl Format {
    const ALL: [(&'static str, Self); 4] =
        [("png", Self::Png), ("exr", Self::Exr), ("hdr", Self::Hdr), ("pfm", Self::Pfm)];

    /// Whether files of this format contain [`Metadata`](super::Metadata).
    pub(crate) fn has_metadata(self) -> bool {
        matches!(self, Self::Png | Self::Exr)
    }

    /// Checks that files of this format, such as `path`, can have an alpha channel.
    ///
    /// # Errors
    /// If they cannot.
    pub(crate) fn check_alpha(self, path: &Path) -> Result<()> {
        match self {
            Self::Png | Self::Exr => Ok(()),
            Self::Hdr | Self::Pfm => Err(Error::Usage(format!(
                "{}: the format has no alpha channel, use .png or .exr",
                path.display()
            ))),
        }
    }

    /// The format for the extension of `path`.
    ///
    /// # Errors
    /// If no writer supports the extension.
    pub(crate) fn of_path(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let format = Self::ALL.iter().find(|(name, _)| *name == extension);
        format.map(|(_, format)| *format).ok_or_else(|| {
            Error::Usage(format!(
                "{}: no writer for the extension `{extension}`, use .png, .exr, .hdr or .pfm",
                path.display()
            ))
        })
    }
}
