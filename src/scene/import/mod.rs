//! Scenes of other programs. Each format has its own module, which turns the bytes of a file into our
//! scene description.

mod gltf;
mod mtl;
mod pbrt;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::budget::Budget;
use super::description::SceneFile;
use super::primitive::{MeshFile, NamedMesh, PrimitiveFile};
use super::within::path_within;
use crate::error::{Error, Result};

/// A format of other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// glTF 2.0.
    Gltf,
    /// pbrt-v4.
    Pbrt,
}

impl Format {
    /// Extensions of files, and their formats.
    const ALL: [(&'static str, Self); 3] =
        [("glb", Self::Gltf), ("gltf", Self::Gltf), ("pbrt", Self::Pbrt)];

    /// The format of files with this extension in lower case.
    pub(super) fn of(extension: &str) -> Option<Self> {
        Self::ALL.iter().find(|(name, _)| *name == extension).map(|&(_, format)| format)
    }
}

/// What happens to a texture or mesh that a scene of another program names, but that is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Missing {
    /// The scene is rejected.
    #[default]
    Error,
    /// Textures become grey, meshes are left out, and a warning names the file.
    Grey,
}

impl Missing {
    /// All choices.
    pub(crate) const ALL: [Self; 2] = [Self::Error, Self::Grey];

    /// The name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Grey => "grey",
        }
    }
}

/// How scenes of other programs are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ImportOptions {
    /// What happens to missing textures and meshes.
    pub missing: Missing,
    /// Whether everything that ptfast lacks is an error instead of a warning.
    pub strict: bool,
    /// Name or number of the animation of a glTF file that poses its scene.
    pub animation: Option<String>,
    /// Time of the animation in seconds.
    pub at: f64,
    /// Name of the variant of materials of a glTF file.
    pub variant: Option<String>,
}

/// A scene of another program.
pub(super) struct Imported {
    pub(super) file: SceneFile,
    /// Sentences that name what ptfast lacks, and what it does instead.
    pub(super) warnings: Vec<String>,
}

/// The circumstances of an import, and its warnings.
pub(super) struct Import<'a> {
    /// The folder of the file, to which paths are relative.
    folder: &'a Path,
    options: &'a ImportOptions,
    budget: &'a Budget,
    /// Warnings, and how often each applies.
    warnings: Vec<(String, usize)>,
    /// Number of warnings that were not kept.
    more: usize,
    /// Sentences about choices that the user may want to change.
    notes: Vec<String>,
}

/// First segment of Russian roulette in scenes for pbrt and glTF. Interiors have less error after the same
/// time than with 5, or with 3 as in pbrt-v4 (`profiling/measured.md`).
const ROULETTE: u32 = 2;

/// Largest number of different warnings that are kept.
const MOST_WARNINGS: usize = 100;

/// A name like `own` that is not in `names` yet, which is added. Names that are taken get a number, at
/// least `number`.
fn unique(names: &mut HashSet<String>, own: &str, mut number: usize) -> String {
    let mut name = own.to_owned();
    while !names.insert(name.clone()) {
        name = format!("{own} {number}");
        number += 1;
    }
    name
}

impl<'a> Import<'a> {
    fn new(folder: &'a Path, options: &'a ImportOptions, budget: &'a Budget) -> Self {
        Self { folder, options, budget, warnings: Vec::new(), more: 0, notes: Vec::new() }
    }

    /// Notes that ptfast lacks something, and what it does instead.
    fn warn(&mut self, message: impl Into<String>) {
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
    fn into_warnings(self, file: &str) -> Result<Vec<String>> {
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

    /// Notes a choice that the user may want to change. Its sentence begins with the file.
    fn note(&mut self, message: impl Into<String>) {
        self.notes.push(message.into());
    }

    /// The path of `file`, which must be within the folder unless the limits allow others.
    fn path_within(&self, file: &str) -> Result<PathBuf> {
        path_within(self.folder, file, &self.budget.limits)
    }

    /// Returns false, with a warning, if the texture or mesh in `file` is missing and
    /// [`Missing::Grey`] is set. Otherwise the reader of the file reports that it is missing.
    fn is_usable(&mut self, file: &str, instead: &str) -> bool {
        let usable = self.options.missing == Missing::Error || self.folder.join(file).exists();
        if !usable {
            self.warn(format!("{file} is missing, {instead}"));
        }
        usable
    }
}

/// The error that [`ImportOptions::strict`] makes of a warning.
pub(super) fn rejected(warning: &str) -> Error {
    Error::Usage(format!("{warning}; `strict` rejects that"))
}

/// Adds the materials that OBJ files name to the scene called `name`, for meshes without a material.
/// Returns the warnings.
///
/// # Errors
/// If a file cannot be read or its content is wrong.
pub(super) fn add_materials(
    name: &str,
    folder: &Path,
    options: &ImportOptions,
    budget: &Budget,
    scene: &mut SceneFile,
) -> Result<Vec<String>> {
    let mut import = Import::new(folder, options, budget);
    let (mut files, mut seen) = (Vec::new(), HashSet::new());
    let parts = scene.meshes.0.iter().flat_map(|(_, mesh)| match mesh {
        NamedMesh::File(_) => &[],
        NamedMesh::Parts(parts) => &parts[..],
    });
    for primitive in scene.primitives.iter().chain(parts) {
        if let PrimitiveFile::Mesh(MeshFile { file, material: None, .. }) = primitive
            && file.to_lowercase().ends_with(".obj")
            && seen.insert(file.clone())
        {
            files.push(file.clone());
        }
    }
    for file in files {
        mtl::add_materials(&mut import, &file, scene)?;
    }
    import.into_warnings(name)
}

/// Reads the scene in `path`.
///
/// # Errors
/// If a file cannot be read, its content is wrong, or a limit is exceeded. With
/// [`ImportOptions::strict`], also if ptfast lacks something that the scene asks for.
pub(super) fn read(
    path: &Path,
    format: Format,
    options: &ImportOptions,
    budget: &Budget,
) -> Result<Imported> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut import = Import::new(folder, options, budget);
    let file = match format {
        Format::Gltf => gltf::read(path, &mut import)?,
        Format::Pbrt => pbrt::read(path, &mut import)?,
    };
    let warnings = import.into_warnings(&path.display().to_string())?;
    Ok(Imported { file, warnings })
}
