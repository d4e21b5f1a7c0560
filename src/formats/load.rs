//! Loads scenes by name or path, or from a description.

use std::path::Path;

use super::assets::Files;
use super::{ImportOptions, SceneDescription, Source, ron};
use crate::error::Result;
use crate::limits::{Budget, Limits};
use crate::scene::{Scene, SceneFile, resolve};

impl Scene {
    /// Loads the built-in scene with this name ([`BUILTIN_NAMES`](crate::BUILTIN_NAMES)), generates `cloud:N`, `mesh:N`
    /// or `forest:N`, or reads the file at this path: a scene (`.ron`, `.json`), a scene of another program (`.gltf`,
    /// `.glb`, `.pbrt`), or a mesh with its materials (`.obj`, `.ply`). [`SceneDescription`]
    /// has options for the last two, and can be edited.
    ///
    /// # Errors
    /// If the file cannot be read or its content is wrong. The message is one line that names the
    /// place.
    pub fn load(name_or_path: &str) -> Result<Self> {
        Self::load_within(name_or_path, &Limits::default())
    }

    /// As [`load`](Self::load), with `limits` instead of the default ones. They also apply to
    /// renders of the scene.
    ///
    /// # Errors
    /// As [`load`](Self::load), and if a limit is exceeded. The message names the limit and ends
    /// with the advice of [`Limits::with_advice`], if one is set.
    pub fn load_within(name_or_path: &str, limits: &Limits) -> Result<Self> {
        Source::find(name_or_path)?.read(limits)?.resolve()
    }

    /// Parses `text`, a scene in RON. Paths of meshes and textures are relative to the current
    /// folder.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_ron(text: &str) -> Result<Self> {
        ron::from_ron("scene", text).and_then(|file| Self::from_file(&file))
    }

    /// Checks the scene that `file` describes. Paths of meshes and textures are relative to the
    /// current folder.
    ///
    /// # Errors
    /// If a number is out of range, a name is unknown or used twice, or a mesh or texture cannot be
    /// read.
    pub fn from_file(file: &SceneFile) -> Result<Self> {
        Self::from_file_within(file, Path::new(""), &Limits::default())
    }

    /// As [`from_file`](Self::from_file), with paths relative to `folder`, and with `limits`
    /// instead of the default ones.
    ///
    /// # Errors
    /// As [`from_file`](Self::from_file), and if a limit is exceeded.
    pub fn from_file_within(file: &SceneFile, folder: &Path, limits: &Limits) -> Result<Self> {
        resolve("scene", folder, file, &Files::default(), Budget::new(limits, 0))
    }
}

impl SceneDescription {
    /// Loads the description of a scene, which [`Scene::load`] names. `options` apply to scenes of other programs.
    ///
    /// # Errors
    /// If the file cannot be read, its content is wrong, or a limit is exceeded. The message is one line that names
    /// the place.
    pub fn load(name_or_path: &str, options: &ImportOptions, limits: &Limits) -> Result<Self> {
        Source::find(name_or_path)?.read_with(limits, options)
    }
}
