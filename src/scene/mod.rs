//! Scenes: from a name or file to checked, index-based data.

mod alias;
mod boxes;
mod budget;
mod builtin;
mod camera;
mod description;
mod flat;
mod generate;
mod hash;
mod light;
mod load;
mod material;
mod medium;
mod mesh;
mod named;
mod nesting;
mod obj;
mod parse;
mod place;
mod ply;
mod resolve;
mod texture;

pub use alias::AliasTable;
pub(crate) use alias::Cell;
pub use builtin::BUILTIN_NAMES;
pub use camera::{Camera, CameraFrame, CameraSample};
pub use description::{
    Albedo, BackgroundFile, CameraFile, MaterialFile, MediumFile, PrimitiveFile, RenderDefaults,
    Sampling, SceneFile, TextureFile,
};
pub use generate::Generated;
pub use light::{Light, LightShape, Lights, QuadLight, TriangleLight};
pub use load::{Form, Parsed, Source};
pub use material::{Background, Emission, Fresnel, Material, Sides};
pub use medium::Medium;
pub use named::Named;
pub use texture::{Checker, Texture};

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::Result;
use crate::geometry::Geometry;
use crate::limits::Limits;

/// A scene that can be rendered: names are resolved to indices, and every number is in its range.
///
/// Scenes do not change, and clones share their data.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene(Arc<SceneData>);

#[derive(Debug, PartialEq)]
struct SceneData {
    name: String,
    camera: Camera,
    background: Background,
    defaults: RenderDefaults,
    textures: Vec<Texture>,
    materials: Vec<Material>,
    geometry: Arc<Geometry>,
    material_of: Vec<u32>,
    lights: Lights,
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
    /// As [`load`](Self::load), and where a limit is exceeded: it is named, and how it is raised.
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

    /// The scene that `file` describes; textures are relative to the current folder.
    ///
    /// # Errors
    /// Where a number is out of range or a name unknown.
    pub fn from_file(file: &SceneFile) -> Result<Self> {
        let budget = budget::Budget::new(&Limits::default(), 0);
        resolve::resolve("scene", Path::new(""), file, &place::Places::default(), budget)
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
    pub fn hash_with(&self, camera: &Camera) -> String {
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
    pub fn geometry(&self) -> &Arc<Geometry> {
        &self.0.geometry
    }

    /// All materials.
    pub fn materials(&self) -> &[Material] {
        &self.0.materials
    }

    /// All textures.
    pub fn textures(&self) -> &[Texture] {
        &self.0.textures
    }

    /// The material of a primitive.
    #[inline]
    pub fn material(&self, primitive: u32) -> &Material {
        &self.0.materials[self.material_index(primitive) as usize]
    }

    /// The place of a primitive's material in [`Scene::materials`].
    #[inline]
    pub fn material_index(&self, primitive: u32) -> u32 {
        self.0.material_of[primitive as usize]
    }

    /// [`Self::material_index`] of all primitives.
    pub(crate) fn material_indices(&self) -> &[u32] {
        &self.0.material_of
    }

    /// The lights.
    pub fn lights(&self) -> &Lights {
        &self.0.lights
    }

    /// What it was loaded within.
    pub fn limits(&self) -> &Limits {
        &self.0.limits
    }

    /// The media, none of which overlaps another.
    pub fn media(&self) -> &[Medium] {
        &self.0.media
    }

    /// The sampling of the file, or `mis` where there are lights to sample, else `bsdf`.
    pub fn default_sampling(&self) -> Sampling {
        let by_lights = if self.0.lights.is_empty() { Sampling::Bsdf } else { Sampling::Mis };
        self.0.defaults.sampling.unwrap_or(by_lights)
    }
}
