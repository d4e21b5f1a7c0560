//! The file that a render makes: an image, or a film that can be continued and merged.

use std::path::{Path, PathBuf};

use super::share::Share;
use crate::checkpoint::{Checkpoint, Identity};
use crate::error::{Error, Result};
use crate::image::{Format, Image, Metadata, Transfer};
use crate::limits::Limits;

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Image(PathBuf),
    Film(PathBuf),
}

impl Target {
    /// By the file's extension.
    ///
    /// # Errors
    /// [`Error::Usage`] where no writer knows it.
    pub(super) fn of_path(path: PathBuf) -> Result<Self> {
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("film")) {
            return Ok(Self::Film(path));
        }
        Format::of_path(&path)?;
        Ok(Self::Image(path))
    }

    /// The file named `given`, or else one in the current folder after the name of the scene, for `share`.
    ///
    /// # Errors
    /// [`Error::Usage`] where no writer knows the extension, or `share` makes no image.
    pub(super) fn new(
        given: Option<PathBuf>,
        scene: &str,
        share: &Share,
        identity: &Identity,
    ) -> Result<Self> {
        let part = share.is_part(identity);
        let Some(path) = given else {
            let extension = if part { "film" } else { "png" };
            let suffix = share.suffix(identity);
            return Self::of_path(PathBuf::from(format!("{}{suffix}.{extension}", stem(scene))));
        };
        let output = Self::of_path(path)?;
        match &output {
            Self::Image(path) if part => Err(Error::Usage(format!(
                "{}: a part of a render makes no image: name a .film, for `ptfast merge`",
                path.display()
            ))),
            _ => Ok(output),
        }
    }

    pub(super) fn path(&self) -> &Path {
        match self {
            Self::Image(path) | Self::Film(path) => path,
        }
    }

    /// `transfer`, for images.
    pub(super) fn transfer(&self, transfer: Transfer) -> Option<Transfer> {
        matches!(self, Self::Image(_)).then_some(transfer)
    }

    /// Whether the file is there already, whole, of this render and with this curve.
    ///
    /// # Errors
    /// [`Error::Usage`] for files that cannot tell.
    pub(super) fn is_complete(
        &self,
        identity: &Identity,
        share: &Share,
        curve: Transfer,
        limits: &Limits,
    ) -> Result<bool> {
        Ok(match self {
            Self::Film(path) => Checkpoint::read(path, limits).is_ok_and(|there| {
                there.is_of(identity, share.shard, &share.samples) && there.is_complete()
            }),
            Self::Image(path) if !Format::of_path(path)?.has_metadata() => {
                return Err(Error::Usage(format!(
                    "{}: --skip-complete needs a file that tells what it is of: .png, .exr or .film",
                    path.display()
                )));
            }
            Self::Image(path) => is_image_of(path, identity, curve, limits),
        })
    }
}

fn is_image_of(path: &Path, identity: &Identity, curve: Transfer, limits: &Limits) -> bool {
    let Ok(there) = Metadata::read(path) else { return false };
    // The hash is not known before.
    let wanted = identity.metadata("");
    let same = |key| there.get(key).is_some() && there.get(key) == wanted.get(key);
    let transfer = there.get("ptfast:transfer");
    if !["ptfast:scene", "ptfast:seed", "ptfast:settings"].into_iter().all(same)
        || transfer.is_some_and(|name| name != curve.name())
    {
        return false;
    }
    // Those without a curve have the very values.
    Image::read_where(path, &|pixels, memory| limits.check_image(pixels, memory))
        .is_ok_and(|image| transfer.is_some() || there.get("ptfast:hash") == Some(&image.hash()))
}

/// `spheres` for `spheres` and for `folder/spheres.ron`.
fn stem(scene: &str) -> String {
    let stem = Path::new(scene).file_stem().unwrap_or_default().to_string_lossy();
    // `cloud:1000` is no name for a file everywhere.
    stem.replace(':', "-")
}
