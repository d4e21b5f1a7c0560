//! Finding a scene by name or path and reading its text.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::budget::Budget;
use super::builtin::{self, BUILTIN_NAMES};
use super::description::SceneFile;
use super::generate::Generated;
use super::place::Places;
use super::{Scene, flat, parse, resolve};
use crate::error::{Error, Result, suggestion};
use crate::input::read_text;
use crate::limits::{Limit, Limits};

/// Bytes of memory for each primitive of a generated scene, as a file would say it.
const GENERATED: u64 = 160;

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// Compiled in.
    Builtin(&'static str),
    /// Made, by its name `cloud:N` or `mesh:N`.
    Generated(String, Generated),
    /// A file, by its form.
    File(PathBuf, Form),
}

/// The forms of scene files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `.ron`
    Ron,
    /// `.json`, the same schema.
    Json,
    /// `.txt`, the flat form.
    Flat,
}

/// What a source says, before its values are checked.
#[derive(Clone, Debug)]
pub struct Parsed {
    name: String,
    folder: PathBuf,
    /// The scene as written.
    pub file: SceneFile,
    places: Places,
    budget: Budget,
}

impl Source {
    /// The source that `name_or_path` means: a built-in name first, else a path.
    ///
    /// # Errors
    /// Where the path's extension tells no form, and it is no built-in name.
    pub fn find(name_or_path: &str) -> Result<Self> {
        if let Some(name) = BUILTIN_NAMES.into_iter().find(|name| *name == name_or_path) {
            return Ok(Self::Builtin(name));
        }
        if let Some(generated) = Generated::parse(name_or_path) {
            return Ok(Self::Generated(name_or_path.to_owned(), generated?));
        }
        let path = Path::new(name_or_path);
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let form = match extension.as_deref() {
            Some("ron") => Form::Ron,
            Some("json") => Form::Json,
            Some("txt") => Form::Flat,
            _ if path.is_dir() => {
                return Err(Error::io(path, "read")(ErrorKind::IsADirectory.into()));
            }
            _ => {
                let near = suggestion(name_or_path, BUILTIN_NAMES);
                return Err(Error::Usage(format!(
                    "`{name_or_path}` is neither a built-in scene, cloud:N, mesh:N, nor a .ron, .json or .txt file{near}"
                )));
            }
        };
        Ok(Self::File(path.to_owned(), form))
    }

    /// Reads the text and parses it.
    ///
    /// # Errors
    /// Where the file cannot be read, its text is no scene, or a limit is exceeded.
    pub fn read(&self, limits: &Limits) -> Result<Parsed> {
        let (name, folder, form, text) = match self {
            Self::Generated(name, generated) => {
                let count = generated.count().into();
                let budget = Budget::new(limits, 0);
                limits
                    .check(Limit::Primitives, count)
                    .and_then(|()| budget.hold(GENERATED * count))
                    .map_err(|message| Error::input(name, "", message))?;
                return Ok(Parsed {
                    name: name.clone(),
                    folder: PathBuf::new(),
                    file: generated.scene(),
                    places: Places::default(),
                    budget,
                });
            }
            Self::Builtin(name) => {
                let text = builtin::text(name).expect("the names are those of the texts");
                ((*name).to_owned(), PathBuf::new(), Form::Ron, text.to_owned())
            }
            Self::File(path, form) => {
                let folder = path.parent().unwrap_or(Path::new("")).to_owned();
                let check = |length| {
                    limits
                        .check(Limit::SceneBytes, length)
                        .and_then(|()| Budget::new(limits, length).check(0))
                };
                let text = read_text(path, "a scene file", check)?;
                (path.display().to_string(), folder, *form, text)
            }
        };
        let budget = Budget::new(limits, text.len() as u64);
        let (file, places) = match form {
            Form::Ron => (parse::from_ron(&name, &text, limits)?, Places::default()),
            Form::Json => (parse::from_json(&name, &text, limits)?, Places::default()),
            Form::Flat => flat::from_flat(&name, &text)?,
        };
        Ok(Parsed { name, folder, file, places, budget })
    }
}

impl Parsed {
    /// Checks every value and looks up every name.
    ///
    /// # Errors
    /// Where a value is out of range or a name unknown.
    pub fn resolve(&self) -> Result<Scene> {
        resolve::resolve(&self.name, &self.folder, &self.file, &self.places, self.budget.clone())
    }

    /// The scene as RON.
    pub fn to_ron(&self) -> String {
        parse::to_ron(&self.file)
    }

    /// The scene as JSON of the same schema.
    pub fn to_json(&self) -> String {
        parse::to_json(&self.file)
    }
}
