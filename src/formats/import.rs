//! The import of scenes of other programs: options, warnings, and what all formats share.

use std::collections::HashSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::origin;
use crate::error::{Error, Result};
use crate::image::split_layer;
use crate::input::path_within;
use crate::limits::Budget;
use crate::scene::{RenderDefaults, SceneFile};

/// A format of scenes of other programs.
#[derive(Debug)]
pub struct Format {
    /// The extensions of its files, in lower case.
    pub(crate) extensions: &'static [&'static str],
    /// Reads the scene in the file at this path.
    pub(crate) read: fn(&Path, &mut Import<'_>) -> Result<SceneFile>,
    /// What a map that the user adds shows in its middle.
    pub(crate) middle: Middle,
}

/// The direction that a latitude-longitude map of the user shows in its middle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Middle {
    /// −z, as in scene files of ptfast.
    #[default]
    MinusZ,
    /// +x, as in three.js, the viewer of Khronos, and Blender after its export.
    X,
}

impl Middle {
    /// The rotation of the map about y in degrees.
    pub(crate) fn turn(self) -> f32 {
        match self {
            Self::MinusZ => 0.0,
            Self::X => -90.0,
        }
    }
}

/// What happens to a texture or mesh that a scene of another program names, but that is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Missing {
    /// The scene is rejected.
    #[default]
    Error,
    /// Textures become grey, meshes are left out, and a warning names the file.
    Grey,
}

names! { pub Missing: Error = "error", Grey = "grey" }

/// The units of the lights of glTF files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LightUnits {
    /// One candela, one lux and one nit count as 1.
    #[default]
    File,
    /// Lights were exported by Blender, which multiplies watts by 683 for lamps, but not for emission.
    Blender,
}

names! { pub LightUnits: File = "file", Blender = "blender" }

/// How scenes of other programs are read. [`Default`] gives the usual options.
///
/// ```
/// let mut options = ptfast::ImportOptions::default();
/// options.animation = Some("walk".to_owned());
/// options.at = 1.5;
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ImportOptions {
    /// What happens to missing textures and meshes.
    pub missing: Missing,
    /// Whether everything that ptfast lacks is an error instead of a warning.
    pub strict: bool,
    /// Name or number of the animation of a glTF file that poses its scene.
    pub animation: Option<String>,
    /// Time of the animation in seconds, 0 or more.
    pub at: f64,
    /// Name of the variant of materials of a glTF file.
    pub variant: Option<String>,
    /// The units of the lights of glTF files.
    pub light_units: LightUnits,
    /// Whether an environment map replaces the background, so that a file without camera and light gets neither sky
    /// nor ground. See [`SceneDescription::with_environment`](crate::SceneDescription::with_environment).
    pub environment: bool,
    /// Whether a file without camera and light gets no ground.
    pub no_ground: bool,
    /// Whether the z-axis of a glTF, OBJ or PLY file points up, instead of the y-axis.
    pub z_up: bool,
    /// Width and height of the picture in pixels, if they are not the usual ones. The view of a file without camera
    /// depends on their ratio.
    pub size: Option<(u32, u32)>,
}

impl ImportOptions {
    /// Whether all vertices are where the file has them.
    pub(crate) fn keeps_pose(&self) -> bool {
        self.animation.is_none() && !self.z_up
    }

    /// The width of the picture, divided by its height.
    pub(crate) fn aspect(&self) -> f64 {
        let usual = RenderDefaults::default();
        let (width, height) = self.size.unwrap_or((usual.width, usual.height));
        f64::from(width) / f64::from(height)
    }
}

/// A scene of another program.
pub(crate) struct Imported {
    pub(crate) file: SceneFile,
    /// Sentences that name what ptfast lacks, and what it does instead.
    pub(crate) warnings: Vec<String>,
    /// Whether its lamps may be in the units of Blender, although the options do not say so.
    pub(crate) maybe_blender: bool,
}

/// The circumstances of an import, and its warnings.
pub(crate) struct Import<'a> {
    /// The folder of the file, to which paths are relative.
    pub(crate) folder: &'a Path,
    pub(crate) options: &'a ImportOptions,
    pub(crate) budget: &'a Budget,
    /// The point of the file that becomes the origin of the scene. Readers subtract it before they round.
    pub(crate) origin: DVec3,
    /// Warnings, and how often each applies.
    warnings: Vec<(String, usize)>,
    /// Number of warnings that were not kept.
    more: usize,
    /// Sentences about choices that the user may want to change.
    notes: Vec<String>,
    /// As in [`Imported`].
    pub(crate) maybe_blender: bool,
    /// How many parts of the file had a number so far.
    numbered: usize,
}

/// Largest number of different warnings that are kept.
const MOST_WARNINGS: usize = 100;

/// A name like `own` that is not in `names` yet, which is added. Names that are taken get a number, at
/// least `number`.
pub(crate) fn unique(names: &mut HashSet<String>, own: &str, mut number: usize) -> String {
    let mut name = own.to_owned();
    while !names.insert(name.clone()) {
        name = format!("{own} {number}");
        number += 1;
    }
    name
}

impl<'a> Import<'a> {
    pub(crate) fn new(folder: &'a Path, options: &'a ImportOptions, budget: &'a Budget) -> Self {
        let (origin, (warnings, notes)) = (DVec3::ZERO, Default::default());
        let (maybe_blender, numbered) = (false, 0);
        Self { folder, options, budget, origin, warnings, more: 0, notes, maybe_blender, numbered }
    }

    /// Notes that ptfast lacks something, and what it does instead.
    pub(crate) fn warn(&mut self, message: impl Into<String>) {
        let message = message.into();
        if let Some((_, count)) = self.warnings.iter_mut().find(|(known, _)| *known == message) {
            *count += 1;
        } else if self.warnings.len() < MOST_WARNINGS {
            self.warnings.push((message, 1));
        } else {
            self.more += 1;
        }
    }

    /// The warnings and notes as sentences that begin with the `file`.
    ///
    /// # Errors
    /// With [`ImportOptions::strict`], if there is a warning.
    pub(crate) fn into_warnings(self, file: &str) -> Result<Vec<String>> {
        let sentence = |(message, count): (String, usize)| match count {
            1 => format!("{file}: {message}"),
            _ => format!("{file}: {message} ({count} times)"),
        };
        let mut warnings: Vec<String> = self.warnings.into_iter().map(sentence).collect();
        if let Some(warning) = warnings.first()
            && self.options.strict
        {
            return Err(rejected(warning));
        }
        if self.more > 0 {
            warnings.push(format!("{file}: there are {} more warnings", self.more));
        }
        warnings.extend(self.notes.iter().map(|note| format!("{file} {note}")));
        Ok(warnings)
    }

    /// The number of the next part of the file. It must not depend on what other files there are.
    pub(crate) fn number(&mut self) -> usize {
        self.numbered += 1;
        self.numbered - 1
    }

    /// Notes a choice that the user may want to change. Its sentence begins with the file.
    pub(crate) fn note(&mut self, message: impl Into<String>) {
        self.notes.push(message.into());
    }

    /// The path of `file`, which must be within the folder unless the limits allow others.
    pub(crate) fn path_within(&self, file: &str) -> Result<PathBuf> {
        path_within(self.folder, file, &self.budget.limits)
    }

    /// An error if `path` is missing, unless [`Missing::Grey`] is set.
    pub(crate) fn require(&self, path: &Path) -> Result<()> {
        if self.options.missing == Missing::Grey || path.exists() {
            return Ok(());
        }
        let error = Error::io(path, "read")(ErrorKind::NotFound.into());
        Err(Error::Unread { error: Box::new(error), missing: true, advice: WITHOUT_MISSING })
    }

    /// Returns false, with a warning, if the texture or mesh in `file` is missing and
    /// [`Missing::Grey`] is set. Otherwise the reader of the file reports that it is missing.
    pub(crate) fn is_usable(&mut self, file: &str, instead: &str) -> bool {
        let exists = || self.folder.join(split_layer(file).0).exists();
        let usable = self.options.missing == Missing::Error || exists();
        if !usable {
            self.warn(format!("{file} is missing, {instead}"));
        }
        usable
    }
}

/// How to do without a missing file.
pub(crate) const WITHOUT_MISSING: &str = "; `--missing grey` does without such files";

/// The error that [`ImportOptions::strict`] makes of a warning.
pub(crate) fn rejected(warning: &str) -> Error {
    Error::Usage(format!("{warning}; `--strict` rejects that"))
}

/// Reads the scene in `path`.
///
/// # Errors
/// If a file cannot be read, its content is wrong, or a limit is exceeded. With
/// [`ImportOptions::strict`], also if ptfast lacks something that the scene asks for.
pub(crate) fn read(
    path: &Path,
    format: &Format,
    options: &ImportOptions,
    budget: &Budget,
) -> Result<Imported> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut import = Import::new(folder, options, budget);
    let mut file = (format.read)(path, &mut import)?;
    if let Some(origin) = origin::of_scene(&file) {
        // Reading again takes as much memory as the first time, which is counted already.
        drop(file);
        let again = Budget::new(&budget.limits, 0);
        let mut moved = Import { origin, ..Import::new(folder, options, &again) };
        file = (format.read)(path, &mut moved)?;
        file.origin = origin.to_array();
        import.note(origin::note(origin));
    }
    let maybe_blender = import.maybe_blender;
    let warnings = import.into_warnings(&path.display().to_string())?;
    Ok(Imported { file, warnings, maybe_blender })
}

/// Reads the scene in `path` relative to the point `origin` of the file, without warnings.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_from(
    path: &Path,
    format: &Format,
    options: &ImportOptions,
    origin: DVec3,
    budget: &Budget,
) -> Result<SceneFile> {
    let folder = path.parent().unwrap_or(Path::new(""));
    (format.read)(path, &mut Import { origin, ..Import::new(folder, options, budget) })
}
