//! Materials, one file per kind with its parameters, their checks, its physics and its table.
//!
//! The list in `materials!` generates the enum of scene files, the kinds by which paths are sorted,
//! and the tables.

/// The methods of [`MaterialParameters`] for textures: those of the named parameters, and those of
/// the fields `normal` and `opacity`.
macro_rules! texture_methods {
    ($($parameter:ident),* $(; $($map:ident),*)?) => {
        fn textures(&mut self) -> Vec<&mut TextureRef> {
            let opacity = self.opacity.as_mut().and_then(Opacity::reference);
            let textures = [
                $(self.$parameter.reference(),)*
                $($(self.$map.as_mut(),)*)?
                self.normal.as_mut(),
                opacity,
            ];
            textures.into_iter().flatten().collect()
        }

        fn normal(&self) -> Option<&TextureRef> {
            self.normal.as_ref()
        }

        fn opacity(&self) -> Option<&Opacity> {
            self.opacity.as_ref()
        }

        fn opacity_mut(&mut self) -> Option<&mut Option<Opacity>> {
            Some(&mut self.opacity)
        }
    };
}

mod coated_diffuse;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_transmission;
mod lambertian;
mod light;
mod metal;
mod model;
mod principled;
mod rough_dielectric;
mod table;

use std::sync::Arc;

pub use dielectric::Fresnel;
pub(crate) use model::MaterialModel;
use model::MaterialParameters;
pub(crate) use table::{MaterialTable, MaterialVisitor};

pub(crate) use super::bsdf::{Bsdf, SPECULAR, Scatter};
pub use super::emission::{Emission, Sides};
use super::kinds::kinds;
pub use super::opacity::Opacity;
use super::{Bodies, TextureRef, TextureTables};
use crate::checks::Location;
use crate::error::Result;
use crate::image::Texels;

macro_rules! materials {
    ($($(#[$doc:meta])* $name:ident in $module:ident,)*) => {
        kinds! {
            /// How a surface scatters and emits light.
            // A scene has few materials.
            #[allow(clippy::large_enum_variant)]
            pub enum Material: pub(crate) MaterialParameters {
                $($(#[$doc])* $name($name) in $module called stringify!($module),)*
            }
        }

        /// The kinds of materials.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum MaterialKind {
            $($name,)*
        }

        /// The materials of a scene, one table per kind.
        #[derive(Debug, Default)]
        pub(crate) struct MaterialTables {
            $($module: MaterialTable<<$name as MaterialModel>::Entry>,)*
        }

        impl Material {
            pub(crate) fn kind(&self) -> MaterialKind {
                match self {
                    $(Self::$name(_) => MaterialKind::$name,)*
                }
            }

            pub(crate) fn model_mut(&mut self) -> &mut dyn MaterialParameters {
                match self {
                    $(Self::$name(material) => material,)*
                }
            }
        }

        impl MaterialTables {
            /// Adds a material and returns its index in the table of its kind.
            pub(crate) fn push(
                &mut self,
                material: &Material,
                textures: &mut TextureTables,
                bodies: &mut Bodies,
            ) -> u32 {
                match material {
                    $(Material::$name(material) => self.$module.push(material, textures, bodies),)*
                }
            }

            /// Calls `visitor` with the table of `kind`.
            #[inline(always)]
            pub(crate) fn visit<V: MaterialVisitor>(
                &self,
                kind: MaterialKind,
                visitor: V,
            ) -> V::Output {
                match kind {
                    $(MaterialKind::$name => visitor.visit::<$name>(&self.$module),)*
                }
            }
        }
    };
}

materials! {
    /// The report's ideal diffuse material.
    Diffuse in diffuse,
    /// A thin matte surface that also lets light through.
    DiffuseTransmission in diffuse_transmission,
    /// A matte surface that follows Lambert's law.
    Lambertian in lambertian,
    /// The report's metal.
    Metal in metal,
    /// Clear, smooth glass.
    Dielectric in dielectric,
    /// Frosted glass.
    RoughDielectric in rough_dielectric,
    /// A metal with a complex index of refraction.
    Conductor in conductor,
    /// A matte surface below a clear coat.
    CoatedDiffuse in coated_diffuse,
    /// A surface between matte, metal and glass, with a clear coat.
    Principled in principled,
    /// A surface that emits light and absorbs all light that hits it.
    Light in light,
}

/// Checks that the map in this field is a texture that contains normals, or other directions.
fn check_normals(normal: &TextureRef, field: &str, e: &Location<'_>) -> Result<()> {
    match normal.get().model().holds_normals() {
        true => Ok(()),
        false => Err(e.error(format!(
            "{field} must be the name of an `image` texture with `encoding: linear` and `uv: 0`",
        ))),
    }
}

impl Material {
    pub(crate) fn check(&self, e: &Location<'_>) -> Result<()> {
        let model = self.model();
        model.normal().map_or(Ok(()), |normal| check_normals(normal, "normal", e))?;
        model.opacity().map_or(Ok(()), |opacity| opacity.check(e))?;
        model.check(e)
    }

    /// Whether rays always pass the surface, because its opacity is 0.
    pub(crate) fn is_invisible(&self) -> bool {
        let zero = |alpha: &super::Number| match alpha {
            super::Number::Value(alpha) => *alpha == 0.0,
            super::Number::Texture { factor, .. } => *factor == 0.0,
        };
        matches!(self.model().opacity(), Some(Opacity::Blend { alpha }) if zero(alpha))
    }

    /// Returns all references to textures.
    pub(crate) fn textures(&mut self) -> Vec<&mut TextureRef> {
        self.model_mut().textures()
    }

    /// Returns the light that the material emits, if any, and if it is the same everywhere.
    pub fn emission(&self) -> Option<Emission> {
        self.model().emission()
    }

    /// Whether the material emits light.
    pub(crate) fn emits(&self) -> bool {
        self.emission().is_some_and(|emission| emission.emits())
            || self.model().varied_emission().is_some()
    }

    /// Whether a texture of the material depends on the colours of vertices.
    pub(crate) fn uses_vertex_colors(&self) -> bool {
        let uses = |texture: &mut TextureRef| {
            texture.unnamed().is_some_and(|texture| texture.model().uses_vertex_colors())
        };
        self.clone().textures().into_iter().any(uses)
    }

    /// Returns the images of the material's textures, once they are loaded.
    pub(crate) fn images(&self) -> Vec<Arc<Texels>> {
        let image = |texture: &mut TextureRef| texture.get().model().texels().cloned();
        self.clone().textures().into_iter().filter_map(image).collect()
    }
}
