//! The physics of light: materials, textures, lights, media, the background and the camera.
//!
//! Each kind of material, texture and light has a file with its parameters in scene files, their checks, its
//! entries in a table, and its formulas, which are written once for both engines.

mod around;
mod background;
mod bodies;
mod bsdf;
mod camera;
mod emission;
mod glow;
mod holes;
mod images;
mod interaction;
mod kinds;
pub mod light;
mod light_radiance;
mod looks;
pub mod material;
mod material_map;
mod medium;
mod normal_map;
mod opacity;
mod panes;
mod scatter_normals;
mod smooth;
mod tables;
pub mod texture;
mod world;

pub use background::Background;
use bodies::Bodies;
pub(crate) use bodies::Nesting;
use bsdf::{Bsdf, SPECULAR, Scatter};
pub(crate) use camera::CameraFrame;
#[cfg(test)]
pub(crate) use camera::FilterTable;
pub use camera::{Camera, CameraFile, PixelFilter};
pub(crate) use emission::Sides;
use emission::{Emission, LUMINANCE, luminance};
pub(crate) use holes::mark_holes;
use images::ImageFile;
pub(crate) use images::{ImageContainer, ImageFiles, Images};
pub(crate) use interaction::Interaction;
pub(crate) use kinds::kinds;
pub(crate) use looks::{Key, Looks};
pub(crate) use material::Material;
pub(crate) use material_map::MaterialMap;
#[cfg(test)]
pub(crate) use medium::Isotropic;
use medium::Media;
pub(crate) use medium::Medium;
pub use medium::MediumFile;
pub(crate) use opacity::Opacity;
pub(crate) use panes::{Beyond, MOST_PANES};
use scatter_normals::LEAST_COSINE;
pub(crate) use scatter_normals::ScatterNormals;
pub(crate) use tables::SceneTables;
pub(crate) use texture::{Color, Number, Texture, TextureRef};
use texture::{TexturePoint, TextureTables};
pub(crate) use world::World;
