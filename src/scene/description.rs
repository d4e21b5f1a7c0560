//! What a scene file says: the schema of `.ron` and `.json`, read and written by serde.
//!
//! Lengths are in the scene's unit, angles in degrees, colours linear RGB. Numbers are
//! checked in [`super::resolve`], which knows what they mean.

use serde::{Deserialize, Serialize};

use super::named::Named;

/// A whole scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// The viewer.
    pub camera: CameraFile,
    /// What rays that leave the scene see.
    #[serde(default)]
    pub background: BackgroundFile,
    /// Image size and sampling where the command line names none.
    #[serde(default)]
    pub render: RenderDefaults,
    /// Textures by name.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub textures: Named<TextureFile>,
    /// Materials by name.
    #[serde(default)]
    pub materials: Named<MaterialFile>,
    /// The geometry.
    #[serde(default)]
    pub primitives: Vec<PrimitiveFile>,
    /// Media, none of which overlaps another.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub media: Vec<MediumFile>,
}

/// A thin-lens camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraFile {
    /// Centre of the lens.
    pub look_from: [f32; 3],
    /// Point in the middle of the image.
    pub look_at: [f32; 3],
    /// A direction that is up in the image.
    #[serde(default = "CameraFile::default_up")]
    pub up: [f32; 3],
    /// Full vertical angle of view, (0, 180).
    pub vfov: f32,
    /// Apex angle of the cone from a point in focus to the lens, [0, 180); 0 is a pinhole.
    #[serde(default)]
    pub defocus_angle: f32,
    /// Distance of the plane in focus.
    #[serde(default = "CameraFile::default_focus_distance")]
    pub focus_distance: f32,
    /// Times at which the shutter opens and closes, within [0, 1].
    #[serde(default)]
    pub shutter: (f32, f32),
}

impl CameraFile {
    fn default_up() -> [f32; 3] {
        [0.0, 1.0, 0.0]
    }

    fn default_focus_distance() -> f32 {
        10.0
    }
}

/// Radiance from outside the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum BackgroundFile {
    /// The same in all directions.
    Constant {
        /// Linear RGB.
        radiance: [f32; 3],
    },
    /// From `bottom` straight down to `top` straight up, linear in the height of the
    /// unit direction.
    Gradient {
        /// Linear RGB at direction −y.
        bottom: [f32; 3],
        /// Linear RGB at direction +y.
        top: [f32; 3],
    },
}

impl Default for BackgroundFile {
    fn default() -> Self {
        Self::Constant { radiance: [0.0; 3] }
    }
}

/// Defaults of `render`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RenderDefaults {
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Samples a pixel.
    pub spp: u32,
    /// Largest number of segments of a path.
    pub depth: u32,
    /// How lights are found; `mis` where the scene has lights that can be sampled, else
    /// `bsdf`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampling: Option<Sampling>,
}

impl Default for RenderDefaults {
    fn default() -> Self {
        Self { width: 1280, height: 720, spp: 100, depth: 50, sampling: None }
    }
}

/// How a path finds light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// By scattering alone: light counts where a path happens to hit it.
    Bsdf,
    /// By a shadow ray to a light from every surface that is not specular, and out of media.
    Light,
    /// By both, weighted with the power heuristic (Veach 1997, section 9.2.4).
    Mis,
}

impl Sampling {
    /// All ways.
    pub const ALL: [Self; 3] = [Self::Bsdf, Self::Light, Self::Mis];

    /// The name on the command line and in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bsdf => "bsdf",
            Self::Light => "light",
            Self::Mis => "mis",
        }
    }
}

/// A colour that varies over a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum TextureFile {
    /// One colour.
    Solid {
        /// Linear RGB.
        color: [f32; 3],
    },
    /// A 3-D checker: `odd` where sin(sx)·sin(sy)·sin(sz) < 0 with s = `scale`, else `even`.
    Checker {
        /// Linear RGB.
        odd: [f32; 3],
        /// Linear RGB.
        even: [f32; 3],
        /// Cells have the side π/scale.
        scale: f32,
    },
    /// A picture over the surface's texture coordinates.
    Image {
        /// Path, relative to the scene file.
        file: String,
    },
}

/// How a surface scatters light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum MaterialFile {
    /// The report's ideal diffuse (III.B): uniform over the hemisphere, weight `albedo`.
    Diffuse {
        /// Colour or texture.
        albedo: Albedo,
    },
    /// Cosine-distributed (III.C), weight `albedo`.
    Lambertian {
        /// Colour or texture.
        albedo: Albedo,
    },
    /// Mirror whose direction is moved by `fuzz` times a point of the unit ball (III.D).
    Metal {
        /// Colour or texture.
        albedo: Albedo,
        /// 0 (mirror) to 1.
        #[serde(default)]
        fuzz: f32,
    },
    /// Clear glass in air (III.E).
    Dielectric {
        /// Index of refraction relative to air, 0.01 to 100.
        ior: f32,
        /// How much is reflected.
        #[serde(default)]
        fresnel: Fresnel,
    },
    /// Frosted glass in air: GGX microfacets, exact Fresnel equations.
    RoughDielectric {
        /// Index of refraction relative to air, 0.01 to 100 but for 0.99 to 1.01.
        ior: f32,
        /// Roughness α of GGX, 0.001 to 1.
        alpha: f32,
    },
    /// Metal by its complex index of refraction, smooth or with GGX microfacets.
    Conductor {
        /// Real part, a channel each, 0 to 100.
        eta: [f32; 3],
        /// Imaginary part, a channel each, 0 to 100.
        k: [f32; 3],
        /// Roughness α of GGX: 0 (mirror), or 0.001 to 1.
        #[serde(default)]
        alpha: f32,
    },
    /// A light, which absorbs what hits it (III.G).
    Light {
        /// Linear RGB radiance.
        radiance: [f32; 3],
        /// The sides that shine.
        #[serde(default)]
        sides: Sides,
    },
}

/// How much a dielectric reflects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fresnel {
    /// Schlick's approximation, from the angle on either side (the report's).
    #[default]
    Schlick,
    /// The Fresnel equations.
    Exact,
}

/// The sides of a surface that shine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// Both.
    #[default]
    Both,
    /// The side that the normal points to.
    Front,
}

/// A homogeneous medium that scatters light to all sides alike, in a volume whose boundary is
/// invisible.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum MediumFile {
    /// In a ball.
    Sphere {
        /// Centre.
        center: [f32; 3],
        /// Radius, above 0 to 1e9.
        radius: f32,
        /// Extinction coefficient: collisions a unit of length, above 0 to 1e6.
        density: f32,
        /// The share of light that is scattered, not absorbed: linear RGB, each in [0, 1].
        albedo: [f32; 3],
    },
    /// In a box.
    Box {
        /// Lower corner before rotation.
        min: [f32; 3],
        /// Upper corner before rotation.
        max: [f32; 3],
        /// Right-handed angles about x, then y, then z, through the middle of the box.
        #[serde(default)]
        rotation: [f32; 3],
        /// Extinction coefficient: collisions a unit of length, above 0 to 1e6.
        density: f32,
        /// The share of light that is scattered, not absorbed: linear RGB, each in [0, 1].
        albedo: [f32; 3],
    },
}

/// A colour, or the name of a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum Albedo {
    /// Linear RGB, each in [0, 1].
    Color([f32; 3]),
    /// A key of [`SceneFile::textures`].
    Texture(String),
}

/// A primitive, or a group that is expanded into primitives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum PrimitiveFile {
    /// A still sphere.
    Sphere {
        /// Centre.
        center: [f32; 3],
        /// Radius, above 0.
        radius: f32,
        /// A key of [`SceneFile::materials`].
        material: String,
    },
    /// A sphere that moves linearly.
    MovingSphere {
        /// Centre at time 0.
        center: [f32; 3],
        /// Centre at time 1.
        center1: [f32; 3],
        /// Radius, above 0.
        radius: f32,
        /// A key of [`SceneFile::materials`].
        material: String,
    },
    /// The parallelogram q + a u + b v, a and b in [0, 1]; its front is the side of u × v.
    Quad {
        /// Corner.
        q: [f32; 3],
        /// Edge.
        u: [f32; 3],
        /// Edge.
        v: [f32; 3],
        /// A key of [`SceneFile::materials`].
        material: String,
    },
    /// A box of six quads.
    Box {
        /// Lower corner before rotation.
        min: [f32; 3],
        /// Upper corner before rotation.
        max: [f32; 3],
        /// Right-handed angles about x, then y, then z, through the middle of the box.
        #[serde(default)]
        rotation: [f32; 3],
        /// A key of [`SceneFile::materials`].
        material: String,
    },
    /// A list of triangles; their front is where they run counter-clockwise. Those without
    /// area are left out.
    Triangles {
        /// Points.
        vertices: Vec<[f32; 3]>,
        /// Three positions in `vertices` each, from 0.
        indices: Vec<[u32; 3]>,
        /// A key of [`SceneFile::materials`].
        material: String,
    },
    /// The triangles of an OBJ or PLY file: its positions and faces, nothing else. Polygons
    /// become fans; triangles without area are left out.
    Mesh {
        /// Path, relative to the scene file.
        file: String,
        /// Factor about the origin, above 0, before the rotation.
        #[serde(default = "PrimitiveFile::default_scale")]
        scale: f32,
        /// Right-handed angles about x, then y, then z, through the origin.
        #[serde(default)]
        rotation: [f32; 3],
        /// Added last.
        #[serde(default)]
        translation: [f32; 3],
        /// A key of [`SceneFile::materials`].
        material: String,
    },
}

impl PrimitiveFile {
    fn default_scale() -> f32 {
        1.0
    }

    /// The variant's name in files, and its material.
    pub(super) fn kind_and_material(&self) -> (&'static str, &str) {
        match self {
            Self::Sphere { material, .. } => ("sphere", material),
            Self::MovingSphere { material, .. } => ("moving_sphere", material),
            Self::Quad { material, .. } => ("quad", material),
            Self::Box { material, .. } => ("box", material),
            Self::Triangles { material, .. } => ("triangles", material),
            Self::Mesh { material, .. } => ("mesh", material),
        }
    }
}
