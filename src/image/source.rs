//! The content of an image file, on disk or in memory.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::Path;

use crate::error::{Error, Result};
use crate::input;

/// A stream that decoders can read.
pub(super) trait Stream: BufRead + Seek {}

impl<T: BufRead + Seek> Stream for T {}

/// An image file, or its content.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    /// The file, or the file that contains the image.
    path: &'a Path,
    /// The layer or part of an EXR file.
    layer: Option<&'a str>,
    /// The content of the image and its number, if it is part of the file.
    part: Option<(&'a [u8], u32)>,
}

/// The end of the name of files that may have layers.
const LAYERED: &str = ".exr";

/// Splits the name of a layer from that of its file: `sky.exr` and `diffuse` of `sky.exr:diffuse`.
pub(crate) fn split_layer(file: &str) -> (&str, Option<&str>) {
    let layered = format!("{LAYERED}:");
    match file.to_ascii_lowercase().find(&layered) {
        Some(begin) => {
            let (file, layer) = file.split_at(begin + LAYERED.len());
            (file, Some(&layer[1..]))
        }
        None => (file, None),
    }
}

impl<'a> Source<'a> {
    /// The image file at `path`, which may end with the name of a layer.
    pub(crate) fn file(path: &'a Path) -> Self {
        match path.to_str().map(split_layer) {
            Some((file, layer)) => Self { path: Path::new(file), layer, part: None },
            None => Self { path, layer: None, part: None },
        }
    }

    /// Image number `index` of the file at `path`, with the content `bytes`.
    pub(crate) fn part(path: &'a Path, index: u32, bytes: &'a [u8]) -> Self {
        Self { path, layer: None, part: Some((bytes, index)) }
    }

    /// The name of the layer or part of an EXR file, if the path ends with one.
    pub(super) fn layer(&self) -> Option<&'a str> {
        self.layer
    }

    /// Number of bytes.
    pub(super) fn length(&self) -> Result<u64> {
        self.part.map_or_else(|| input::length(self.path), |(bytes, _)| Ok(bytes.len() as u64))
    }

    pub(super) fn open(&self) -> Result<Box<dyn Stream + 'a>> {
        match self.part {
            Some((bytes, _)) => Ok(Box::new(Cursor::new(bytes))),
            None => {
                let file = File::open(self.path).map_err(Error::io(self.path, "read"))?;
                Ok(Box::new(BufReader::new(file)))
            }
        }
    }

    /// The whole content.
    pub(super) fn bytes(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.open()?.read_to_end(&mut bytes).map_err(Error::io(self.path, "read"))?;
        Ok(bytes)
    }

    /// Whether the file has this extension. A part of a file has none.
    pub(super) fn has_extension(&self, extension: &str) -> bool {
        let own = self.path.extension().filter(|_| self.part.is_none());
        own.is_some_and(|own| own.eq_ignore_ascii_case(extension))
    }

    pub(crate) fn path(&self) -> &'a Path {
        self.path
    }

    /// An error of the content.
    pub(super) fn bad(&self, message: String) -> Error {
        let place = self.part.map_or(String::new(), |(_, index)| format!("images[{index}]"));
        Error::input(self.path.display().to_string(), place, message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_follow_the_names_of_exr_files() {
        assert_eq!(split_layer("a/sky.exr"), ("a/sky.exr", None));
        assert_eq!(split_layer("a/Sky.EXR:View Layer.N"), ("a/Sky.EXR", Some("View Layer.N")));
        assert_eq!(split_layer("c:/a.exr:b.exr:c"), ("c:/a.exr", Some("b.exr:c")));
        assert_eq!(split_layer("a.png:b"), ("a.png:b", None));
    }
}
