//! Scenes: the description that scene files contain, its checks, and the resolution of its names.

mod assets;
mod description;
mod hash;
mod look;
pub(crate) mod mesh;
mod named;
pub mod primitive;
mod resolve;
mod roulette;
mod warnings;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

pub(crate) use assets::Assets;
pub use description::{RenderDefaults, Sampling, SceneFile};
pub use look::Look;
pub(crate) use mesh::IndexedMesh;
use mesh::{Smooth, Transform, Transformed, add_tangents, lacks_tangents};
pub use named::Named;
use primitive::{Builder, Materials};
pub(crate) use primitive::{InstanceFile, MeshFile, QuadFile, SphereFile, TrianglesFile};
pub use primitive::{NamedMesh, PrimitiveFile};
pub(crate) use resolve::{LIGHT_BYTES, resolve};
pub use roulette::Roulette;

use crate::geometry::Geometry;
use crate::limits::Limits;
use crate::shading::light::LightFile;
use crate::shading::{Background, Camera, CameraFile, Material, Medium, World};

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

#[derive(Clone, Debug, PartialEq)]
struct SceneData {
    name: String,
    camera: Camera,
    camera_file: CameraFile,
    cameras: Named<CameraFile>,
    origin: DVec3,
    defaults: RenderDefaults,
    world: World,
    /// The names of the materials.
    material_names: Vec<String>,
    lights: u32,
    files: BTreeSet<PathBuf>,
    /// Sentences that name the ignored and mended data in the scene's files.
    ignored: Vec<String>,
    limits: Limits,
}

impl Scene {
    /// Adds sentences that name the ignored data of its file.
    pub(crate) fn with_warnings(mut self, warnings: &[String]) -> Self {
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
        hash::hash(self.world(), camera, self.origin())
    }

    /// What rays can meet.
    pub(crate) fn world(&self) -> &World {
        &self.0.world
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

    /// The point (0, 0, 0) in the coordinates of the file that the scene comes from.
    pub fn origin(&self) -> DVec3 {
        self.0.origin
    }

    /// The light that rays see when they leave the scene.
    pub fn background(&self) -> &Background {
        &self.0.world.background
    }

    /// The image size and sampling that apply unless the caller sets others.
    pub fn defaults(&self) -> &RenderDefaults {
        &self.0.defaults
    }

    /// All primitives.
    #[doc(hidden)]
    pub fn geometry(&self) -> &Arc<Geometry> {
        &self.0.world.geometry
    }

    /// All materials.
    pub(crate) fn materials(&self) -> &[Material] {
        &self.0.world.materials
    }

    /// The material of a primitive.
    pub fn material(&self, primitive: u32) -> &Material {
        self.0.world.material(primitive)
    }

    /// The name of the material of a primitive.
    pub fn material_name(&self, primitive: u32) -> &str {
        &self.0.material_names[self.material_number(primitive) as usize]
    }

    /// The index of the material of a primitive.
    pub(crate) fn material_number(&self, primitive: u32) -> u32 {
        self.0.world.material_map.get(primitive)
    }

    /// Whether there are lights that only light samples find.
    pub(crate) fn has_unseen_lights(&self) -> bool {
        self.0.world.lights.iter().any(LightFile::emits)
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
        &self.0.world.media
    }

    /// The sampling that the scene file sets. Otherwise `mis` if the scene has lights, else `bsdf`.
    pub(crate) fn default_sampling(&self) -> Sampling {
        let by_lights = if self.0.lights == 0 { Sampling::Bsdf } else { Sampling::Mis };
        self.0.defaults.sampling.unwrap_or(by_lights)
    }
}
