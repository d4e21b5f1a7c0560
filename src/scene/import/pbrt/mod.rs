//! Scenes of pbrt-v4 (<https://pbrt.org/fileformat-v4>).
//!
//! [`Reader`] follows the directives of a file; each module here handles some of them.

mod light;
mod material;
mod medium;
mod params;
mod shape;
mod spectrum;
mod texture;
mod tokens;
mod transform;
mod view;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::{DAffine3, DMat3, DVec3};

use self::light::AreaLight;
use self::material::Definition;
use self::medium::Medium;
use self::params::Params;
use self::texture::Textures;
use self::tokens::{Token, Tokens};
use self::view::View;
use super::Import;
use crate::error::{Error, Result};
use crate::input::{decompress, read_bytes};
use crate::limits::Limit;
use crate::scene::description::{CameraFile, SceneFile};
use crate::scene::medium::MediumFile;
use crate::scene::primitive::{InstanceFile, PrimitiveFile};

/// Largest number of attributes, transforms and objects that may be open.
const MAX_NESTING: usize = 1000;
/// Largest number of files that may include each other.
const MAX_INCLUDES: usize = 32;
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
}

/// The materials of a file.
#[derive(Default)]
struct Materials {
    named: HashMap<String, Rc<Definition>>,
    /// The names in the scene, by definition, medium inside and holes.
    known: HashMap<(*const Definition, Option<String>, Option<String>), String>,
    kept: Vec<Rc<Definition>>,
    names: HashSet<String>,
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
    in_world: bool,
    /// Whether transforms apply to the beginning of the shutter's interval.
    active: bool,
    view: View,
    /// The medium around the camera.
    view_medium: Option<String>,
    has_background: bool,
    textures: Textures,
    materials: Materials,
    /// The materials of lights, by the bits of their radiance, and whether they have two sides.
    lights: HashMap<([u32; 3], bool), String>,
    media: HashMap<String, Medium>,
    /// The object that is being defined, and its parts.
    object: Option<(String, Vec<PrimitiveFile>)>,
    /// The objects that can be instanced, and whether they have any part.
    objects: HashMap<String, bool>,
    /// The files that are being read.
    open: Vec<PathBuf>,
}

/// Reads the scene in `path`.
pub(super) fn read(path: &Path, import: &mut Import<'_>) -> Result<SceneFile> {
    let name = None;
    let definition =
        Definition { name, class: "diffuse".to_owned(), params: Params::default(), line: 0 };
    let state = State {
        transform: DAffine3::IDENTITY,
        reversed: false,
        material: Rc::new(definition),
        area_light: None,
        inside: None,
        outside: None,
    };
    let mut reader = Reader {
        import,
        scene: SceneFile::new(CameraFile::new([0.0; 3], [0.0, 0.0, 1.0], 90.0)),
        state,
        saved: Vec::new(),
        systems: HashMap::new(),
        in_world: false,
        active: true,
        view: View::default(),
        view_medium: None,
        has_background: false,
        textures: Textures::default(),
        materials: Materials::default(),
        lights: HashMap::new(),
        media: HashMap::new(),
        object: None,
        objects: HashMap::new(),
        open: Vec::new(),
    };
    reader.include(path)?;
    reader.finish();
    Ok(reader.scene)
}

impl Reader<'_, '_> {
    /// Follows the directives in `path`.
    fn include(&mut self, path: &Path) -> Result<()> {
        let name = path.display().to_string();
        let bad = |place: &str, message: String| Error::input(&*name, place, message);
        if self.open.len() == MAX_INCLUDES || self.open.iter().any(|open| open == path) {
            return Err(bad(
                "",
                "the file includes itself, or too many files include each other".to_owned(),
            ));
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
                Some(Token::Word("Include" | "Import")) => {
                    let file = quoted(&mut tokens).map_err(at)?;
                    if self.import.is_usable(&file, "so it is left out") {
                        self.include(&self.import.path_within(&file)?)?;
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
        let allow = |length| {
            budget.limits.check(Limit::SceneBytes, length).and_then(|()| budget.check(length))
        };
        let mut bytes = read_bytes(path, allow)?;
        if path.extension().is_some_and(|extension| extension == "gz") {
            bytes = decompress(&bytes, allow).map_err(bad)?;
        }
        String::from_utf8(bytes)
            .map_err(|_| bad("not UTF-8 text, which a scene file must be".to_owned()))
    }

    /// Follows one directive.
    fn follow(
        &mut self,
        directive: &str,
        line: usize,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), String> {
        match directive {
            "Identity" => self.set_transform(DAffine3::IDENTITY),
            "Translate" => self.apply(DAffine3::from_translation(DVec3::from(numbers(tokens)?))),
            "Scale" => {
                let scale = DVec3::from(numbers::<3>(tokens)?);
                self.apply(DAffine3::from_mat3(DMat3::from_diagonal(scale)))
            }
            "Rotate" => {
                let [angle, x, y, z] = numbers(tokens)?;
                self.apply(transform::rotation(angle, DVec3::new(x, y, z)))
            }
            "LookAt" => {
                let n: [f64; 9] = numbers(tokens)?;
                let point = |i: usize| DVec3::new(n[i], n[i + 1], n[i + 2]);
                self.apply(transform::look_at(point(0), point(3), point(6)))
            }
            "Transform" => {
                let map = transform::of_numbers(&numbers(tokens)?)?;
                self.set_transform(map)
            }
            "ConcatTransform" => self.apply(transform::of_numbers(&numbers(tokens)?)?),
            "CoordinateSystem" => {
                self.systems.insert(quoted(tokens)?, self.state.transform);
                Ok(())
            }
            "CoordSysTransform" => {
                let name = quoted(tokens)?;
                let map = self.systems.get(&name).copied();
                self.set_transform(
                    map.ok_or_else(|| format!("unknown coordinate system \"{name}\""))?,
                )
            }
            "ActiveTransform" => {
                let Some(Token::Word(which)) = tokens.next()? else {
                    return Err("expected `StartTime`, `EndTime` or `All`".to_owned());
                };
                self.active = which != "EndTime";
                self.import.warn("moving transforms are not supported, so everything stands still");
                Ok(())
            }
            "TransformTimes" => numbers::<2>(tokens).map(|_| ()),
            "ReverseOrientation" => {
                self.state.reversed = !self.state.reversed;
                Ok(())
            }
            "AttributeBegin" => self.save("AttributeEnd"),
            "TransformBegin" => self.save("TransformEnd"),
            "AttributeEnd" => self.restore("AttributeEnd"),
            "TransformEnd" => self.restore("TransformEnd"),
            "ObjectBegin" => {
                if self.object.is_some() {
                    return Err("objects cannot be defined within objects".to_owned());
                }
                let name = quoted(tokens)?;
                self.save("ObjectEnd")?;
                self.object = Some((name, Vec::new()));
                Ok(())
            }
            "ObjectEnd" => {
                self.restore("ObjectEnd")?;
                let (name, parts) = self.object.take().ok_or("there is no `ObjectBegin`")?;
                let fresh = self.objects.insert(name.clone(), !parts.is_empty()).is_none();
                if !fresh {
                    return Err(format!("the object \"{name}\" is defined twice"));
                }
                self.scene.add_named_mesh(name, parts);
                Ok(())
            }
            "ObjectInstance" => {
                let name = quoted(tokens)?;
                match self.objects.get(&name) {
                    None => return Err(format!("unknown object \"{name}\"")),
                    Some(false) => {}
                    Some(true) => {
                        let matrix = transform::rows(&self.state.transform);
                        self.scene.add(InstanceFile::new(name, matrix));
                    }
                }
                Ok(())
            }
            "WorldBegin" => {
                self.in_world = true;
                self.state.transform = DAffine3::IDENTITY;
                self.systems.insert("world".to_owned(), DAffine3::IDENTITY);
                Ok(())
            }
            "MediumInterface" => {
                let inside = quoted(tokens)?;
                let outside = match tokens.peek()? {
                    Some(Token::Text(_)) => quoted(tokens)?,
                    _ => inside.clone(),
                };
                let named = |name: String| (!name.is_empty()).then_some(name);
                (self.state.inside, self.state.outside) = (named(inside), named(outside));
                Ok(())
            }
            "NamedMaterial" => {
                let name = quoted(tokens)?;
                let definition = self.materials.named.get(&name);
                let unknown = || format!("unknown material \"{name}\"");
                self.state.material = Rc::clone(definition.ok_or_else(unknown)?);
                Ok(())
            }
            "ColorSpace" => {
                let name = quoted(tokens)?;
                if name != "srgb" {
                    self.import.warn(format!(
                        "the colour space {name} is not supported, so colours are sRGB"
                    ));
                }
                Ok(())
            }
            "Texture" => {
                let (name, kind, class) = (quoted(tokens)?, quoted(tokens)?, quoted(tokens)?);
                let params = Params::read(tokens)?;
                self.texture(&name, &kind, &class, &params)
            }
            "Option" => Params::read(tokens).map(|_| ()),
            _ => self.follow_with_class(directive, line, tokens),
        }
    }

    /// Follows a directive with a class or name and parameters.
    fn follow_with_class(
        &mut self,
        directive: &str,
        line: usize,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), String> {
        const KNOWN: [&str; 14] = [
            "Shape",
            "Material",
            "MakeNamedMaterial",
            "LightSource",
            "AreaLightSource",
            "MakeNamedMedium",
            "Camera",
            "Film",
            "PixelFilter",
            "Sampler",
            "Integrator",
            "Accelerator",
            "Attribute",
            "Filter",
        ];
        if !KNOWN.contains(&directive) {
            let near = crate::error::suggestion(directive, KNOWN);
            return Err(format!("unknown directive `{directive}`{near}"));
        }
        let class = quoted(tokens)?;
        let params = Params::read(tokens)?;
        match directive {
            "Shape" => self.shape(&class, &params),
            "Material" => {
                let definition = Definition { name: None, class, params, line };
                self.state.material = Rc::new(definition);
                Ok(())
            }
            "MakeNamedMaterial" => {
                let kind = params.text("type")?.unwrap_or("diffuse").to_owned();
                let definition =
                    Definition { name: Some(class.clone()), class: kind, params, line };
                match self.materials.named.insert(class.clone(), Rc::new(definition)) {
                    None => Ok(()),
                    Some(_) => Err(format!("the material \"{class}\" is defined twice")),
                }
            }
            "LightSource" => self.light_source(&class, &params),
            "AreaLightSource" => self.area_light_source(&class, &params),
            "MakeNamedMedium" => self.make_medium(&class, &params),
            "Camera" => self.camera(&class, &params),
            "Film" => self.film(&params),
            "PixelFilter" | "Filter" => self.pixel_filter(&class, &params),
            "Sampler" | "Integrator" => self.sampling(&params),
            "Attribute" => {
                self.import.warn("the directive Attribute is not supported, so it has no effect");
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn set_transform(&mut self, map: DAffine3) -> Result<(), String> {
        if self.active {
            self.state.transform = transform::checked(map)?;
        }
        Ok(())
    }

    fn apply(&mut self, map: DAffine3) -> Result<(), String> {
        self.set_transform(self.state.transform * map)
    }

    fn save(&mut self, end: &'static str) -> Result<(), String> {
        if self.saved.len() == MAX_NESTING {
            return Err(format!("attributes may be nested at most {MAX_NESTING} times"));
        }
        self.saved.push((end, self.state.clone()));
        Ok(())
    }

    fn restore(&mut self, end: &str) -> Result<(), String> {
        match self.saved.pop() {
            Some((expected, state)) if expected == end => {
                if end == "TransformEnd" {
                    self.state.transform = state.transform;
                } else {
                    self.state = state;
                }
                Ok(())
            }
            Some((expected, _)) => Err(format!("`{end}` where `{expected}` is expected")),
            None => Err(format!("`{end}` without its beginning")),
        }
    }

    /// Warns of parameters that were not used. `of` is what they belong to.
    fn warn_unused(&mut self, params: &Params, of: &str) {
        for name in params.unused() {
            self.import.warn(format!("`{name}` of {of} is not supported, so it has no effect"));
        }
    }

    /// Adds what is known only at the end.
    fn finish(&mut self) {
        self.finish_view();
        let around = self.view_medium.take().and_then(|name| self.media.get(&name));
        if let Some((density, albedo)) = around.map(Medium::mean) {
            if self.scene.media.is_empty() {
                let (min, max) = ([-EVERYWHERE; 3], [EVERYWHERE; 3]);
                let rotation = [0.0; 3];
                self.scene.media.push(MediumFile::Box { min, max, rotation, density, albedo });
            } else {
                self.import.warn("media within the medium of the camera are not supported, so that one is left out");
            }
        }
    }
}

/// The text in quotes that follows.
fn quoted(tokens: &mut Tokens<'_>) -> Result<String, String> {
    match tokens.next()? {
        Some(Token::Text(text)) => Ok(text.into_owned()),
        _ => Err("expected a text in quotes".to_owned()),
    }
}

/// N numbers, with or without brackets.
fn numbers<const N: usize>(tokens: &mut Tokens<'_>) -> Result<[f64; N], String> {
    let brackets = tokens.peek()? == Some(&Token::Open);
    if brackets {
        tokens.next()?;
    }
    let mut all = [0.0; N];
    for number in &mut all {
        match tokens.next()? {
            Some(Token::Number(value)) => *number = value,
            _ => return Err(format!("expected {N} numbers")),
        }
    }
    match brackets.then(|| tokens.next()).transpose()? {
        None | Some(Some(Token::Close)) => Ok(all),
        Some(_) => Err(format!("expected a bracket after {N} numbers")),
    }
}
