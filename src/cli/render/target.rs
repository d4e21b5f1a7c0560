//! The output of a render: an image, or a film that can be continued and merged.

use std::fmt;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::part_args::suffix;
use crate::checkpoint::{Checkpoint, Identity, Part};
use crate::cli::arguments::denoise::{DenoiseArgs, HASH_KEY};
use crate::denoise::Denoise;
use crate::engine::Layers;
use crate::error::{Error, Result};
use crate::image::{Display, Encoding, Format, Image, Metadata, layer_path};
use crate::limits::Limits;

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    Image(PathBuf),
    Film(PathBuf),
    /// A PNG image on standard output.
    StandardOutput,
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.path() {
            Some(path) => path.display().fmt(f),
            None => f.write_str("standard output"),
        }
    }
}

impl Target {
    /// Returns the kind of output that the extension of `path` selects; `-` is standard output.
    ///
    /// # Errors
    /// [`Error::Usage`] if no writer knows the extension.
    pub(crate) fn of_path(path: PathBuf) -> Result<Self> {
        if path.as_os_str() == "-" {
            return Ok(Self::StandardOutput);
        }
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("film")) {
            return Ok(Self::Film(path));
        }
        Format::of_path(&path)?;
        Ok(Self::Image(path))
    }

    /// Returns the file `given`. If it is `None`, returns a file in the current folder, named after
    /// the scene and `part`.
    ///
    /// # Errors
    /// [`Error::Usage`] if no writer knows the extension, or if the file is an image and `part` is not a
    /// whole render.
    pub(crate) fn new(given: Option<PathBuf>, scene: &str, part: &Part) -> Result<Self> {
        let Some(path) = given else {
            let extension = if part.is_whole() { "png" } else { "film" };
            let suffix = suffix(part);
            return Self::of_path(PathBuf::from(format!("{}{suffix}.{extension}", stem(scene))));
        };
        let output = Self::of_path(path)?;
        match &output {
            Self::Image(_) | Self::StandardOutput if !part.is_whole() => {
                Err(Error::Usage(format!(
                    "{output}: --shard and --sample-range render a part of an image: use -o part.film, then join \
                 the parts with `ptfast merge`"
                )))
            }
            _ => Ok(output),
        }
    }

    /// Checks that the output can have an alpha channel.
    ///
    /// # Errors
    /// [`Error::Usage`] if it cannot.
    pub(crate) fn check_alpha(&self) -> Result<()> {
        match self {
            Self::Image(path) => Format::of_path(path)?.check_alpha(path),
            Self::StandardOutput | Self::Film(_) => Ok(()),
        }
    }

    /// The files of `layers` besides the image.
    pub(crate) fn layer_files(&self, layers: &Layers) -> Vec<PathBuf> {
        match self {
            Self::Image(path)
                if Format::of_path(path).is_ok_and(|format| format != Format::Exr) =>
            {
                layers.iter().map(|layer| layer_path(path, layer.name())).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Whether the image has 8 bits per channel.
    pub(crate) fn has_8_bits(&self) -> bool {
        match self {
            Self::Image(path) => Format::of_path(path).is_ok_and(|format| format == Format::Png),
            Self::StandardOutput => true,
            Self::Film(_) => false,
        }
    }

    /// Whether the output is an EXR file, which holds layers.
    pub(crate) fn is_exr(&self) -> bool {
        self.path().is_some_and(|path| Format::of_path(path).is_ok_and(|f| f == Format::Exr))
    }

    /// The file; `None` for standard output.
    pub(crate) fn path(&self) -> Option<&Path> {
        match self {
            Self::Image(path) | Self::Film(path) => Some(path),
            Self::StandardOutput => None,
        }
    }

    /// Writes an image.
    ///
    /// # Errors
    /// Those of [`Image::write`], also for standard output.
    ///
    /// # Panics
    /// For films.
    pub(crate) fn write_image(
        &self,
        image: &Image,
        display: Display,
        metadata: &Metadata,
    ) -> Result<()> {
        match self {
            Self::Film(_) => unreachable!("films have samples"),
            Self::Image(path) => image.write(path, display, metadata),
            Self::StandardOutput => {
                let write = || {
                    // Encode to memory first: the encoder would hide the kind of a write error.
                    let mut png = Vec::new();
                    image.write_png(&mut png, display, metadata)?;
                    let mut out = io::stdout().lock();
                    out.write_all(&png).and_then(|()| out.flush())
                };
                match write() {
                    // The reader closed the pipe early, which is not an error.
                    Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
                    written => written.map_err(Error::io(Path::new("standard output"), "write")),
                }
            }
        }
    }

    /// Whether the file exists, is complete, and has this render with this appearance, denoised as asked for and with the
    /// layers asked for.
    ///
    /// # Errors
    /// [`Error::Usage`] for formats without metadata.
    pub(crate) fn is_complete(
        &self,
        part: &Part,
        denoise: (&DenoiseArgs, &Layers),
        display: Display,
        limits: &Limits,
    ) -> Result<bool> {
        Ok(match self {
            Self::Film(path) => Checkpoint::read(path, limits)
                .is_ok_and(|there| there.part() == *part && there.rendering.is_complete()),
            Self::Image(path) if Format::of_path(path)?.has_metadata() => {
                is_image_of(path, &part.identity, denoise, display, limits)
            }
            Self::Image(_) | Self::StandardOutput => {
                return Err(Error::Usage(format!(
                    "{self}: --skip-complete needs a format with metadata: .png, .exr or .film"
                )));
            }
        })
    }
}

fn is_image_of(
    path: &Path,
    identity: &Identity,
    (denoise, layers): (&DenoiseArgs, &Layers),
    display: Display,
    limits: &Limits,
) -> bool {
    let (Ok(format), Ok(there)) = (Format::of_path(path), Metadata::read(path)) else {
        return false;
    };
    // The hash is unknown before the render.
    let wanted = identity.metadata("");
    let same = |key| there.get(key).is_some() && there.get(key) == wanted.get(key);
    if !["ptfast:scene", "ptfast:seed", "ptfast:settings"].into_iter().all(same)
        || !display.is_noted_in(format, &there)
        || !denoise.is_noted_in(&there, layers)
    {
        return false;
    }
    // EXR files store the linear values, to which the hash belongs. PNG files must be readable.
    let noisy = PathBuf::from(format!("{}:noisy", path.display()));
    let (path, hash_key) = match denoise.denoise {
        Some(Denoise::Oidn) if format == Format::Exr => (&*noisy, "ptfast:hash"),
        Some(_) => (path, HASH_KEY),
        None => (path, "ptfast:hash"),
    };
    let is_same =
        |image: Image| format == Format::Png || there.get(hash_key) == Some(&image.hash());
    Image::read_encoded(path, Encoding::Linear, &|pixels, memory| {
        limits.check_image(pixels, memory)
    })
    .is_ok_and(is_same)
}

/// The name of output files for a scene: `spheres` for `spheres` and `folder/spheres.ron`.
pub(crate) fn stem(scene: &str) -> String {
    if scene == "-" {
        return "stdin".to_owned();
    }
    let stem = Path::new(scene).file_stem().unwrap_or_default().to_string_lossy();
    // Some file systems do not allow `cloud:1000`.
    stem.replace(':', "-")
}
