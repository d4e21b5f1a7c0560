//! Turns a scene file into a scene that can be rendered: checks every number and looks up every
//! name.

mod materials;
mod primitives;

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Assets, IndexedMesh, Scene, SceneData, SceneFile};
use crate::checks::{Location, MAX_ORIGIN};
use crate::error::{Error, Result};
use crate::limits::{self, Budget, Limit, MAX_MEDIA};
use crate::shading::light::LightFile;
use crate::shading::{Camera, Images, Medium, World, mark_holes};

/// Returns the scene that `file` describes. Error messages call the file `name`. Paths of textures
/// and meshes are relative to `folder`.
pub(crate) fn resolve(
    name: &str,
    folder: &Path,
    file: &SceneFile,
    assets: &dyn Assets,
    budget: Budget,
) -> Result<Scene> {
    let resolver = Resolver { name, file, budget };
    let e = resolver.section("camera");
    let camera = Camera::new(&e, &file.camera)?;
    resolver.check_names("camera", file.cameras.names())?;
    for (name, camera) in &file.cameras.0 {
        Camera::new(&resolver.element(format!("cameras.{name}"), "camera"), camera)?;
    }
    resolver.render_defaults()?;
    let [x, y, z] = file.origin;
    let ok = file.origin.iter().all(|c| c.abs() <= MAX_ORIGIN);
    e.check(ok, "origin", "three numbers in [-1e12, 1e12]", format!("({x}, {y}, {z})"))?;
    let entries = file.textures.0.len() + file.materials.0.len();
    resolver.check_names("texture", file.textures.names())?;
    resolver.check_names("material", file.materials.names())?;
    resolver.check_names("mesh", file.meshes.names())?;
    let room = resolver.budget.hold(ENTRY * entries as u64);
    room.map_err(|message| Error::input(name, "", message))?;
    let mut images = Images::new(folder, &resolver.budget, assets);
    let materials = resolver.materials(&mut images)?;
    let mut background = file.background.clone();
    background.load(&resolver.section("background"), &mut images)?;
    let (mended, images) = (images.mended(), images.files());
    let (geometry, material_map, meshes) = resolver.primitives(&materials, folder, assets)?;
    let mut geometry = geometry;
    mark_holes(&mut geometry, &materials, &material_map);
    let media = resolver.media()?;
    let (geometry, lights) = (Arc::new(geometry), resolver.lights()?);
    let world = World { background, geometry, materials, material_map, lights, media };
    let lights = world.light_count();
    let room = resolver.budget.hold(LIGHT_BYTES * u64::from(lights));
    room.map_err(|message| Error::input(name, "", message))?;
    Ok(Scene(Arc::new(SceneData {
        name: name.to_owned(),
        camera,
        camera_file: file.camera.clone(),
        cameras: file.cameras.clone(),
        origin: file.origin.into(),
        defaults: file.render.clone(),
        world,
        material_names: file.materials.names().map(str::to_owned).collect(),
        lights,
        ignored: ignored(&meshes).into_iter().chain(mended).collect(),
        files: images.chain(meshes.into_keys()).collect(),
        limits: resolver.budget.limits,
    })))
}

/// Estimated bytes of memory for each texture or material besides its text; 60 were measured.
const ENTRY: u64 = 100;
/// Estimated bytes of memory for each light: 160 were measured, and a tree of lights and the lists from
/// which it is built have up to 360.
pub(crate) const LIGHT_BYTES: u64 = 600;

/// Sentences that name the ignored data of mesh files, one for all files with the same kinds.
fn ignored(meshes: &BTreeMap<PathBuf, IndexedMesh>) -> Vec<String> {
    let mut files: BTreeMap<String, Vec<&Path>> = BTreeMap::new();
    for (file, mesh) in meshes {
        if let Some(names) = mesh.ignored() {
            files.entry(names).or_default().push(file);
        }
    }
    let sentence = |(names, files): (String, Vec<&Path>)| match files[..] {
        [file] => format!("{}: ignoring {names}", file.display()),
        _ => format!("{} and {} more: ignoring {names}", files[0].display(), files.len() - 1),
    };
    files.into_iter().map(sentence).collect()
}

struct Resolver<'a> {
    name: &'a str,
    file: &'a SceneFile,
    budget: Budget,
}

impl<'a> Resolver<'a> {
    fn element(&self, place: String, kind: &'a str) -> Location<'a> {
        Location { file: self.name, place, kind }
    }

    /// A section of the file. Its messages begin with its name, which is therefore not its place.
    fn section(&self, name: &'a str) -> Location<'a> {
        self.element(String::new(), name)
    }

    /// Rejects duplicate names. The readers of files reject them as well, but a scene may also be
    /// built in code.
    fn check_names(&self, kind: &'a str, names: impl Iterator<Item = &'a str>) -> Result<()> {
        let mut seen = HashSet::new();
        for name in names {
            if !seen.insert(name) {
                let section = if kind == "mesh" { "meshes".to_owned() } else { format!("{kind}s") };
                let e = self.element(section, kind);
                return Err(e.error(format!("the name `{name}` is used twice")));
            }
        }
        Ok(())
    }

    fn render_defaults(&self) -> Result<()> {
        let render = &self.file.render;
        let pixels = u64::from(render.width) * u64::from(render.height);
        limits::check_image(render.width, render.height)
            .and_then(|()| limits::check("spp", render.spp, limits::MAX_SPP))
            .and_then(|()| limits::check("depth", render.depth, limits::MAX_DEPTH))
            .and_then(|()| render.roulette.check())
            .and_then(|()| self.budget.limits.check(Limit::Pixels, pixels))
            .map_err(|message| self.section("render").error(message))
    }

    /// Returns the lights that are not primitives after checking them.
    fn lights(&self) -> Result<Vec<LightFile>> {
        for (index, light) in self.file.lights.iter().enumerate() {
            light.check(&self.element(format!("lights[{index}]"), light.name()))?;
        }
        Ok(self.file.lights.clone())
    }

    /// Returns the media after checking that they do not overlap.
    fn media(&self) -> Result<Vec<Medium>> {
        let mut media: Vec<Medium> = Vec::new();
        for (index, file) in self.file.media.iter().enumerate() {
            let e = self.element(format!("media[{index}]"), "medium");
            if index >= MAX_MEDIA {
                return Err(e.error(format!("a scene can have at most {MAX_MEDIA} media")));
            }
            let medium = Medium::new(&e, file)?;
            if let Some(other) =
                media.iter().position(|other| other.volume.overlaps(&medium.volume))
            {
                return Err(e.error(format!("overlaps media[{other}], media must not overlap")));
            }
            media.push(medium);
        }
        Ok(media)
    }
}
