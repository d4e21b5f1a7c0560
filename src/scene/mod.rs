//! Scenes: from a name or file to checked, index-based data.

mod background;
mod bsdf;
mod budget;
mod builtin;
mod camera;
mod description;
mod emission;
mod files;
mod flat;
mod generate;
mod hash;
mod interaction;
mod light;
mod load;
mod looks;
pub mod material;
mod medium;
mod mesh;
mod named;
mod nesting;
mod parse;
mod place;
pub mod primitive;
mod resolve;
mod tables;
pub mod texture;

pub use background::Background;
pub use builtin::BUILTIN_NAMES;
pub use camera::Camera;
pub(crate) use camera::CameraFrame;
pub use description::{CameraFile, RenderDefaults, Sampling, SceneFile};
#[cfg(test)]
pub(crate) use interaction::Interaction;
pub(crate) use light::LightSample;
pub use load::Source;
pub(crate) use looks::{Key, Looks};
pub(crate) use material::Material;
#[cfg(test)]
pub(crate) use material::MaterialTables;
#[cfg(test)]
pub(crate) use medium::Isotropic;
pub(crate) use medium::Medium;
pub use medium::MediumFile;
pub use named::Named;
pub use primitive::PrimitiveFile;
pub(crate) use resolve::LIGHT_BYTES;
pub(crate) use tables::SceneTables;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use looks::MaterialMap;

use crate::error::Result;
use crate::geometry::Geometry;
use crate::limits::Limits;

/// A scene that can be rendered: names are resolved to indices, and every number is in its range.
///
/// Scenes do not change, and clones share their data.
#[derive(Clone, Debug)]
pub struct Scene(Arc<SceneData>);

impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        // Soon known of clones, however large they are.
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

#[derive(Debug, PartialEq)]
struct SceneData {
    name: String,
    camera: Camera,
    background: Background,
    defaults: RenderDefaults,
    materials: Vec<Material>,
    geometry: Arc<Geometry>,
    material_map: MaterialMap,
    lights: u32,
    media: Vec<Medium>,
    files: BTreeSet<PathBuf>,
    limits: Limits,
}

impl Scene {
    /// The built-in scene of that name, or the scene in the file at that path (`.ron`,
    /// `.json`, or `.txt` in the flat form).
    ///
    /// # Errors
    /// Where there is no such file or its content is wrong: one line that names the place.
    pub fn load(name_or_path: &str) -> Result<Self> {
        Self::load_within(name_or_path, &Limits::default())
    }

    /// As [`load`](Self::load), within other limits than the usual ones. They hold for renders of the scene,
    /// too.
    ///
    /// # Errors
    /// As [`load`](Self::load), and where a limit is exceeded. The message names the limit, and ends with the advice of
    /// [`Limits::with_advice`], if there is any.
    pub fn load_within(name_or_path: &str, limits: &Limits) -> Result<Self> {
        Source::find(name_or_path)?.read(limits)?.resolve()
    }

    /// The scene in `text`, in RON; textures are relative to the current folder.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_ron(text: &str) -> Result<Self> {
        parse::from_ron("scene", text, &Limits::default()).and_then(|file| Self::from_file(&file))
    }

    /// The scene that `file` describes; meshes and textures are in the current folder.
    ///
    /// # Errors
    /// Where a number is out of range, or a name is unknown or used twice.
    pub fn from_file(file: &SceneFile) -> Result<Self> {
        Self::from_file_within(file, Path::new(""), &Limits::default())
    }

    /// As [`from_file`](Self::from_file), with meshes and textures in `folder`, and within other limits than
    /// the usual ones.
    ///
    /// # Errors
    /// As [`from_file`](Self::from_file), and where a limit is exceeded.
    pub fn from_file_within(file: &SceneFile, folder: &Path, limits: &Limits) -> Result<Self> {
        let budget = budget::Budget::new(limits, 0);
        resolve::resolve("scene", folder, file, &place::Places::default(), budget)
    }

    /// The built-in name, or the path as given.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// The meshes and textures that were read for it.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.0.files.iter().map(PathBuf::as_path)
    }

    /// BLAKE3 over all that decides the scene's images, in hexadecimal: the same for every
    /// form and every naming that says the same.
    pub fn hash(&self) -> String {
        self.hash_with(self.camera())
    }

    /// [`Scene::hash`] with another camera.
    pub(crate) fn hash_with(&self, camera: &Camera) -> String {
        hash::hash(self, camera)
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.0.camera
    }

    /// What rays that leave the scene see.
    pub fn background(&self) -> &Background {
        &self.0.background
    }

    /// Image size and sampling where the caller has no other wish.
    pub fn defaults(&self) -> &RenderDefaults {
        &self.0.defaults
    }

    /// All primitives.
    #[doc(hidden)]
    pub fn geometry(&self) -> &Arc<Geometry> {
        &self.0.geometry
    }

    /// All materials.
    pub(crate) fn materials(&self) -> &[Material] {
        &self.0.materials
    }

    /// The material of a primitive.
    pub fn material(&self, primitive: u32) -> &Material {
        &self.0.materials[self.0.material_map.get(primitive) as usize]
    }

    fn material_map(&self) -> &MaterialMap {
        &self.0.material_map
    }

    /// How many pixels its textures have.
    pub(crate) fn texels(&self) -> u64 {
        let mut images: Vec<_> = self.materials().iter().flat_map(Material::images).collect();
        images.sort_unstable_by_key(Arc::as_ptr);
        images.dedup_by_key(|image| Arc::as_ptr(image));
        images.into_iter().map(|image| image.pixels().len() as u64).sum()
    }

    /// How many primitives emit light.
    pub fn lights(&self) -> u32 {
        self.0.lights
    }

    /// What it was loaded within.
    pub(crate) fn limits(&self) -> &Limits {
        &self.0.limits
    }

    /// The media, none of which overlaps another.
    pub(crate) fn media(&self) -> &[Medium] {
        &self.0.media
    }

    /// The sampling of the file, or `mis` where there are lights to sample, else `bsdf`.
    pub(crate) fn default_sampling(&self) -> Sampling {
        let by_lights = if self.0.lights == 0 { Sampling::Bsdf } else { Sampling::Mis };
        self.0.defaults.sampling.unwrap_or(by_lights)
    }
}
