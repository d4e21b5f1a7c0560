//! Scenes: loaded by name or from a file, and checked, with all names resolved to indices.

mod affine;
mod background;
mod bsdf;
mod budget;
mod builtin;
mod camera;
mod description;
mod emission;
mod files;
mod filter;
mod generate;
mod gltf;
mod hash;
mod holes;
mod import;
mod interaction;
pub mod light;
mod load;
mod locate;
mod looks;
pub mod material;
mod medium;
mod mesh;
mod named;
mod normal_map;
mod opacity;
mod parse;
mod place;
pub mod primitive;
mod resolve;
mod smooth;
mod tables;
pub mod texture;
mod view;
mod warnings;
mod within;

pub use background::Background;
pub use builtin::BUILTIN_NAMES;
pub use camera::Camera;
pub(crate) use camera::CameraFrame;
pub use description::{CameraFile, RenderDefaults, Sampling, SceneFile};
#[cfg(test)]
pub(crate) use filter::FilterTable;
pub use filter::PixelFilter;
pub(crate) use import::{ImportOptions, Missing};
#[cfg(test)]
pub(crate) use interaction::Interaction;
use light::LightFile;
pub(crate) use light::LightSample;
pub(crate) use load::Parsed;
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
pub use primitive::{NamedMesh, PrimitiveFile};
pub(crate) use resolve::LIGHT_BYTES;
pub(crate) use tables::SceneTables;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use looks::MaterialMap;

use crate::error::Result;
use crate::geometry::Geometry;
use crate::limits::Limits;

/// A scene that can be rendered: all names are resolved to indices, and every number is in its
/// range.
///
/// Scenes are immutable, and clones share their data.
#[derive(Clone, Debug)]
pub struct Scene(Arc<SceneData>);

impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        // Comparing pointers is enough for clones, which share their data.
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

#[derive(Debug, PartialEq)]
struct SceneData {
    name: String,
    camera: Camera,
    camera_file: CameraFile,
    cameras: Named<CameraFile>,
    background: Background,
    defaults: RenderDefaults,
    materials: Vec<Material>,
    geometry: Arc<Geometry>,
    material_map: MaterialMap,
    light_files: Vec<LightFile>,
    lights: u32,
    media: Vec<Medium>,
    files: BTreeSet<PathBuf>,
    /// Sentences that name the ignored data in the scene's files.
    ignored: Vec<String>,
    limits: Limits,
}

impl Scene {
    /// Loads the built-in scene with this name, generates `cloud:N`, `mesh:N` or `forest:N`, or reads the file
    /// at this path: a scene (`.ron` or `.json`) or a mesh (`.obj` or
    /// `.ply`).
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
        parse::from_ron("scene", text).and_then(|file| Self::from_file(&file))
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
        let budget = budget::Budget::new(limits, 0);
        resolve::resolve("scene", folder, file, budget)
    }

    /// Adds sentences that name the ignored data of its file.
    fn with_warnings(mut self, warnings: &[String]) -> Self {
        if let Some(data) = Arc::get_mut(&mut self.0) {
            data.ignored.splice(0..0, warnings.iter().cloned());
        }
        self
    }

    /// The name or path that the scene was loaded by, or `scene` if it was not loaded.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// The paths of the mesh and texture files that the scene has read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.0.files.iter().map(PathBuf::as_path)
    }

    /// BLAKE3 over everything that the scene's images depend on, in hexadecimal. It is the same for
    /// all file forms and all choices of names that describe the same scene.
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

    /// The camera as written in the scene file.
    pub fn camera_file(&self) -> &CameraFile {
        &self.0.camera_file
    }

    /// The named cameras as written in the scene file. All their values are in range.
    pub fn cameras(&self) -> &Named<CameraFile> {
        &self.0.cameras
    }

    /// The light that rays see when they leave the scene.
    pub fn background(&self) -> &Background {
        &self.0.background
    }

    /// The image size and sampling that apply unless the caller sets others.
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

    /// Bytes of all textures and the environment map. An image that several materials share counts once.
    pub(crate) fn texture_bytes(&self) -> u64 {
        let mut images: Vec<_> = self.materials().iter().flat_map(Material::images).collect();
        if let Background::Image(map) = self.background() {
            images.push(Arc::clone(map.texels()));
        }
        images.sort_unstable_by_key(Arc::as_ptr);
        images.dedup_by_key(|image| Arc::as_ptr(image));
        images.into_iter().map(|image| image.bytes()).sum()
    }

    /// The lights that are not primitives.
    fn light_files(&self) -> &[LightFile] {
        &self.0.light_files
    }

    /// Whether there are lights that only light samples find.
    pub(crate) fn has_unseen_lights(&self) -> bool {
        self.light_files().iter().any(LightFile::shines)
    }

    /// Number of lights: primitives that emit light, other lights, and an environment map.
    pub fn lights(&self) -> u32 {
        self.0.lights
    }

    /// The limits that the scene was loaded with.
    pub(crate) fn limits(&self) -> &Limits {
        &self.0.limits
    }

    /// The media, which do not overlap.
    pub(crate) fn media(&self) -> &[Medium] {
        &self.0.media
    }

    /// The sampling that the scene file sets. Otherwise `mis` if the scene has lights, else `bsdf`.
    pub(crate) fn default_sampling(&self) -> Sampling {
        let by_lights = if self.0.lights == 0 { Sampling::Bsdf } else { Sampling::Mis };
        self.0.defaults.sampling.unwrap_or(by_lights)
    }
}
