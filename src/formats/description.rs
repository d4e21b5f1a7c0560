//! A scene whose description is read, but not checked yet.

use std::path::{Path, PathBuf};

use super::assets::Files;
use super::import::{Middle, WITHOUT_MISSING};
use super::reference;
use super::ron::{self, Form, locate};
use crate::error::{Error, Result};
use crate::image;
use crate::input::length;
use crate::limits::Budget;
use crate::scene::{Scene, SceneFile, resolve};
use crate::shading::Background;
use crate::shading::light::EnvironmentMap;

/// The description of a scene with the folder of its files. It can be edited before it becomes a [`Scene`].
///
/// ```no_run
/// use ptfast::{ImportOptions, Limits, SceneDescription};
///
/// # fn main() -> ptfast::Result<()> {
/// let mut options = ImportOptions::default();
/// options.variant = Some("beach".to_owned());
/// let mut description = SceneDescription::load("shoe.glb", &options, &Limits::default())?;
/// description.set("laces.roughness=0.4")?;
/// description.file.camera.look_at = [0.0, 0.1, 0.0];
/// let scene = description.resolve()?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct SceneDescription {
    pub(crate) name: String,
    pub(crate) folder: PathBuf,
    /// The scene as written. Its paths are relative to [`folder`](Self::folder).
    pub file: SceneFile,
    pub(crate) budget: Budget,
    /// The text with its form, to locate errors.
    pub(crate) text: Option<(Form, String)>,
    /// What ptfast lacks of a scene of another program.
    pub(crate) warnings: Vec<String>,
    /// What a map that the user adds shows in its middle.
    pub(crate) middle: Middle,
    /// Whether other programs wrote the scene, so that the options for missing files apply.
    pub(crate) is_imported: bool,
    /// Whether lamps may be in the units of Blender, although the options do not say so.
    pub(crate) maybe_blender: bool,
    /// The name of the file to which long lists of triangles may refer.
    pub(crate) lists: Option<String>,
    pub(crate) files: Files,
}

impl SceneDescription {
    pub(crate) fn new(name: String, folder: PathBuf, file: SceneFile, budget: Budget) -> Self {
        let (text, warnings, middle) = Default::default();
        let (is_imported, maybe_blender, lists) = (false, false, None);
        Self {
            name,
            folder,
            file,
            budget,
            text,
            warnings,
            middle,
            is_imported,
            maybe_blender,
            lists,
            files: Files::default(),
        }
    }

    /// The folder to which paths are relative; empty for the current folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Sentences that name what ptfast lacks of a scene of another program, and what it does instead.
    pub fn warnings(&self) -> impl Iterator<Item = &str> {
        self.warnings.iter().map(String::as_str)
    }

    /// Replaces long lists of triangles of a scene of another program by references to its file. The primitives must
    /// be those of the file.
    pub(crate) fn shorten(&mut self) {
        if let Some(name) = &self.lists {
            reference::shorten(&mut self.file, name);
        }
    }

    /// Replaces the background by the latitude-longitude map at `path`, which may be in any folder. The map is turned
    /// by `degrees` about y, counterclockwise as seen from above.
    ///
    /// # Errors
    /// If the file is missing.
    pub fn with_environment(mut self, path: &Path, degrees: f32) -> Result<Self> {
        length(image::Source::file(path).path())?;
        let mut map = EnvironmentMap::from_path(path);
        map.rotation[1] = self.middle.turn() + degrees;
        self.file.background = Background::Image(map);
        Ok(self)
    }

    /// Checks every value and resolves every name.
    ///
    /// # Errors
    /// If a value is out of range, a name is unknown or used twice, a mesh or texture cannot be
    /// read, or a limit is exceeded.
    pub fn resolve(&self) -> Result<Scene> {
        let budget = self.budget.clone();
        let bad = |message| Error::input(&*self.name, "", message);
        budget.hold(self.files.memory()).map_err(bad)?;
        resolve(&self.name, &self.folder, &self.file, &self.files, budget)
            .map(|scene| scene.with_warnings(&self.warnings))
            .map_err(|error| self.with_line(error))
            .map_err(|error| match self.is_imported {
                true => error.with_advice_if_missing(WITHOUT_MISSING),
                false => error,
            })
    }

    /// Replaces the place of `error`, the path of an element, by line and column. The path moves to
    /// the message.
    fn with_line(&self, error: Error) -> Error {
        match (error, &self.text) {
            (Error::Unread { error, missing, advice }, _) => {
                Error::Unread { error: Box::new(self.with_line(*error)), missing, advice }
            }
            (Error::Input { file, place, message }, Some((form, text))) if file == self.name => {
                // For a section such as the camera, the place is empty and the message starts with
                // its name.
                let section = message.split(':').next().unwrap_or_default();
                let path = if place.is_empty() { section } else { &place };
                match locate(*form, text, path) {
                    Some(line) if place.is_empty() => Error::input(file, line, message),
                    Some(line) => Error::input(file, line, format!("{place}: {message}")),
                    None => Error::Input { file, place, message },
                }
            }
            (error, _) => error,
        }
    }

    /// The scene as RON.
    pub fn to_ron(&self) -> String {
        ron::to_ron(&self.file)
    }

    /// The scene as JSON, with the same schema.
    pub fn to_json(&self) -> String {
        ron::to_json(&self.file)
    }
}
