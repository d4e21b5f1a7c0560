//! Finds a scene by name or path and reads it.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::generated::Generated;
use super::import::{Format, Imported, Middle};
use super::ron::Form;
use super::{
    BUILTIN_NAMES, ImportOptions, MESHES, SceneDescription, builtin, extension, import, imported,
    mesh_scene, obj, ron,
};
use crate::error::{Error, Result, suggestion};
use crate::input::read_text;
use crate::limits::{Budget, Limit, Limits};

/// Bytes of memory that a generated [`SceneFile`](crate::SceneFile) needs for each primitive.
const GENERATED: u64 = 300;

/// The source of a scene.
#[derive(Clone, Debug)]
pub enum Source {
    /// A scene compiled into the program, by name.
    Builtin(&'static str),
    /// A generated scene, with its name such as `cloud:N`.
    Generated(String, Generated),
    /// A file and its form.
    File(PathBuf, Form),
    /// The text of a scene file and its form.
    Text(String, Form),
    /// A mesh, shown in a scene of its own.
    Mesh(PathBuf),
    /// A scene of another program.
    Import(PathBuf, &'static Format),
}

impl Source {
    /// Finds the source for a built-in name, the name of a generated scene, or a path, in this
    /// order.
    ///
    /// # Errors
    /// If the name is unknown and the path is a directory or lacks the extension of a scene file,
    /// or if the size of a generated scene is out of range.
    pub fn find(name_or_path: &str) -> Result<Self> {
        if let Some(name) = BUILTIN_NAMES.into_iter().find(|name| *name == name_or_path) {
            return Ok(Self::Builtin(name));
        }
        if let Some(generated) = Generated::parse(name_or_path) {
            return Ok(Self::Generated(name_or_path.to_owned(), generated?));
        }
        let path = Path::new(name_or_path);
        let extension = extension(path);
        let form = match extension.as_deref() {
            Some("ron") => Form::Ron,
            Some("json") => Form::Json,
            Some("txt") => {
                return Err(Error::Usage(format!(
                    "{name_or_path}: scenes are .ron or .json files (the flat form in .txt files is not read any more)"
                )));
            }
            Some(extension) if MESHES.iter().any(|format| format.extension == extension) => {
                return Ok(Self::Mesh(path.to_owned()));
            }
            Some(_) if let Some(format) = imported(path) => {
                return Ok(Self::Import(path.to_owned(), format));
            }
            _ if path.is_dir() => {
                return Err(Error::io(path, "read")(ErrorKind::IsADirectory.into()));
            }
            _ => {
                let near = suggestion(name_or_path, BUILTIN_NAMES);
                return Err(Error::Usage(format!(
                    "unknown scene `{name_or_path}`: expected a built-in scene, cloud:N, mesh:N, forest:N, a .ron, .json, .gltf, .glb or .pbrt file, or an .obj or .ply mesh{near}"
                )));
            }
        };
        Ok(Self::File(path.to_owned(), form))
    }

    /// Reads a scene file in RON or JSON from `reader`, to its end.
    ///
    /// # Errors
    /// If the text cannot be read, is not UTF-8, or exceeds the limit on bytes.
    pub fn from_reader(reader: impl Read, limits: &Limits) -> Result<Self> {
        let bad = |message: String| Error::input(STANDARD_INPUT, "", message);
        let limit = limits.get(Limit::SceneBytes);
        let mut text = Vec::new();
        let read = reader.take(limit.saturating_add(1)).read_to_end(&mut text);
        read.map_err(Error::io(Path::new(STANDARD_INPUT), "read"))?;
        limits.check(Limit::SceneBytes, text.len() as u64).map_err(bad)?;
        let text = String::from_utf8(text).map_err(|_| bad("not UTF-8 text".to_owned()))?;
        let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
        let form = if text.trim_start().starts_with('{') { Form::Json } else { Form::Ron };
        Ok(Self::Text(text, form))
    }

    /// Reads and parses the text, or generates the scene.
    ///
    /// # Errors
    /// If the file cannot be read, its text is not a valid scene file, or a limit is exceeded.
    pub fn read(&self, limits: &Limits) -> Result<SceneDescription> {
        self.read_with(limits, &ImportOptions::default())
    }

    /// Like [`read`](Self::read), with options for scenes of other programs.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub(crate) fn read_with(
        &self,
        limits: &Limits,
        options: &ImportOptions,
    ) -> Result<SceneDescription> {
        let turns = match self {
            Self::Mesh(_) => true,
            Self::Import(_, format) => format.middle == Middle::X,
            _ => false,
        };
        if options.z_up && !turns {
            return Err(Error::Usage("--z-up is for glTF, OBJ and PLY files".to_owned()));
        }
        let (name, folder, form, text) = match self {
            Self::Generated(name, generated) => {
                let count = generated.count().into();
                let budget = Budget::new(limits, 0);
                limits
                    .check(Limit::Primitives, count)
                    .and_then(|()| budget.hold(GENERATED * count))
                    .map_err(|message| Error::input(name, "", message))?;
                return Ok(SceneDescription::new(
                    name.clone(),
                    PathBuf::new(),
                    generated.scene(),
                    budget,
                ));
            }
            Self::Mesh(path) => {
                let (budget, folder) = (Budget::new(limits, 0), folder_of(path));
                let (mut file, names, files) = mesh_scene::of_mesh(path, options, &budget)?;
                let name = path.display().to_string();
                let mut warnings =
                    obj::add_materials_of_meshes(&name, &folder, options, &budget, &mut file)?;
                if let Some(unknown) = mesh_scene::add_missing_materials(&mut file, names) {
                    let warning = format!("{name}: {unknown}");
                    if options.strict {
                        return Err(import::rejected(&warning));
                    }
                    warnings.push(warning);
                }
                let (middle, is_imported) = (Middle::X, true);
                let description = SceneDescription::new(name, folder, file, budget);
                return Ok(SceneDescription {
                    warnings,
                    middle,
                    is_imported,
                    files,
                    ..description
                });
            }
            Self::Import(path, format) => {
                let budget = Budget::new(limits, 0);
                let Imported { file, warnings, maybe_blender } =
                    import::read(path, format, options, &budget)?;
                let name = path.display().to_string();
                let (middle, folder) = (format.middle, folder_of(path));
                let description = SceneDescription::new(name, folder, file, budget);
                let is_imported = true;
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let lists = options.keeps_pose().then_some(name);
                return Ok(SceneDescription {
                    warnings,
                    middle,
                    is_imported,
                    maybe_blender,
                    lists,
                    ..description
                });
            }
            Self::Text(text, form) => {
                (STANDARD_INPUT.to_owned(), PathBuf::new(), *form, text.clone())
            }
            Self::Builtin(name) => {
                let text = builtin::text(name).expect("every built-in name has a text");
                ((*name).to_owned(), builtin::FOLDER.into(), Form::Ron, text.to_owned())
            }
            Self::File(path, form) => {
                let check = |length| {
                    limits
                        .check(Limit::SceneBytes, length)
                        .and_then(|()| Budget::new(limits, length).check(0))
                };
                let text = read_text(path, "a scene file", check)?;
                (path.display().to_string(), folder_of(path), *form, text)
            }
        };
        let budget = Budget::new(limits, text.len() as u64);
        let mut file = match form {
            Form::Ron => ron::from_ron(&name, &text)?,
            Form::Json => ron::from_json(&name, &text)?,
        };
        let text = Some((form, text));
        let warnings = obj::add_materials_of_meshes(&name, &folder, options, &budget, &mut file)?;
        Ok(SceneDescription { text, warnings, ..SceneDescription::new(name, folder, file, budget) })
    }
}

/// The name of a scene on standard input, in messages.
const STANDARD_INPUT: &str = "standard input";

fn folder_of(file: &Path) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).to_owned()
}
