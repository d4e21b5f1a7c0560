//! Scenes of pbrt-v4 (<https://pbrt.org/fileformat-v4>).
//!
//! [`Reader`] follows the directives of a file; each module here handles some of them.

mod definition;
mod directives;
mod light;
mod list;
mod material;
mod medium;
mod options;
mod parallelogram;
mod params;
mod shape;
mod spectrum;
mod texture;
mod tokens;
mod transform;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::DAffine3;

use self::definition::{Definition, Materials};
use self::directives::quoted;
use self::light::{AreaLight, LightKey};
use self::medium::Medium;
use self::options::RenderOptions;
use self::params::{Param, Params, Values};
use self::texture::{Textures, Value, ValueKey};
use self::tokens::{Token, Tokens};
use self::transform::{rounded, twice_angle_of, uniform_scale};
use super::import::{Format, Import, Middle};
use crate::error::{Error, Result};
use crate::input::{decompress, read_bytes};
use crate::limits::Limit;
use crate::scene::{PrimitiveFile, SceneFile};
use crate::shading::{CameraFile, MediumFile};

/// pbrt-v4.
pub(crate) static FORMAT: Format = Format { extensions: &["pbrt"], read, middle: Middle::MinusZ };

/// Largest number of files that may include each other.
const MAX_NESTED_FILES: usize = 32;
/// Largest number of files in all.
const MAX_FILES: usize = 10_000;
/// Half the side of the box that a medium around the camera fills.
const EVERYWHERE: f32 = 1e5;

/// The state that attributes save and restore.
#[derive(Clone)]
struct State {
    /// From the current coordinates to the scene. Before the world begins: from the scene to the
    /// camera.
    transform: DAffine3,
    /// Whether fronts and backs are exchanged.
    reversed: bool,
    material: Rc<Definition>,
    area_light: Option<Rc<AreaLight>>,
    /// Names of the media inside and outside surfaces.
    inside: Option<String>,
    outside: Option<String>,
    /// Whether transforms apply to the beginning of the shutter's interval.
    active: bool,
}

/// Follows the directives of a file, and builds the scene.
struct Reader<'i, 'a> {
    import: &'i mut Import<'a>,
    scene: SceneFile,
    state: State,
    /// The states that attributes have saved, each with the directive that restores it.
    saved: Vec<(&'static str, State)>,
    /// Coordinate systems by name: from each to the scene.
    systems: HashMap<String, DAffine3>,
    view: RenderOptions,
    /// The medium around the camera.
    view_medium: Option<String>,
    has_background: bool,
    textures: Textures,
    materials: Materials,
    /// The materials of lights, by the bits of their radiance, and whether they have two sides.
    lights: HashMap<LightKey, String>,
    media: HashMap<String, Medium>,
    /// The number of the shape that is being read.
    shape: usize,
    /// The object that is being defined, and its parts.
    object: Option<(String, Vec<PrimitiveFile>)>,
    /// The objects that can be instanced, and whether they have any part.
    objects: HashMap<String, bool>,
    /// The files that are being read.
    open: Vec<PathBuf>,
    /// Number of files that were included so far.
    included: usize,
}

/// Reads the scene in `path`.
pub(crate) fn read(path: &Path, import: &mut Import<'_>) -> Result<SceneFile> {
    let mut materials = Materials::default();
    let material = materials.define(None, "diffuse".to_owned(), Params::default(), 0);
    let state = State {
        transform: DAffine3::IDENTITY,
        reversed: false,
        material,
        area_light: None,
        inside: None,
        outside: None,
        active: true,
    };
    let mut reader = Reader {
        import,
        scene: SceneFile::new(CameraFile::new([0.0; 3], [0.0, 0.0, 1.0], 90.0)),
        state,
        saved: Vec::new(),
        systems: HashMap::new(),
        view: RenderOptions::default(),
        view_medium: None,
        has_background: false,
        textures: Textures::default(),
        materials,
        lights: HashMap::new(),
        media: HashMap::new(),
        shape: 0,
        object: None,
        objects: HashMap::new(),
        open: Vec::new(),
        included: 0,
    };
    reader.include(path)?;
    reader.finish().map_err(|message| Error::input(path.display().to_string(), "", message))?;
    Ok(reader.scene)
}

impl Reader<'_, '_> {
    /// Follows the directives in `path`.
    fn include(&mut self, path: &Path) -> Result<()> {
        let name = path.display().to_string();
        let bad = |place: &str, message: String| Error::input(&*name, place, message);
        if self.open.len() == MAX_NESTED_FILES || self.open.iter().any(|open| open == path) {
            return Err(bad(
                "",
                "the file includes itself, or too many files include each other".to_owned(),
            ));
        }
        self.included += 1;
        if self.included > MAX_FILES {
            return Err(bad("", format!("more than {MAX_FILES} files are included")));
        }
        let text = self.text(path)?;
        self.import.budget.hold_text(text.len() as u64).map_err(|message| bad("", message))?;
        self.open.push(path.to_owned());
        let mut tokens = Tokens::new(&text);
        loop {
            let token =
                tokens.next().map_err(|message| bad(&tokens.line().to_string(), message))?;
            let line = tokens.line();
            let at = |message: String| bad(&line.to_string(), message);
            match token {
                None => break,
                Some(Token::Word(directive @ ("Include" | "Import"))) => {
                    let file = quoted(&mut tokens).map_err(at)?;
                    if !self.import.is_usable(&file, "so it is left out") {
                        continue;
                    }
                    // An imported file leaves the state as it was.
                    let before = (directive == "Import").then(|| self.state.clone());
                    let path = self.import.path_within(&file)?;
                    self.import.require(&path)?;
                    self.include(&path)?;
                    if let Some(before) = before {
                        self.state = before;
                    }
                }
                Some(Token::Word(directive)) => {
                    self.follow(directive, line, &mut tokens).map_err(at)?;
                }
                Some(_) => return Err(at("expected a directive, such as `Shape`".to_owned())),
            }
        }
        self.open.pop();
        match self.saved.last() {
            Some((end, _)) if self.open.is_empty() => Err(bad("", format!("`{end}` is missing"))),
            _ => Ok(()),
        }
    }

    /// The text of a file, which may be compressed.
    fn text(&self, path: &Path) -> Result<String> {
        let name = path.display().to_string();
        let bad = |message: String| Error::input(&*name, "", message);
        let budget = self.import.budget;
        let allow = |length| budget.check_file(Limit::SceneBytes, length);
        let mut bytes = read_bytes(path, allow)?;
        if path.extension().is_some_and(|extension| extension == "gz") {
            bytes = decompress(&bytes, allow).map_err(bad)?;
        }
        // Comments and names may be in other encodings.
        let lossy = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Ok(String::from_utf8(bytes).unwrap_or_else(|error| lossy(error.as_bytes())))
    }

    /// Warns of parameters that were not used. `of` is what they belong to.
    fn warn_unused(&mut self, params: &Params, of: &str) {
        for name in params.unused() {
            self.import.warn(format!("`{name}` of {of} is not supported, so it has no effect"));
        }
    }

    /// Sets the camera and the medium around it, which need the whole file.
    fn finish(&mut self) -> Result<(), String> {
        self.finish_view();
        let around = self.view_medium.take().map(|name| self.medium(&name)).transpose()?;
        if let Some((density, albedo)) = around.as_ref().map(Medium::mean) {
            if self.scene.media.is_empty() {
                let (min, max) = ([-EVERYWHERE; 3], [EVERYWHERE; 3]);
                let rotation = [0.0; 3];
                self.scene.media.push(MediumFile::Box { min, max, rotation, density, albedo });
            } else {
                self.import.warn("media within the medium of the camera are not supported, so that one is left out");
            }
        }
        Ok(())
    }
}
