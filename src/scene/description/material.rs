//! Textures and materials in a scene file.

use serde::{Deserialize, Serialize};

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

/// A colour, or the name of a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum Albedo {
    /// Linear RGB, each in [0, 1].
    Color([f32; 3]),
    /// A key of [`SceneFile::textures`](super::SceneFile::textures).
    Texture(String),
}
