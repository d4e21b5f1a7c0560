//! Materials: one file each, with its parameters, their checks, its physics and its table.
//!
//! The list in `materials!` makes the enum of scene files, the kinds by which paths are sorted, the
//! tables, and the dispatch.

mod conductor;
mod dielectric;
mod diffuse;
#[cfg(test)]
mod glow;
mod lambertian;
mod light;
mod metal;
mod rough_dielectric;

use std::fmt::Debug;

use serde::{Deserialize, Serialize};

pub(crate) use super::bsdf::{Bsdf, SPECULAR, Scatter};
pub use super::emission::{Emission, Sides};
pub use dielectric::Fresnel;

use super::interaction::Interaction;
use super::place::Element;
use super::texture::{Color, TextureTables};
use crate::error::Result;
use crate::math::Real;

/// What a kind of material is: parameters, a table, and physics.
pub(crate) trait MaterialModel {
    /// The parameters as they lie in the table of the kind.
    type Entry: Copy + Debug + Send + Sync;
    /// How it scatters light at a point.
    type Bsdf<R: Real>: Bsdf<R> + 'static;

    /// Whether it scatters light at all.
    const SCATTERS: bool = true;
    /// Whether a parameter may be a texture.
    const TEXTURED: bool = false;

    /// The colours that may be textures.
    fn colors(&mut self) -> Vec<&mut Color> {
        Vec::new()
    }

    /// The light that it emits.
    fn emission(&self) -> Option<Emission> {
        None
    }

    /// Checks the parameters.
    fn check(&self, e: &Element<'_>) -> Result<()>;

    /// The parameters for the table, their textures for `textures`.
    fn entry(&self, textures: &mut TextureTables) -> Self::Entry;

    /// How the entries at `index` scatter light at `at`.
    fn bsdf<R: Real>(
        table: &[Self::Entry],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> Self::Bsdf<R>;
}

/// What to do with a material of any kind.
pub(crate) trait MaterialVisitor {
    /// The result.
    type Output;

    /// Called with the kind and its table.
    fn visit<M: MaterialModel>(self, table: &MaterialTable<M::Entry>) -> Self::Output;
}

/// The materials of a kind.
#[derive(Debug)]
pub(crate) struct MaterialTable<E> {
    pub(crate) entries: Vec<E>,
    /// Whether any of them has a texture.
    pub(crate) textured: bool,
}

impl<E> Default for MaterialTable<E> {
    fn default() -> Self {
        Self { entries: Vec::new(), textured: false }
    }
}

macro_rules! materials {
    ($($(#[doc = $doc:literal])* $(#[cfg($cfg:meta)])? $name:ident in $module:ident,)*) => {
        $($(#[cfg($cfg)])? pub use $module::$name;)*

        /// How a surface scatters and emits light.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        #[non_exhaustive]
        pub enum Material {
            $($(#[doc = $doc])* $(#[cfg($cfg)])? $name($name),)*
        }

        $($(#[cfg($cfg)])?
        impl From<$name> for Material {
            fn from(material: $name) -> Self {
                Self::$name(material)
            }
        })*

        /// The kinds of materials.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum MaterialKind {
            $($(#[cfg($cfg)])? $name,)*
        }

        /// The materials of a scene, a table a kind.
        #[derive(Debug, Default)]
        pub(crate) struct MaterialTables {
            $($(#[cfg($cfg)])? $module: MaterialTable<<$name as MaterialModel>::Entry>,)*
        }

        impl Material {
            pub(super) fn colors(&mut self) -> Vec<&mut Color> {
                match self {
                    $($(#[cfg($cfg)])? Self::$name(material) => material.colors(),)*
                }
            }

            pub(super) fn check(&self, e: &Element<'_>) -> Result<()> {
                match self {
                    $($(#[cfg($cfg)])? Self::$name(material) => material.check(e),)*
                }
            }

            /// The light that it emits, if any.
            pub fn emission(&self) -> Option<Emission> {
                match self {
                    $($(#[cfg($cfg)])? Self::$name(material) => material.emission(),)*
                }
            }

            /// The name of its kind in scene files.
            pub fn name(&self) -> &'static str {
                match self {
                    $($(#[cfg($cfg)])? Self::$name(_) => stringify!($module),)*
                }
            }

            pub(crate) fn kind(&self) -> MaterialKind {
                match self {
                    $($(#[cfg($cfg)])? Self::$name(_) => MaterialKind::$name,)*
                }
            }
        }

        impl MaterialTables {
            /// Adds a material; returns its place in the table of its kind.
            pub(crate) fn push(&mut self, material: &Material, textures: &mut TextureTables) -> u32 {
                match material {
                    $($(#[cfg($cfg)])? Material::$name(material) => {
                        let before = textures.uses();
                        let table = &mut self.$module;
                        table.entries.push(material.entry(textures));
                        table.textured |= textures.uses() > before;
                        assert!($name::TEXTURED || !table.textured, "it says that it has no texture");
                        table.entries.len() as u32 - 1
                    })*
                }
            }

            /// Calls `visitor` with a kind.
            #[inline(always)]
            pub(crate) fn visit<V: MaterialVisitor>(
                &self,
                kind: MaterialKind,
                visitor: V,
            ) -> V::Output {
                match kind {
                    $($(#[cfg($cfg)])? MaterialKind::$name => visitor.visit::<$name>(&self.$module),)*
                }
            }
        }
    };
}

materials! {
    /// The report's ideal diffuse.
    Diffuse in diffuse,
    /// Lambert's law.
    Lambertian in lambertian,
    /// The report's metal.
    Metal in metal,
    /// Clear glass.
    Dielectric in dielectric,
    /// Frosted glass.
    RoughDielectric in rough_dielectric,
    /// A metal given by its index of refraction.
    Conductor in conductor,
    /// A light, which absorbs what hits it.
    Light in light,
    /// Scatters and emits, for tests.
    #[cfg(test)]
    Glow in glow,
}

impl Material {
    /// The images of its textures, once it is part of a scene.
    pub(super) fn images(&self) -> Vec<std::sync::Arc<crate::image::Image>> {
        self.clone().colors().into_iter().filter_map(|color| color.image()).collect()
    }
}
