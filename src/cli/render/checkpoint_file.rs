//! The checkpoint file of a render: continued if it belongs to the render, and never overwritten otherwise.

use std::borrow::Borrow;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::target::{Target, stem};
use crate::checkpoint::{Checkpoint, Part};
use crate::engine::RenderState;
use crate::error::{Error, Result};
use crate::image::{Format, Metadata};
use crate::limits::Limits;

/// Maximum number of bytes of the output's name that the default names keep, because file systems
/// limit names to 255 bytes.
const MAX_STEM: usize = 200;

/// The checkpoint file of one render, and the unfinished picture beside it.
pub(crate) struct CheckpointFile<'a> {
    /// The render whose checkpoint the file may hold.
    part: &'a Part,
    path: PathBuf,
    /// The unfinished picture, for renders that write an image.
    picture: Option<PathBuf>,
    /// Whether the user chose the name: then the file is kept when the render is complete.
    named: bool,
    /// Whether the render continues from the file.
    continued: bool,
}

impl<'a> CheckpointFile<'a> {
    /// The file for `part`. It is `named`, or else `NAME.partial.film` beside `output`. If the image is written to
    /// standard output, NAME is the name of the `scene`, and the file is in the current folder.
    pub(crate) fn new(part: &'a Part, output: &Target, scene: &str, named: Option<&Path>) -> Self {
        let picture = match output {
            Target::Image(path) => {
                Some(beside(path, &path.extension().unwrap_or_default().to_string_lossy()))
            }
            Target::Film(_) | Target::StandardOutput => None,
        };
        let default = || match output.path() {
            Some(path) => beside(path, "film"),
            None => PathBuf::from(format!("{}.partial.film", stem(scene))),
        };
        let path = named.map_or_else(default, Path::to_owned);
        Self { part, path, picture, named: named.is_some(), continued: false }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the user named the file.
    pub(crate) fn is_named(&self) -> bool {
        self.named
    }

    pub(crate) fn picture(&self) -> Option<&Path> {
        self.picture.as_deref()
    }

    /// The unfinished picture, unless a file of that name exists that is not an unfinished picture.
    /// A picture in a format without metadata is recognised by the checkpoint beside it.
    pub(crate) fn own_picture(&self) -> Option<&Path> {
        self.picture().filter(|picture| {
            let is_partial = Metadata::read(picture).is_ok_and(|metadata| metadata.is_partial());
            let has_metadata = Format::of_path(picture).is_ok_and(Format::has_metadata);
            let is_missing = picture.symlink_metadata().is_err();
            is_missing || is_partial || !has_metadata && self.continued
        })
    }

    /// Whether the file has samples of this part of this render.
    pub(crate) fn has_samples(&self) -> bool {
        Checkpoint::read_part(&self.path).is_ok_and(|found| found.mismatch(self.part).is_none())
    }

    pub(crate) fn exists(&self) -> bool {
        !fs::metadata(&self.path).is_err_and(|error| error.kind() == ErrorKind::NotFound)
    }

    /// The render so far, which is read from the file, or is empty if there is no file.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged, or belongs to another render.
    pub(crate) fn load(&mut self, limits: &Limits) -> Result<RenderState> {
        if !self.exists() {
            return self.part.empty_rendering();
        }
        self.continued = true;
        let checkpoint = Checkpoint::read(&self.path, limits).map_err(advise)?;
        checkpoint.resume(self.part).map_err(|mismatch| self.refuse(mismatch))
    }

    /// Writes `checkpoint`, unless another program has meanwhile written a file of another render
    /// or of another kind to this path.
    ///
    /// # Errors
    /// If the file cannot be written, or no longer belongs to this render.
    pub(crate) fn write(&self, checkpoint: &Checkpoint<impl Borrow<RenderState>>) -> Result<()> {
        self.check()?;
        // Writing takes time, and another render may meanwhile have written its checkpoint to this
        // path.
        checkpoint.write_if(&self.path, || self.check())
    }

    /// Cleans up once the output is written. A checkpoint file that the user named is kept, and the
    /// complete `checkpoint` is written to it. A checkpoint file with the default name and the
    /// unfinished picture are deleted.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(crate) fn finish(
        &self,
        checkpoint: &Checkpoint<impl Borrow<RenderState>>,
        has_advanced: bool,
    ) -> Result<()> {
        if let Some(picture) = self.own_picture().filter(|_| self.continued) {
            // A file that cannot be deleted does no harm.
            let _ = fs::remove_file(picture);
        }
        if self.named {
            return if has_advanced { self.write(checkpoint) } else { Ok(()) };
        }
        if self.has_samples() {
            let _ = fs::remove_file(&self.path);
        }
        Ok(())
    }

    /// Checks that the file is missing, or belongs to this part of this render.
    fn check(&self) -> Result<()> {
        if self.exists() {
            let found = Checkpoint::read_part(&self.path).map_err(advise)?;
            if let Some(mismatch) = found.mismatch(self.part) {
                return Err(self.refuse(mismatch));
            }
        }
        Ok(())
    }

    fn refuse(&self, mismatch: String) -> Error {
        advise(Error::input(self.path.display().to_string(), "", mismatch))
    }
}

/// `NAME.partial.EXTENSION` beside `NAME.png`.
fn beside(output: &Path, extension: &str) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let stem = &stem[..stem.floor_char_boundary(MAX_STEM)];
    output.with_file_name(format!("{stem}.partial.{extension}"))
}

/// Adds to an error of the checkpoint file what the user can do to render anyway.
fn advise(error: Error) -> Error {
    match error {
        Error::Input { file, place, message } => {
            let message = format!("{message}: delete it, or choose another file with --checkpoint");
            Error::Input { file, place, message }
        }
        other => other,
    }
}
