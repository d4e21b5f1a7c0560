//! The schema of scene files in `.ron` and `.json`, read and written by serde.
//!
//! Lengths are in the scene's unit, angles in degrees and colours in linear RGB. The numbers are
//! checked later, in `resolve`.

use serde::{Deserialize, Serialize};

use super::{Named, NamedMesh, PrimitiveFile, Roulette, SphereFile, TrianglesFile};
use crate::shading::light::LightFile;
use crate::shading::{Background, CameraFile, Material, MediumFile, Texture};

/// A whole scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct SceneFile {
    /// The camera.
    pub camera: CameraFile,
    /// More cameras by name, which a render can choose instead.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub cameras: Named<CameraFile>,
    /// The point (0, 0, 0) in the coordinates of the file that the scene comes from. Those of the scene are smaller,
    /// and so have more bits. Arguments and reports use the coordinates of the file.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub origin: [f64; 3],
    /// Light that arrives along rays that leave the scene.
    #[serde(default)]
    pub background: Background,
    /// Default image size and sampling.
    #[serde(default)]
    pub render: RenderDefaults,
    /// Textures by name.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub textures: Named<Texture>,
    /// Materials by name.
    #[serde(default)]
    pub materials: Named<Material>,
    /// Meshes by name, which instances place.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub meshes: Named<NamedMesh>,
    /// The primitives, and groups of primitives.
    #[serde(default)]
    pub primitives: Vec<PrimitiveFile>,
    /// Lights that are not primitives.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<LightFile>,
    /// Participating media, which must not overlap.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub media: Vec<MediumFile>,
}

fn is_zero(origin: &[f64; 3]) -> bool {
    *origin == [0.0; 3]
}

impl SceneFile {
    /// Creates a scene without primitives and with a black background.
    pub fn new(camera: CameraFile) -> Self {
        Self {
            camera,
            cameras: Named::default(),
            origin: [0.0; 3],
            background: Background::default(),
            render: RenderDefaults::default(),
            textures: Named::default(),
            materials: Named::default(),
            meshes: Named::default(),
            primitives: Vec::new(),
            lights: Vec::new(),
            media: Vec::new(),
        }
    }

    /// Adds a camera that a render can choose by its name, which no other camera may have.
    pub fn add_camera(&mut self, name: impl Into<String>, camera: CameraFile) {
        self.cameras.0.push((name.into(), camera));
    }

    /// Adds a texture. Materials refer to it by its name, which no other texture may have.
    pub fn add_texture(&mut self, name: impl Into<String>, texture: impl Into<Texture>) {
        self.textures.0.push((name.into(), texture.into()));
    }

    /// Adds a material. Primitives refer to it by its name, which no other material may have.
    pub fn add_material(&mut self, name: impl Into<String>, material: impl Into<Material>) {
        self.materials.0.push((name.into(), material.into()));
    }

    /// Adds a mesh that instances place. They refer to it by its name, which no other mesh may have.
    pub fn add_named_mesh(&mut self, name: impl Into<String>, mesh: impl Into<NamedMesh>) {
        self.meshes.0.push((name.into(), mesh.into()));
    }

    /// Adds a sphere.
    pub fn add_sphere(&mut self, center: [f32; 3], radius: f32, material: impl Into<String>) {
        self.add(SphereFile { center, radius, material: material.into() });
    }

    /// Adds a triangle mesh. `triangles` has three indices into `vertices` for each triangle,
    /// counter-clockwise as seen from its front.
    pub fn add_mesh(
        &mut self,
        vertices: &[[f32; 3]],
        triangles: &[[u32; 3]],
        material: impl Into<String>,
    ) {
        self.add(TrianglesFile::new(vertices.to_vec(), triangles.to_vec(), material));
    }

    /// Adds a primitive of any kind; see [`primitive`](crate::primitive).
    pub fn add(&mut self, primitive: impl Into<PrimitiveFile>) {
        self.primitives.push(primitive.into());
    }
}

/// Default settings of a render of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct RenderDefaults {
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Samples per pixel.
    pub spp: u32,
    /// Largest number of segments of a path.
    pub depth: u32,
    /// Which paths Russian roulette may end.
    pub roulette: Roulette,
    /// How paths find light. Without a value, the default is `mis` if the scene has lights that can
    /// be sampled, else `bsdf`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampling: Option<Sampling>,
}

impl Default for RenderDefaults {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            spp: 100,
            depth: 50,
            roulette: Roulette::Auto,
            sampling: None,
        }
    }
}

/// How a path finds light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Paths find light by scattering alone. A light counts only if a path happens to hit it.
    Bsdf,
    /// Paths trace a shadow ray to a light from every non-specular surface and every collision in
    /// a medium.
    Light,
    /// Both ways are combined, weighted with the power heuristic (Veach 1997, section 9.2.4).
    Mis,
}

names! { pub Sampling: Bsdf = "bsdf", Light = "light", Mis = "mis" }
