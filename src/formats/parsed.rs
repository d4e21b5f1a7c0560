//! A scene whose description is read, but not checked yet.

use std::path::{Path, PathBuf};

use super::assets::Files;
use super::import::{Middle, WITHOUT_MISSING};
use super::ron::{self, Form, locate};
use crate::error::{Error, Result};
use crate::image::Source;
use crate::input::length;
use crate::limits::Budget;
use crate::scene::{Scene, SceneFile, resolve};
use crate::shading::Background;
use crate::shading::light::EnvironmentMap;

/// A parsed scene whose values are not checked yet.
#[derive(Clone, Debug)]
pub struct Parsed {
    pub(crate) name: String,
    pub(crate) folder: PathBuf,
    /// The scene as written.
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
}

impl Parsed {
    pub(crate) fn new(name: String, folder: PathBuf, file: SceneFile, budget: Budget) -> Self {
        let (text, warnings, middle) = Default::default();
        let (is_imported, maybe_blender) = (false, false);
        Self { name, folder, file, budget, text, warnings, middle, is_imported, maybe_blender }
    }

    /// Replaces the background by the latitude-longitude map at `path`, which may be in any folder. The map is turned
    /// by `degrees` about y, counterclockwise as seen from above.
    ///
    /// # Errors
    /// If the file is missing.
    pub fn with_environment(mut self, path: &Path, degrees: f32) -> Result<Self> {
        length(Source::file(path).path())?;
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
        resolve(&self.name, &self.folder, &self.file, &Files, budget)
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
